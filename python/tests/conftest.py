"""Test images with ropes, and a process that replaces the chain."""

from __future__ import annotations

import os
import signal
import subprocess
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import lariat

Image = NDArray[np.uint8]


def rope_through(points: NDArray[Any], *, size: tuple[int, int] = (320, 240), width: float = 9.0) -> Image:
    """A dark blue rope along a polyline, on a light table, as RGB."""
    columns, rows = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    pixels = np.stack([columns, rows], axis=-1).astype(float)
    nearest = np.full(pixels.shape[:2], np.inf)
    for a, b in zip(points[:-1], points[1:]):
        along = np.clip(((pixels - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(pixels - a - along[..., None] * (b - a), axis=-1))
    share = np.clip(width / 2.0 + 0.5 - nearest, 0.0, 1.0)[..., None]
    image = (1.0 - share) * np.array([210.0, 205.0, 200.0]) + share * np.array([30.0, 40.0, 120.0])
    return np.ascontiguousarray(np.rint(image).astype(np.uint8))


def wave(count: int = 60) -> NDArray[Any]:
    """A wave from left to right."""
    t = np.linspace(0.0, 1.0, count)
    return np.stack([40.0 + 240.0 * t, 120.0 + 50.0 * np.sin(5.0 * t)], axis=-1)


@pytest.fixture(scope="session")
def image() -> Image:
    return rope_through(wave())


def interruptible() -> None:
    """For a new process: children of a background job ignore Ctrl-C, and Python handles it only
    if it is not ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


TARGET = Path(os.environ.get("CARGO_TARGET_DIR", Path(__file__).parents[2] / "target"))


def program(name: str) -> Path:
    """The newest build of a program, of any cargo profile."""
    found = [path for path in TARGET.glob(f"*/{name}") if path.is_file() and os.access(path, os.X_OK)]
    if not found:
        pytest.fail(f"{name} is not built: run python/test.sh")
    return max(found, key=lambda path: path.stat().st_mtime)


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Iterator[str]:
    """A domain for one test, which must leave nothing behind."""
    name = f"py{os.getpid() % 100_000}-{zlib.crc32(request.node.name.encode()) % 100_000}"
    monkeypatch.setenv("LARIAT_DOMAIN", name)
    yield name
    # A failed test's traceback keeps objects alive, so leftovers are then ignored.
    left = [path.name for path in Path("/dev/shm").iterdir() if path.name.startswith(f"lariat_{name}_")]
    assert left == [] or request.session.testsfailed, left


class States:
    """A process that replaces the chain (`states.rs`)."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [program("examples/states")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.hears("ready")

    def hears(self, word: str) -> None:
        assert self.process.stdout is not None
        assert self.process.stdout.readline().strip() == word

    def tell(self, word: str, answer: str) -> None:
        assert self.process.stdin is not None
        print(word, file=self.process.stdin, flush=True)
        self.hears(answer)

    def send(self, *states: str) -> None:
        """Sends a message of each state."""
        for state in states:
            self.tell(state, "sent")

    def restart(self) -> None:
        """Numbers everything again, as a restarted chain does."""
        self.tell("restart", "ready")

    def stop(self) -> None:
        self.process.communicate(timeout=30)


@pytest.fixture
def states(domain: str) -> Iterator[States]:
    states = States()
    yield states
    states.stop()


@pytest.fixture
def reader(domain: str) -> Iterator[lariat.Reader]:
    with lariat.Reader(timeout=30.0) as reader:
        yield reader
