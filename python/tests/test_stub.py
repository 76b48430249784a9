"""The docstrings of the stub, which editors show, equal those of the Rust half, which ``help``
shows.

``LARIAT_WRITE_STUB=1 pytest tests/test_stub.py`` regenerates the stub.
"""

from __future__ import annotations

import ast
import inspect
import os
from pathlib import Path
from typing import Any

import lariat
from lariat import _native

STUB = Path(__file__).parents[1] / "lariat" / "_native.pyi"
Documented = (ast.ClassDef, ast.FunctionDef)


def documented(nodes: list[ast.stmt], of: Any, name: str = "") -> list[tuple[ast.ClassDef | ast.FunctionDef, str, str]]:
    """Each class, function and method of the stub, with its name and the Rust half's docstring."""
    found = []
    for node in nodes:
        if not isinstance(node, Documented) or node.name.startswith("_"):
            continue
        own = inspect.getattr_static(of, node.name)
        found.append((node, f"{name}{node.name}", inspect.cleandoc(own.__doc__ or "")))
        if isinstance(node, ast.ClassDef):
            found += documented(node.body, own, f"{node.name}.")
    return found


def with_docstrings(stub: str) -> str:
    """The stub with the Rust half's docstrings instead of its own."""
    lines = stub.splitlines()
    # From the end, so that the numbers of earlier lines stay valid.
    for node, _, doc in sorted(documented(ast.parse(stub).body, _native), key=lambda item: -item[0].lineno):
        indent = " " * (node.col_offset + 4)
        end = '\n"""' if "\n" in doc else '"""'
        quoted = [(indent + line).rstrip() for line in f'"""{doc}{end}'.split("\n")]
        first = node.body[0]
        has_docstring = ast.get_docstring(node) is not None
        if has_docstring:
            lines[first.lineno - 1 : first.end_lineno] = quoted
        elif isinstance(node, ast.ClassDef):
            at = node.body[0].lineno - 1 - decorators(node.body[0])
            lines[at:at] = quoted
        else:
            assert first.end_lineno is not None
            lines[first.end_lineno - 1] = lines[first.end_lineno - 1].removesuffix(" ...")
            lines[first.end_lineno : first.end_lineno] = quoted
    return "\n".join(lines) + "\n"


def decorators(node: ast.stmt) -> int:
    """Number of decorator lines above it."""
    return len(node.decorator_list) if isinstance(node, Documented) else 0


def test_the_stub_says_what_the_rust_half_says() -> None:
    stub = STUB.read_text()
    if os.environ.get("LARIAT_WRITE_STUB"):
        STUB.write_text(with_docstrings(stub))
        stub = STUB.read_text()
    for node, name, doc in documented(ast.parse(stub).body, _native):
        assert doc, f"{name} is not documented"
        assert ast.get_docstring(node) == doc, f"{name}: write the stub again with LARIAT_WRITE_STUB=1"


def test_the_package_says_its_version() -> None:
    assert lariat.__version__.count(".") == 2
