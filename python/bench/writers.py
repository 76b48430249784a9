"""Cost of writing a frame in Python, compared with a bare copy of its pixels: in turns, in one
process.

    pip install ./python
    python python/bench/writers.py [--width 640] [--height 480] [--frames 2000]

No chain runs, only a reader that receives each frame, so that every slot has been written
before.
"""

from __future__ import annotations

import argparse
import os
import time
from collections import defaultdict
from collections.abc import Callable

import numpy as np

import lariat


def timed(times: list[float], work: Callable[[], object]) -> None:
    begin = time.perf_counter_ns()
    work()
    times.append((time.perf_counter_ns() - begin) / 1e3)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--width", type=int, default=640)
    arguments.add_argument("--height", type=int, default=480)
    arguments.add_argument("--frames", type=int, default=2000)
    options = arguments.parse_args()
    os.environ["LARIAT_DOMAIN"] = f"bench{os.getpid() % 100_000}"
    shape = (options.height, options.width, 3)
    image = np.random.default_rng(1).integers(0, 256, shape, dtype=np.uint8)
    # One buffer per slot of the channel, because a copy into a single cached buffer would be
    # faster.
    targets = [np.zeros(shape, np.uint8) for _ in range(20)]
    times: dict[str, list[float]] = defaultdict(list)
    with lariat.Writer("frames") as frames, lariat.Frames() as reader:
        frames.write(image)
        reader.wait(1.0)
        for number in range(options.frames):
            target = targets[number % len(targets)]
            timed(times["bare copy (numpy.copyto)"], lambda: np.copyto(target, image))
            timed(times["write(image)"], lambda: frames.write(image))
            reader.wait(1.0)
            timed(times["write(image[..., ::-1])"], lambda: frames.write(image[..., ::-1]))
            reader.wait(1.0)

            def loan() -> None:
                with frames.loan(options.height, options.width, "rgb8"):
                    pass

            timed(times["loan and send, nothing copied"], loan)
            reader.wait(1.0)
    bare = np.median(times["bare copy (numpy.copyto)"])
    print(f"{'µs':34}{'p50':>9}{'p99':>9}{'p50/copy':>10}")
    for row, values in times.items():
        p50, p99 = np.percentile(values, [50, 99])
        print(f"{row:34}{p50:9.1f}{p99:9.1f}{p50 / bare:9.2f}×")


if __name__ == "__main__":
    main()
