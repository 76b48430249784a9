"""The examples, run as by a user, with the real chain."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import interruptible, program

import lariat

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
    # Before the chain sends, every pause has a reason.
    assert sum(line.startswith("hold: ") for line in lines) <= len(lines) // 2


def test_the_ropes_are_plotted_live(chain: None, tmp_path: Path) -> None:
    run("plot_live.py", "--frames", "5", "--save", tmp_path / "live.png")
    assert (tmp_path / "live.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_is_traced(tmp_path: Path) -> None:
    said = run("trace_picture.py", ROOT / "docs/rope.png", tmp_path / "rope.svg")
    assert "1 rope, 1 crossing" in said and "U1 O1" in said
    assert (tmp_path / "rope.svg").read_text().startswith("<svg")


def serve(example: str, **environment: str) -> subprocess.Popen[str]:
    """A program that runs until it is interrupted."""
    return subprocess.Popen(
        [sys.executable, EXAMPLES / example],
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,
    )


def first_rope(reader: lariat.Reader) -> lariat.Rope:
    for frame in reader:
        seen = frame.only_rope(max_age=30.0)
        if isinstance(seen, lariat.Fresh):
            return seen.rope
    raise AssertionError("a reader does not end")


STANDS_FOR_OPENCV = """
import numpy as np
import time

class VideoCapture:
    def __init__(self, name): assert name == 0
    def grab(self): time.sleep(0.02); return True
    def retrieve(self):
        image = np.full((240, 320, 3), 220, np.uint8)
        for row in range(12):  # as round as a rope
            light = 1.1 - 0.01 * (row - 5.5) ** 2
            image[115 + row, 40:280] = np.multiply((120, 40, 30), light)  # blue, green, red
        return True, image
"""


def test_what_opencv_reads_is_a_source(domain: str, tmp_path: Path) -> None:
    (tmp_path / "cv2.py").write_text(STANDS_FOR_OPENCV)
    (tmp_path / "lariat.toml").write_text("[extract]\nmask = [{ hue_deg = [200, 260], saturation = [0.3, 1] }]\n")
    camera = serve("camera.py", PYTHONPATH=str(tmp_path))
    command = ["run", "--source", "external", "--duration", "60s"]
    chain = subprocess.Popen([program("lariat"), *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    try:
        with lariat.Reader(timeout=30.0) as reader:
            # Blue stays blue: the channels are in OpenCV's order.
            assert first_rope(reader).length == pytest.approx(240, abs=5)
    finally:
        chain.send_signal(signal.SIGINT)
        _, errors = chain.communicate(timeout=60)
        camera.send_signal(signal.SIGINT)
        _, said = camera.communicate(timeout=30)
    assert chain.returncode == 0, errors
    assert "KeyboardInterrupt" in said


def test_frames_and_masks_of_two_programs_make_a_rope(domain: str, tmp_path: Path) -> None:
    """A camera and a network, both in Python, on one chain."""
    (tmp_path / "lariat.toml").write_text('[extract]\nmask = "external"\nmask_deadline_us = 1000000\n')
    programs = [serve("mask_network.py"), serve("drawn_camera.py")]
    command = ["run", "--source", "external", "--duration", "60s", "--out", "out"]
    chain = subprocess.Popen([program("lariat"), *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    try:
        with lariat.Reader(timeout=30.0) as reader:
            rope = first_rope(reader)
            assert reader.latest().size == (640, 480)
        x, y = rope.shape.point_at(0.0)
        # As drawn: from 80 to 560, around the middle.
        assert min(abs(x - 80), abs(x - 560)) < 12 and 160 < y < 320
    finally:
        chain.send_signal(signal.SIGINT)
        _, errors = chain.communicate(timeout=60)
        said = []
        for each in programs:
            each.send_signal(signal.SIGINT)
            said.append(each.communicate(timeout=30)[1])
    assert chain.returncode == 0, errors
    assert all("KeyboardInterrupt" in text for text in said), said
    frames = json.loads((tmp_path / "out/summary.json").read_text())["frames"]
    assert frames["received"] > 0 and frames["published"] == frames["received"] + sum(
        frames["lost"][link] for link in ["capture", "mask", "extract", "bridge", "fit", "sink"]
    )
