"""Cost of reading in Python: `latest()`, the data of a rope, the wakeup from a wait. For
comparison, the same messages are read with ctypes through the `iceoryx2` wheel, the alternative.

    pip install ./python iceoryx2==0.10.0
    cargo build --release
    python python/bench/readers.py [--fps 200] [--frames 2000]

Both read one running chain, in turns, each in its own process. In one process, a reader loses its
channel when the wheel joins the same domain.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import select
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lariat

ROUNDS = 4
MESSAGE_BYTES = bytes(lariat.MESSAGE.itemsize)
Times = dict[str, list[float]]


class Bytes(ctypes.Structure):
    """The message in the transport's view: this many bytes, aligned to eight, with this name."""

    _fields_ = [("words", ctypes.c_uint64 * (lariat.MESSAGE.itemsize // 8))]

    @staticmethod
    def type_name() -> str:
        return "lariat.Descriptors.v9"


class OverCtypes:
    """Reads the channel with the wheel; each array is a view of shared memory."""

    def __init__(self) -> None:
        iox2: Any = import_module("iceoryx2")
        self.pause = iox2.Duration.from_millis(100)
        domain = os.environ["LARIAT_DOMAIN"]
        config = iox2.config.global_config()
        config.global_cfg.prefix = iox2.FileName.new(f"lariat_{domain}_")
        config.global_cfg.root_path = iox2.Path.new(f"/tmp/lariat-{domain}")
        iox2.set_log_level(iox2.LogLevel.Fatal)
        self.node = iox2.NodeBuilder.new().config(config).create(iox2.ServiceType.Ipc)
        name = "lariat/default/descriptors"
        service = self.node.service_builder(iox2.ServiceName.new(name)).publish_subscribe(Bytes).open()
        bell = self.node.service_builder(iox2.ServiceName.new(f"{name}-ready")).event().open()
        self.subscriber = service.subscriber_builder().buffer_size(1).create()
        self.listener = bell.listener_builder().create()
        self.sample: Any = None

    def latest(self) -> np.void | None:
        """The newest message as a record; `None` if nothing arrived."""
        message = None
        while (sample := self.subscriber.receive()) is not None:
            if self.sample is not None:
                self.sample.delete()
            self.sample = sample
            message = np.frombuffer(sample.payload().contents, dtype=lariat.MESSAGE)[0]
        return message

    def wait(self) -> np.void | None:
        """The next message."""
        while (message := self.latest()) is None:
            self.listener.timed_wait(self.pause)
            while self.listener.try_wait():
                pass
        return message


def bezier(points: NDArray[np.float64], rho: float) -> NDArray[np.float64]:
    """De Casteljau's algorithm in its simplest form."""
    while len(points) > 1:
        points = (1.0 - rho) * points[:-1] + rho * points[1:]
    return np.asarray(points[0])


def timed(times: list[float], work: Callable[[], Any]) -> Any:
    begin = time.perf_counter_ns()
    result = work()
    times.append((time.perf_counter_ns() - begin) / 1e3)
    return result


def measure_lariat(reader: lariat.Reader, times: Times) -> None:
    timed(times["latest(), nothing new"], reader.latest)
    while reader.before_poll() != 0.0:
        select.select([reader], [], [], 0.1)
    frame = timed(times["latest(), a new image"], reader.latest)
    rope = timed(times["  only_rope(max_age)"], lambda: frame.only_rope(1.0)).or_raise(partial=True)
    timed(times["  rope.control_points"], lambda: rope.control_points)
    timed(times["  rope.shape.point_at(0.5)"], lambda: rope.shape.point_at(0.5))
    timed(times["  (19 KB copied, to compare)"], lambda: bytearray(MESSAGE_BYTES))
    frame = reader.wait(30.0)
    assert frame.trace is not None
    times["wait(): from sent to in hand"].append((time.monotonic_ns() - frame.trace.fitted_ns) / 1e3)


def measure_ctypes(reader: OverCtypes, times: Times) -> None:
    reader.latest()
    timed(times["ctypes: receive, nothing new"], reader.latest)
    while not reader.subscriber.has_samples():
        reader.listener.timed_wait(reader.pause)
    message = timed(times["ctypes: receive, a new image"], reader.latest)

    def control_points() -> NDArray[np.float64]:
        rope = message["curves"][0]
        points: NDArray[np.float64] = rope["control_points"][: rope["count"]]
        return points

    points = timed(times["  the same control points"], control_points)
    timed(times["  the same point, by NumPy"], lambda: bezier(points, 0.5))
    message = reader.wait()
    assert message is not None
    times["ctypes: from sent to in hand"].append((time.monotonic_ns() - int(message["trace"]["fitted_ns"])) / 1e3)


def part(name: str, frames: int) -> None:
    """One reader's turn, in its own process; prints its times."""
    times: Times = defaultdict(list)
    if name == "ctypes":
        rival = OverCtypes()
        for _ in range(frames // 2):
            measure_ctypes(rival, times)
    else:
        with lariat.Reader(timeout=30.0) as reader:
            next(reader)
            for _ in range(frames // 2):
                measure_lariat(reader, times)
    print(json.dumps(times))


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--fps", type=int, default=200)
    arguments.add_argument("--frames", type=int, default=2000, help="how many of each reader")
    binary = Path(__file__).parents[2] / "target/release/lariat"
    arguments.add_argument("--lariat", type=Path, default=binary, metavar="PROGRAM", help="the chain's binary")
    arguments.add_argument("--part", help=argparse.SUPPRESS)
    options = arguments.parse_args()
    if options.part:
        return part(options.part, options.frames)
    os.environ["LARIAT_DOMAIN"] = f"bench{os.getpid() % 100_000}"
    parts = ["lariat", "ctypes"] if find_spec("iceoryx2") else ["lariat"]
    times: Times = defaultdict(list)
    chain = subprocess.Popen(
        [options.lariat, "run", "--fps", str(options.fps)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        with lariat.Reader(timeout=30.0) as reader:
            next(reader)
            for _ in range(ROUNDS):
                for name in parts:
                    turn = [sys.executable, __file__, "--part", name, "--frames", str(options.frames // ROUNDS)]
                    said = subprocess.run(turn, stdout=subprocess.PIPE, check=True).stdout
                    for row, values in json.loads(said.splitlines()[-1]).items():
                        times[row] += values
    finally:
        chain.terminate()
        chain.wait()
    print(f"{'µs':34}{'p50':>9}{'p99':>9}{'max':>9}")
    for row in times:
        p50, p99, worst = np.percentile(times[row], [50, 99, 100])
        print(f"{row:34}{p50:9.2f}{p99:9.2f}{worst:9.2f}")


if __name__ == "__main__":
    main()
