#!/usr/bin/env python3
"""Measures the latency that recording adds to the chain: the same chain with and without it, in
alternation, in one run.

    tests/record/latency.py LARIAT [--folder DIR] [--rounds N] [--seconds N] [-- FLAGS OF LARIAT RUN]

Prints the medians of p50 and p99 over the rounds, and the median of the ratios within each round.
Fails if a recording has dropped anything. Uses raw 640x480 RGB at 60 frames/s unless flags set
something else. Run it on an otherwise idle machine.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile


def latencies(lariat, folder, flags):
    """p50 and p99 of one run, and its output."""
    report = os.path.join(folder, "report")
    command = [lariat, "run", "--force", "--out", report, *flags]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=folder)
    if done.returncode:
        sys.exit(done.stderr)
    with open(os.path.join(report, "summary.json")) as file:
        total = json.load(file)["latency_us"]["total"]
    return (total["p50"], total["p99"]), done.stderr


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("lariat")
    parser.add_argument("--folder", help="on the disk that is recorded to")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("flags", nargs="*", help="of lariat run, behind --")
    asked = parser.parse_args()
    lariat = os.path.abspath(asked.lariat)
    os.environ.setdefault("LARIAT_DOMAIN", f"lat-{os.getpid()}")
    flags = ["--fps", "60", "--duration", f"{asked.seconds}s", *asked.flags]
    without, recorded = [], []
    with tempfile.TemporaryDirectory(dir=asked.folder) as folder:
        for number in range(asked.rounds):
            file = os.path.join(folder, "run.mcap")
            pair = [([], without), (["--record", file], recorded)]
            # The two take turns at being first.
            for more, into in pair if number % 2 == 0 else reversed(pair):
                figures, said = latencies(lariat, folder, flags + more)
                into.append(figures)
                if more:
                    sentence = next(line for line in said.splitlines() if "recorded" in line)
                    if "nothing was dropped" not in sentence:
                        sys.exit(sentence)
                    os.remove(file)
    print(f"{'':>8} {'without':>10} {'recorded':>10} {'ratio':>7}")
    for place, name in enumerate(["p50, µs", "p99, µs"]):
        a, b = ([figures[place] for figures in runs] for runs in (without, recorded))
        ratio = statistics.median(y / x for x, y in zip(a, b))
        print(f"{name:>8} {statistics.median(a):10.0f} {statistics.median(b):10.0f} {ratio:7.3f}")
    print(f"medians of {asked.rounds} rounds of {asked.seconds} s; nothing was dropped")


if __name__ == "__main__":
    main()
