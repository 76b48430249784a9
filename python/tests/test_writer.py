"""Users' own frames and masks."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from conftest import Image, interruptible
from numpy.typing import NDArray

import lariat
from lariat._writer import _fill


@pytest.fixture
def frames(domain: str) -> Iterator[lariat.Frames]:
    with lariat.Frames() as frames:
        yield frames


@pytest.fixture
def writer(domain: str) -> Iterator[lariat.FrameWriter]:
    with lariat.Writer("frames") as writer:
        yield writer


def came(frames: lariat.Frames) -> lariat.Image:
    frame = frames.wait(30.0)
    assert frame is not None
    return frame


def test_an_image_arrives_as_it_was_with_its_way(writer: lariat.FrameWriter, frames: lariat.Frames, image: Image) -> None:
    before = time.monotonic_ns()
    writer.write(image)
    frame = came(frames)
    assert frame.pixel_format == "rgb8" and frame.size == (320, 240)
    assert np.array_equal(frame.array, image) and frame.array.flags.writeable
    trace = frame.trace
    assert (trace.sequence, trace.captured, trace.extracted) == (1, 1, 0)
    assert before < trace.exposed_ns <= trace.captured_ns < time.monotonic_ns()
    writer.write(image, exposed_ns=trace.captured_ns + 1, sequence=7)
    trace, before = came(frames).trace, trace.captured_ns
    assert (trace.sequence, trace.captured, trace.exposed_ns) == (7, 2, before + 1)


def test_every_array_is_sent_as_its_pixels_whatever_its_strides(
    writer: lariat.FrameWriter, frames: lariat.Frames, image: Image
) -> None:
    tall = np.zeros((480, 320, 3), np.uint8)
    tall[::2] = image
    for array in [image[::-1], image[:, ::-1], image[..., ::-1], tall[::2], image[3:90, 5:60], np.asfortranarray(image)]:
        writer.write(array, "bgr8")
        frame = came(frames)
        assert frame.pixel_format == "bgr8" and np.array_equal(frame.array, array)


@pytest.mark.parametrize(
    ("pixel_format", "shape", "size"),
    [
        ("gray8", (6, 5), (5, 6)),
        ("rgb8", (6, 5, 3), (5, 6)),
        ("yuyv", (6, 4, 2), (4, 6)),
        ("UYVY", (6, 4, 2), (4, 6)),
        ("nv12", (6, 4), (4, 4)),
    ],
)
def test_each_pixel_format_has_its_array(
    writer: lariat.FrameWriter, frames: lariat.Frames, pixel_format: str, shape: tuple[int, ...], size: tuple[int, int]
) -> None:
    array = np.arange(np.prod(shape), dtype=np.uint8).reshape(shape)
    writer.write(array, pixel_format)
    frame = came(frames)
    assert (frame.pixel_format, frame.size) == (pixel_format.lower(), size)
    assert np.array_equal(frame.array, array)


def test_a_slot_is_filled_in_place(writer: lariat.FrameWriter, frames: lariat.Frames) -> None:
    with writer.loan(4, 6, "gray8") as slot:
        slot.array[...] = np.arange(24).reshape(4, 6)
        slot.exposed_ns = time.monotonic_ns()
    assert np.array_equal(came(frames).array.ravel(), np.arange(24))
    with pytest.raises(ValueError, match="sent, or given back"):
        slot.array
    with pytest.raises(ZeroDivisionError), writer.loan(4, 6, "gray8"):
        raise ZeroDivisionError
    assert frames.wait(0.0) is None
    writer.write(np.zeros((4, 6), np.uint8))
    assert came(frames).trace.captured == 2


def test_an_array_of_a_slot_outlives_it_unharmed(domain: str) -> None:
    """The array stays in shared memory, which is not unmapped while it exists."""
    writer = lariat.Writer("frames")
    with writer.loan(40, 60, "gray8") as slot:
        kept = slot.array
    with pytest.raises(BufferError, match="let go of it"):
        writer.write(np.zeros((400, 600), np.uint8))
    writer.close()
    assert writer.closed
    kept[...] = 1
    with pytest.raises(ValueError, match="closed"):
        writer.write(np.zeros((4, 6), np.uint8))
    with pytest.raises(OSError, match="already has a writer"):
        lariat.Writer("frames")
    del kept, slot
    lariat.Writer("frames").close()


@pytest.mark.parametrize(
    ("image", "pixel_format", "error", "sentence"),
    [
        (None, None, TypeError, "the camera gave no image"),
        ([[1, 2]], None, TypeError, "numpy.asarray"),
        (np.zeros((4, 4), np.float32), None, TypeError, "scale it to 0 to 255"),
        (np.zeros((4, 4, 2), np.uint8), None, ValueError, "say its pixel_format"),
        (np.zeros(4, np.uint8), None, ValueError, "has the shape"),
        (np.zeros((0, 4), np.uint8), None, ValueError, "has the shape"),
        (np.zeros((4, 4, 3), np.uint8), "rgbx", ValueError, "use one of gray8, rgb8, bgr8, yuyv"),
        (np.zeros((4, 4), np.uint8), "rgb8", ValueError, "of the shape \\(4, 4, 3\\)"),
        (np.zeros((4, 4), np.uint8), "nv12", ValueError, "in 'nv12'"),
        (np.zeros((4, 5, 2), np.uint8), "yuyv", ValueError, "in 'yuyv'"),
        (np.zeros((1, 9000), np.uint8), None, ValueError, "Invalid width 9000"),
    ],
)
def test_what_is_no_image_is_refused_with_a_sentence(
    writer: lariat.FrameWriter,
    frames: lariat.Frames,
    image: Any,
    pixel_format: str | None,
    error: type[Exception],
    sentence: str,
) -> None:
    with pytest.raises(error, match=sentence):
        writer.write(image, pixel_format)
    writer.write(np.zeros((4, 6), np.uint8))
    assert came(frames).trace.captured == 1


def test_a_time_or_a_number_that_cannot_be_is_refused(writer: lariat.FrameWriter, image: Image) -> None:
    with pytest.raises(ValueError, match="time.monotonic_ns"):
        writer.write(image, exposed_ns=time.time_ns())
    writer.write(image, sequence=5)
    with pytest.raises(ValueError, match="before the last image's"):
        writer.write(image, exposed_ns=1)
    with pytest.raises(ValueError, match="sequence is 5 after 5"):
        writer.write(image, sequence=5)


def test_there_is_one_writer_and_it_has_a_known_channel(writer: lariat.FrameWriter) -> None:
    with pytest.raises(OSError, match="--source external"):
        lariat.Writer("frames")
    lariat.Writer("frames", "other").close()
    with pytest.raises(ValueError, match="Invalid channel 'frame'"):
        lariat.Writer("frame")  # type: ignore[call-overload]
    with pytest.raises(ValueError, match="--rig"):
        lariat.Writer("masks", "no such name")
    assert repr(writer) == "<lariat.Writer of frames of rig 'default'>"


def test_a_mask_is_sent_as_bytes_for_its_frame(writer: lariat.FrameWriter, frames: lariat.Frames) -> None:
    with lariat.Writer("masks") as masks:
        writer.write(np.zeros((2, 3, 3), np.uint8))
        frame = came(frames)
        likely = np.array([[0.0, 0.25, 0.5], [0.75, 1.0, 0.499]])
        good: list[tuple[NDArray[Any], list[int]]] = [
            (likely > 0.3, [0, 0, 255, 255, 255, 255]),
            (likely, [0, 64, 128, 191, 255, 127]),
            (likely.astype(np.float16)[..., None], [0, 64, 128, 191, 255, 127]),
            ((likely * 200).astype(np.uint8), [0, 50, 100, 150, 200, 99]),
            (np.zeros((2, 3), np.uint8), [0] * 6),
        ]
        for mask, sent in good:
            masks.write(mask, frame)
            bytes_of_mask = np.empty(6, np.uint8)
            _fill(bytes_of_mask, mask.ravel())
            assert bytes_of_mask.tolist() == sent
        bad: list[tuple[Any, type[Exception], str]] = [
            (np.zeros((3, 2), bool), ValueError, "cv2.resize\\(mask, \\(3, 2\\)\\)"),
            (np.ones((2, 3), np.uint8), ValueError, "mask.astype\\(bool\\)"),
            (np.ones((2, 3), np.int64), TypeError, "mask == label"),
            (np.full((2, 3), 1.5), ValueError, "sigmoid"),
            (np.full((2, 3), np.nan), ValueError, "sigmoid"),
            ("mask", TypeError, "numpy.asarray"),
        ]
        for mask, error, sentence in bad:
            with pytest.raises(error, match=sentence):
                masks.write(mask, frame)


def test_a_camera_that_is_blind_says_so(writer: lariat.FrameWriter, frames: lariat.Frames, image: Image) -> None:
    writer.send_blank()
    writer.write(image)
    # Nothing else wakes a reader that waits for images.
    assert came(frames).trace.captured == 2


def test_ctrl_c_ends_a_lossless_write_that_waits(domain: str) -> None:
    source = """
import lariat, numpy, sys
writer = lariat.Writer("frames", lossless=True)
image = numpy.zeros((4, 4), numpy.uint8)
writer.write(image)
reader = lariat.Frames()
reader.wait(0.0)
print("writes", flush=True)
while True:
    writer.write(image)
    print("wrote", flush=True)
"""
    program = subprocess.Popen(
        [sys.executable, "-c", source],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,
        cwd="/",
    )
    assert program.stdout is not None
    for line in program.stdout:
        if line == "wrote\n":
            break
    program.send_signal(signal.SIGINT)
    _, errors = program.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors


def test_ctrl_c_ends_a_wait_for_frames(domain: str) -> None:
    source = "import lariat\nframes = lariat.Frames()\nprint('waits', flush=True)\nnext(frames)"
    program = subprocess.Popen(
        [sys.executable, "-c", source],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,
        cwd="/",
    )
    assert program.stdout is not None and program.stdout.readline() == "waits\n"
    program.send_signal(signal.SIGINT)
    _, errors = program.communicate(timeout=30)
    assert "KeyboardInterrupt" in errors


def test_a_writer_that_was_killed_leaves_its_place(domain: str, frames: lariat.Frames) -> None:
    source = (
        "import lariat, numpy, time\nwriter = lariat.Writer('frames')\n"
        "writer.write(numpy.full((8, 8), 3, numpy.uint8))\ntime.sleep(1000)"
    )
    program = subprocess.Popen([sys.executable, "-c", source], cwd="/")
    assert came(frames).array[0, 0] == 3
    os.kill(program.pid, signal.SIGKILL)
    program.wait()
    with lariat.Writer("frames") as writer:
        writer.write(np.full((8, 8), 4, np.uint8))
        assert came(frames).array[0, 0] == 4
