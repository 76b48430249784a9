"""The examples, as a user runs them, beside the real chain."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import interruptible, program

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples/python"


def run(example: str, *arguments: str | Path) -> str:
    command = [sys.executable, EXAMPLES / example, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env={**os.environ, "MPLBACKEND": "agg"})
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def chain(domain: str) -> Iterator[None]:
    """`lariat run` on a rope that it draws."""
    chain = subprocess.Popen(
        [program("lariat"), "run", "--fps", "60"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    yield
    chain.terminate()
    _, errors = chain.communicate(timeout=60)
    assert chain.returncode == 0, errors


def test_a_control_loop_steers_and_says_when_it_holds(chain: None) -> None:
    loop = subprocess.Popen(
        [sys.executable, "-u", EXAMPLES / "control_loop.py"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,
    )
    assert loop.stdout is not None
    lines = []
    for line in loop.stdout:
        lines.append(line)
        if line.startswith("move") and line != f"move {0:8.1f} {0:8.1f} px/s\n":
            break
    loop.send_signal(signal.SIGINT)
    _, errors = loop.communicate(timeout=30)
    assert lines[-1].startswith("move"), errors
    assert "KeyboardInterrupt" in errors
    # Before the chain sends, there is a reason given with each rest.
    assert sum(line.startswith("hold: ") for line in lines) <= len(lines) // 2


def test_the_ropes_are_plotted_live(chain: None, tmp_path: Path) -> None:
    run("plot_live.py", "--frames", "5", "--save", tmp_path / "live.png")
    assert (tmp_path / "live.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_is_traced(tmp_path: Path) -> None:
    said = run("trace_picture.py", ROOT / "docs/rope.png", tmp_path / "rope.svg")
    assert "1 rope, 1 crossing" in said and "U1 O1" in said
    assert (tmp_path / "rope.svg").read_text().startswith("<svg")
