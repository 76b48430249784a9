"""A control loop's reader, with a program that sends any message of a chain."""

from __future__ import annotations

import asyncio
import os
import select
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import States, interruptible

import lariat

ANY_AGE = float("inf")


def wait_new(reader: lariat.Reader) -> lariat.Frame:
    frame = reader.wait(30.0)
    assert frame.is_new
    return frame


def test_a_reader_may_be_there_before_the_chain(domain: str) -> None:
    with lariat.Reader(timeout=0.0) as reader:
        frame = next(reader)
        assert not frame.is_new and frame.trace is None and frame.age is None and reader.age is None
        assert (frame.run, frame.size, frame.unit, frame.message) == (0, (0, 0), None, None)
        seen = frame.only_rope(1.0)
        assert isinstance(seen, lariat.Absent) and seen.why == "nothing-yet"
        assert frame.ropes(1.0) == []
        assert repr(frame) == "<lariat.Frame: nothing came yet>"
        assert reader.fileno() >= 0


def test_a_whole_rope_in_a_fresh_image_is_fresh(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    frame = wait_new(reader)
    match frame.only_rope(ANY_AGE):
        case lariat.Fresh(rope):
            pass
        case seen:
            pytest.fail(str(seen))
    assert (rope.track.number, rope.track.run, frame.run) == (7, 1, 1)
    assert (rope.basis, rope.degree, rope.samples, rope.unit, rope.closed) == ("bezier", 2, 120, "px", False)
    assert (rope.rms, rope.max, rope.residual_variance, rope.length, rope.width) == (0.7, 1.5, 0.25, 147.9, 9.0)
    assert rope.leaves_image == (False, True) and rope.hidden == 0.0
    assert rope.condition > 1.0
    assert np.array_equal(rope.control_points, [[0, 0], [50, 100], [100, 0]])
    assert rope.velocities is not None
    assert np.array_equal(rope.velocities, [[10, 0]] * 3)
    assert np.array_equal(rope.weights, [1, 1, 1]) and rope.knots.shape == (0,)
    assert rope.covariances.shape == (3, 3)
    assert frame.trace is not None and frame.age is not None
    assert (frame.trace.sequence, frame.trace.captured, frame.trace.extracted, frame.trace.fitted) == (101, 3, 2, 1)
    assert rope.exposed_ns == frame.trace.exposed_ns == frame.trace.captured_ns - 1
    assert 0.0 < frame.age == rope.age < 30.0
    assert frame.size == (640, 480) and frame.unit == "px"
    assert not reader.latest().is_new
    again = reader.latest().rope(rope.track, ANY_AGE).or_raise()
    assert again.track == rope.track and hash(again.track) == hash(rope.track)


def test_every_other_case_is_a_type_of_its_own(states: States, reader: lariat.Reader) -> None:
    def seen(state: str, max_age: float = ANY_AGE) -> lariat.Seen:
        states.send(state)
        return wait_new(reader).only_rope(max_age)

    partial = seen("partial")
    assert isinstance(partial, lariat.Partial) and partial.rope.hidden == 0.25
    assert str(partial) == "25 % of rope 7 is covered"

    lost = seen("lost")
    assert isinstance(lost, lariat.Lost) and lost.age >= 0.25
    assert np.array_equal(lost.as_it_was.control_points[1], [50, 100])
    assert not hasattr(lost, "rope") and not hasattr(lost, "shape")

    stale = seen("whole", max_age=0.0)
    assert isinstance(stale, lariat.Stale) and stale.age > 0.0
    assert "the last image of rope 7 is" in str(stale)
    assert not hasattr(stale, "rope")

    for state, why in [("none", "no-rope"), ("blank", "no-image"), ("two", "several"), ("nonsense", "unreadable")]:
        absent = seen(state)
        assert isinstance(absent, lariat.Absent) and absent.why == why, state
    stale_empty = reader.latest().only_rope(0.0)
    assert isinstance(stale_empty, lariat.Absent) and stale_empty.why == "unreadable"


def test_a_coarse_curve_and_a_doubtful_rope_are_not_fresh(states: States, reader: lariat.Reader) -> None:
    states.send("coarse")
    frame = wait_new(reader)
    match frame.only_rope(ANY_AGE):
        case lariat.Unsure(rope, "coarse") as seen:
            pass
        case seen:
            pytest.fail(str(seen))
    assert "misses it by up to 15.8" in str(seen) and "its centerline is right" in str(seen)
    assert rope.fit == "coarse" and rope.centerline is not None and len(rope.centerline) == 51
    with pytest.raises(lariat.NotSeen, match="rope 7 misses it"):
        seen.or_raise(partial=True)
    assert isinstance(frame.only_rope(0.0), lariat.Stale)
    with lariat.Reader(accept_coarse=True) as accepts:
        states.send("coarse")
        assert wait_new(accepts).only_rope(ANY_AGE).or_raise().fit == "coarse"
    states.send("doubtful")
    match wait_new(reader).only_rope(ANY_AGE):
        case lariat.Unsure(doubted, why):
            assert why == "no-rope" and doubted.fit == "not judged"
        case other:
            pytest.fail(str(other))


def test_a_rope_below_the_confidence_that_is_asked_for_is_not_fresh(states: States, reader: lariat.Reader) -> None:
    states.send("unsure")
    match wait_new(reader).only_rope(ANY_AGE):
        case lariat.Unsure(_, "low-confidence"):
            pass
        case other:
            pytest.fail(str(other))
    with lariat.Reader(min_confidence=0.4) as asks:
        states.send("unsure")
        rope = wait_new(asks).only_rope(ANY_AGE).or_raise()
        assert rope.confidence == pytest.approx(0.42)
    with lariat.Reader(min_confidence=0.9) as asks:
        states.send("unsure")
        match wait_new(asks).only_rope(ANY_AGE):
            case lariat.Unsure(_, "low-confidence") as seen:
                assert "42 %" in str(seen)
            case other:
                pytest.fail(str(other))
        states.send("whole")
        assert wait_new(asks).only_rope(ANY_AGE).or_raise().confidence == pytest.approx(0.97)
    with pytest.raises(ValueError, match="from 0 to 1"):
        lariat.Reader(min_confidence=1.5)


def test_the_points_come_with_the_curve_and_are_not_copied(states: States, reader: lariat.Reader) -> None:
    states.send("two")
    ropes = [seen.or_raise() for seen in wait_new(reader).ropes(ANY_AGE)]
    lines = [rope.centerline for rope in ropes]
    assert lines[0] is not None and lines[1] is not None
    line = lines[0]
    x = 2.0 * np.arange(51, dtype=np.float32)
    parabola = np.stack([x, x * (2.0 - 0.02 * x)], axis=-1)
    assert line.points.dtype == np.float32 and line.points == pytest.approx(parabola, abs=1e-4)
    assert lines[1].points[0] == pytest.approx([0.0, 100.0])
    assert line.widths == pytest.approx(9.0 + 0.01 * np.arange(51))
    assert not line.closed and np.flatnonzero(line.hidden).tolist() == [25]
    assert isinstance(line.points.base, lariat.Centerline) and not line.points.flags.writeable
    assert line.point_at(0.5) == pytest.approx([50.0, 50.0], abs=1e-4)
    assert line.point_at([0.0, 1.0]) == pytest.approx(line.points[[0, -1]])


def test_the_nearest_point_is_the_nearest_of_all(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    rope = wait_new(reader).only_rope(ANY_AGE).or_raise()
    assert rope.centerline is not None
    many = np.linspace(0.0, 1.0, 100_001)
    for point in [(50.0, 80.0), (-3.0, 10.0), (70.0, 20.0)]:
        for line in (rope.shape, rope.centerline):
            rho, nearest, distance = line.nearest(point)
            assert nearest == pytest.approx(line.point_at(rho))
            assert distance == pytest.approx(np.hypot(*(nearest - point)))
            assert distance <= np.hypot(*(line.point_at(many) - point).T).min() + 1e-6
    assert rope.shape.nearest((50.0, 80.0))[2] == pytest.approx(30.0)
    with pytest.raises((TypeError, ValueError)):
        rope.shape.nearest((1.0, 2.0, 3.0))  # type: ignore[arg-type]


def test_who_does_not_look_gets_an_exception_that_says_what_is_seen(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    frame = wait_new(reader)
    assert frame.only_rope(ANY_AGE).or_raise().track.number == 7
    with pytest.raises(lariat.NotSeen, match="the last image of rope 7") as error:
        frame.only_rope(0.0).or_raise()
    assert isinstance(error.value.seen, lariat.Stale)
    states.send("partial")
    frame = wait_new(reader)
    with pytest.raises(lariat.NotSeen, match="25 % of rope 7 is covered"):
        frame.only_rope(ANY_AGE).or_raise()
    assert frame.only_rope(ANY_AGE).or_raise(partial=True).track.number == 7
    for state, sentence in [("lost", "out of sight"), ("none", "no such rope"), ("two", "choose one by its track")]:
        states.send(state)
        with pytest.raises(lariat.NotSeen, match=sentence):
            wait_new(reader).only_rope(ANY_AGE).or_raise(partial=True)


def test_of_several_ropes_each_is_known_by_its_track(states: States, reader: lariat.Reader) -> None:
    states.send("two")
    frame = wait_new(reader)
    ropes = [seen.or_raise() for seen in frame.ropes(ANY_AGE)]
    assert [rope.track.number for rope in ropes] == [7, 8]
    assert frame.rope(ropes[1].track, ANY_AGE).or_raise().track.number == 8
    with pytest.raises(TypeError, match="a track is what a rope's own"):
        frame.rope(8, ANY_AGE)  # type: ignore[arg-type]
    states.send("whole")
    gone = wait_new(reader).rope(ropes[1].track, ANY_AGE)
    assert isinstance(gone, lariat.Absent) and gone.why == "no-rope"


def test_a_track_of_an_earlier_run_is_no_rope_of_this_one(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    track = wait_new(reader).only_rope(ANY_AGE).or_raise().track
    states.restart()
    states.send("whole")
    frame = wait_new(reader)
    assert frame.run == 2
    other = frame.rope(track, ANY_AGE)
    assert isinstance(other, lariat.Absent) and other.why == "other-run"
    assert frame.only_rope(ANY_AGE).or_raise().track != track


def test_the_curve_answers_what_a_control_law_asks(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    shape = wait_new(reader).only_rope(ANY_AGE).or_raise().shape
    rho = np.linspace(0.0, 1.0, 7)
    parabola = np.stack([100.0 * rho, 200.0 * rho * (1.0 - rho)], axis=-1)
    assert shape.point_at(rho) == pytest.approx(parabola)
    assert shape.points(7) == pytest.approx(parabola)
    assert shape.point_at(0.5) == pytest.approx([50.0, 50.0])
    assert shape.derivative_at(0.0) == pytest.approx([100.0, 200.0])
    assert shape.tangent_at(0.5) == pytest.approx([1.0, 0.0])
    assert shape.normal_at(0.5) == pytest.approx([0.0, 1.0])
    # y = 2 x - x² / 50 bends upwards in an image, which is to the left of the direction of travel.
    assert shape.curvature_at(0.5) == pytest.approx(-0.04)
    assert np.shape(shape.curvature_at(rho)) == (7,)
    b = np.stack([(1 - rho) ** 2, 2 * rho * (1 - rho), rho**2], axis=-1)
    assert shape.jacobian_at(rho) == pytest.approx(b)
    assert not shape.closed


def test_the_covariance_is_that_of_the_regression(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    shape = wait_new(reader).only_rope(ANY_AGE).or_raise().shape
    rho = np.linspace(0.0, 1.0, 120)
    b = np.stack([(1 - rho) ** 2, 2 * rho * (1 - rho), rho**2], axis=-1)
    expected = 0.25 * np.linalg.inv(b.T @ b)
    assert shape.covariance() == pytest.approx(np.kron(expected, np.eye(2)), rel=1e-9)
    assert shape.covariance_is_exact
    of_point = b[40] @ expected @ b[40]
    assert shape.covariance_at(rho[40]) == pytest.approx(of_point * np.eye(2))
    assert shape.covariance_at(rho[:5]).shape == (5, 2, 2)


def test_a_rope_is_predicted_by_its_velocity(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    wait_new(reader)
    states.send("whole")
    rope = wait_new(reader).only_rope(ANY_AGE).or_raise()
    ahead = rope.predict(rope.exposed_ns + 200_000_000)
    assert ahead.point_at(0.5) == pytest.approx([52.0, 50.0])
    assert ahead.control_points == pytest.approx(rope.control_points + [2.0, 0.0])
    assert (np.diag(ahead.covariance()) > np.diag(rope.shape.covariance())).all()
    with pytest.raises(ValueError, match="500 ms"):
        rope.predict(rope.exposed_ns + 10**9)
    states.send("unfiltered")
    rope = wait_new(reader).only_rope(ANY_AGE).or_raise()
    assert rope.velocities is None
    with pytest.raises(ValueError, match="--filter"):
        rope.predict(rope.exposed_ns)


def test_a_descriptor_of_points_has_no_curve(states: States, reader: lariat.Reader) -> None:
    states.send("points")
    rope = wait_new(reader).only_rope(ANY_AGE).or_raise()
    assert rope.basis == "points" and rope.control_points.shape == (3, 2)
    with pytest.raises(ValueError, match="points"):
        rope.shape.point_at(0.5)
    assert "<svg" in rope._repr_html_()


def test_what_was_read_stays_good(states: States, reader: lariat.Reader) -> None:
    """Frames and arrays stay valid however many are kept, even after the reader and the chain are
    gone."""
    kept = []
    for _ in range(40):
        states.send("whole")
        frame = wait_new(reader)
        kept.append((frame, frame.only_rope(ANY_AGE).or_raise().control_points))
    states.stop()
    reader.close()
    for _, points in kept:
        assert np.array_equal(points, [[0, 0], [50, 100], [100, 0]])
    assert [frame.trace.fitted for frame, _ in kept if frame.trace] == list(range(1, 41))
    points = kept[0][1]
    assert isinstance(points.base, lariat.Rope) and not points.flags.owndata
    with pytest.raises(ValueError, match="read-only"):
        points[0] = 1.0


def test_the_newest_is_read_and_none_in_between(states: States, reader: lariat.Reader) -> None:
    states.send(*["whole"] * 5)
    frame = wait_new(reader)
    assert frame.trace is not None and frame.trace.fitted == 5


def test_a_wait_ends_after_its_time_with_the_frame_that_was_there(states: States, reader: lariat.Reader) -> None:
    states.send("whole")
    first = wait_new(reader)
    second = reader.wait(0.05)
    assert not second.is_new and second.age is not None and first.age is not None
    assert second.age >= first.age + 0.05
    assert second.trace is not None and second.trace.fitted == 1


def test_other_threads_run_while_one_waits(states: States, reader: lariat.Reader) -> None:
    waiting = threading.Event()
    came: list[lariat.Frame] = []

    def wait() -> None:
        waiting.set()
        came.append(reader.wait(30.0))

    thread = threading.Thread(target=wait)
    thread.start()
    waiting.wait()
    # The waiting reader does not block this thread, which could not send otherwise. The reader
    # reports at any moment that it is in use.
    refused = 0
    for _ in range(1000):
        try:
            reader.latest()
        except RuntimeError as error:
            assert "open one for each thread" in str(error)
            refused += 1
            break
        time.sleep(0.001)
    assert refused
    states.send("whole")
    thread.join(30.0)
    assert came and came[0].is_new


def test_ctrl_c_ends_a_wait(domain: str, tmp_path: Path) -> None:
    program = "import lariat\nreader = lariat.Reader(timeout=1000.0)\nprint('waits', flush=True)\nnext(reader)"
    # Run in another folder: here the package's source would be found before the installed package.
    process = subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        preexec_fn=interruptible,
    )
    assert process.stdout is not None and process.stdout.readline() == b"waits\n"
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert b"KeyboardInterrupt" in errors


def test_a_select_of_ones_own_is_woken(states: States, reader: lariat.Reader) -> None:
    assert reader.before_poll() != 0.0
    states.send("whole")
    readable, _, _ = select.select([reader], [], [], 30.0)
    assert readable == [reader] and reader.latest().is_new
    longest = reader.before_poll()
    assert longest is not None and 0.0 < longest <= 0.1


def test_asyncio_waits_beside_other_tasks(states: States, reader: lariat.Reader) -> None:
    async def follow() -> list[int]:
        counts = []
        async for frame in reader:
            if frame.is_new and frame.trace:
                counts.append(frame.trace.fitted)
            if len(counts) == 3:
                break
        return counts

    async def both() -> list[int]:
        following = asyncio.create_task(follow())
        while not following.done():
            await asyncio.to_thread(states.send, "whole")
        return await following

    counts = asyncio.run(asyncio.wait_for(both(), 30.0))
    assert counts == sorted(set(counts)) and len(counts) == 3
    # Another message may have been sent while the third was received.
    reader.latest()
    quiet = asyncio.run(reader.wait_async(0.01))
    assert not quiet.is_new


def test_the_thread_that_asks_has_short_slices() -> None:
    def slice_ns() -> str | None:
        """The slice reported by the kernel, if there is one."""
        kept = Path("/proc/thread-self/sched")
        lines = kept.read_text().splitlines() if kept.exists() else []
        return next((line.split()[-1] for line in lines if line.startswith("se.slice")), None)

    def ask() -> None:
        lariat.take_short_slices()
        inside.append(slice_ns())

    before, inside = slice_ns(), list[str | None]()
    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    if before is None:
        pytest.skip("this kernel does not say how long slices are")
    assert inside == ["100000"] and slice_ns() == before


def test_what_is_wrong_is_said_in_a_sentence(domain: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="is not a valid rig name"):
        lariat.Reader("Left Arm")
    with pytest.raises(ValueError, match="give a number of seconds"):
        lariat.Reader(timeout=-1.0)
    with lariat.Reader() as reader:
        with pytest.raises(ValueError, match="give a number of seconds"):
            reader.wait(float("nan"))
        with pytest.raises(ValueError, match="two positive numbers"):
            reader.expect_motion(-1.0)
        reader.expect_motion(500.0, 0.2)
        assert repr(reader) == "<lariat.Reader of rig 'default'>"
    assert reader.closed and repr(reader) == "<lariat.Reader of rig 'default', closed>"
    with pytest.raises(ValueError, match="this reader is closed"):
        reader.latest()
    reader.close()
    monkeypatch.setenv("LARIAT_DOMAIN", "No Such")
    with pytest.raises(ValueError, match="LARIAT_DOMAIN"):
        lariat.Reader()


def test_the_25th_reader_is_refused(domain: str) -> None:
    readers = [lariat.Reader() for _ in range(24)]
    with pytest.raises(OSError, match="already has its 24 readers"):
        lariat.Reader()
    for reader in readers:
        reader.close()


def test_a_reader_that_is_forgotten_leaves_nothing(domain: str) -> None:
    reader = lariat.Reader()
    reader.latest()
    del reader
    assert not [name for name in os.listdir("/dev/shm") if name.startswith(f"lariat_{domain}_")]


def test_a_notebook_shows_the_frame(states: States, reader: lariat.Reader) -> None:
    states.send("two")
    frame = wait_new(reader)
    html = frame._repr_html_()
    assert html.count("<polyline") == 2 and 'viewBox="0.0 0.0 640.0 480.0"' in html and "2 ropes" in html
    rope = frame.ropes(ANY_AGE)[0].or_raise()
    assert rope._repr_html_().startswith("<svg") and rope.shape._repr_html_().startswith("<svg")
    states.send("blank")
    assert "no rope" in wait_new(reader)._repr_html_()
