"""Live plot of a chain's ropes: curve, control points, latency. Run `lariat run` alongside.

pip install matplotlib
python plot_live.py [--rig NAME] [--frames N] [--save FILE.png]
"""

import argparse
from collections import deque

import matplotlib.pyplot as plt
import numpy as np

import lariat

SHOWN = 200  # number of latencies shown
arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--rig", default="default", help="which camera chain")
arguments.add_argument("--frames", type=int, help="end after so many drawings")
arguments.add_argument("--save", metavar="FILE", help="save the last drawing")
options = arguments.parse_args()

figure, (scene, times) = plt.subplots(1, 2, figsize=(11, 5), width_ratios=[3, 2])
scene.set_aspect("equal")
times.set(xlabel="frame", ylabel="exposed → fitted, ms")
(line,) = times.plot([], [], ".-", markersize=3, linewidth=0.5)
latencies: deque[float] = deque(maxlen=SHOWN)
drawn = 0

with lariat.Reader(options.rig, timeout=0.5) as reader:
    for frame in reader:
        if frame.is_new and frame.trace:
            latencies.append(1e-6 * (frame.trace.fitted_ns - frame.trace.exposed_ns))
        width, height = frame.size
        for artist in [*scene.lines, *scene.texts]:
            artist.remove()
        scene.set_prop_cycle(None)
        scene.set_title(repr(frame).strip("<>").removeprefix("lariat."))
        if frame.unit == "px" and width:
            scene.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
        for seen in frame.ropes(max_age=0.5):
            match seen:
                case lariat.Fresh(rope) | lariat.Partial(rope) | lariat.Unsure(rope):
                    style = "-"
                case lariat.Lost() | lariat.Stale():
                    rope, style = seen.as_it_was, ":"
                case lariat.Absent():
                    continue
            points = rope.shape.points(200)
            (curve,) = scene.plot(*points.T, style, linewidth=2)
            scene.text(*points[0], f" {seen}", fontsize=8)
            if not rope.closed:
                scene.plot(*rope.control_points.T, "o--", color=curve.get_color(), markersize=4, linewidth=0.5)
        line.set_data(range(len(latencies)), latencies)
        times.set(xlim=(0, SHOWN), ylim=(0, 1.1 * max(latencies, default=1.0)))
        if latencies:
            times.set_title(f"latency: p50 {np.median(latencies):.2f}, p99 {np.percentile(latencies, 99):.2f} ms")
        plt.pause(0.001)
        drawn += 1
        if drawn == options.frames or not plt.fignum_exists(figure.number):
            break

if options.save:
    figure.savefig(options.save)
