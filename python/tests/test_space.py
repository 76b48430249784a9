"""A rope in space: a user's own camera and depth camera, through the chain, to a reader."""

from __future__ import annotations

import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import Image, interruptible, program

import lariat

SIZE = (320, 240)
CAMERA = """image_width: 320
image_height: 240
camera_matrix: [300, 0, 159.5, 0, 300, 119.5, 0, 0, 1]
distortion_coefficients: [0, 0, 0, 0]
"""
# The rope's surface and the table behind it, mm.
NEAR, FAR = 480, 560


def test_a_depth_image_is_of_whole_numbers_and_sent_beside_its_frame(domain: str, image: Image) -> None:
    with lariat.Writer("frames") as frames, lariat.Frames() as reader, lariat.Writer("depth") as depths:
        frames.write(image)
        frame = reader.wait(30.0)
        assert frame is not None
        depths.write(np.zeros((48, 64), np.uint16), frame)
        with depths.loan(frame, 48, 64) as slot:
            assert slot.array.shape == (48, 64) and slot.array.dtype == np.uint16
        with pytest.raises(ValueError, match="nan_to_num"):
            depths.write(np.zeros((48, 64)), frame)
        with pytest.raises(ValueError, match="two axes"):
            depths.write(np.zeros((48, 64, 1), np.uint16), frame)
    with pytest.raises(ValueError, match="'frames', 'masks' or 'depth'"):
        lariat.Writer("depths")  # type: ignore[call-overload]


def test_a_rope_comes_out_where_it_is_in_space(domain: str, image: Image, tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_text(CAMERA)
    # Aligned to the color images: the same camera.
    (tmp_path / "depth.yaml").write_text("image_width: 320\nimage_height: 240\nrange_mm: [300, 800]\n")
    command = [str(program("lariat")), "run", "--source", "external", "--duration", "60s"]
    command += ["--calibration", "camera.yaml", "--depth", "depth.yaml"]
    chain = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, preexec_fn=interruptible)
    depth = np.where(image[..., 0] < 120, NEAR, FAR).astype(np.uint16)
    done = threading.Event()

    def camera() -> None:
        with lariat.Writer("frames") as frames, lariat.Frames() as sent, lariat.Writer("depth") as depths:
            while not done.is_set():
                frames.write(image)
                frame = sent.wait(1.0)
                if frame is not None:
                    depths.write(depth, frame)
                time.sleep(0.03)

    thread = threading.Thread(target=camera)
    thread.start()
    try:
        with lariat.Reader(space=True) as reader:
            shape = None
            deadline = time.monotonic() + 40.0
            while shape is None:
                assert time.monotonic() < deadline
                match reader.wait(1.0).only_rope(max_age=10.0):
                    case lariat.Fresh(rope):
                        try:
                            shape = rope.in_space
                        except ValueError as cause:
                            assert "space" in str(cause)
    finally:
        done.set()
        thread.join()
        chain.terminate()
        chain.communicate()
    assert shape.place == "known" and shape.measured > 100
    points = shape.points(50)
    assert points.shape == (50, 3) and shape.point_at(0.5).shape == (3,)
    # The axis is a radius behind the surface.
    radius = 0.5 * shape.width
    assert np.all(np.abs(points[:, 2] - NEAR - radius) < 4.0)
    # 240 px from left to right, and a round end of half its width on either side.
    beyond = abs(points[-1, 0] - points[0, 0]) - 240 / 300 * (NEAR + radius)
    assert -2.0 < beyond < 2.0 * radius + 2.0
    assert shape.control_points.shape[1] == 3 and shape.covariances.shape[1] == 6
    rho, on, distance = shape.nearest((0.0, 0.0, float(NEAR)))
    assert 0.3 < rho < 0.7 and on.shape == (3,) and distance < 80.0
