#!/usr/bin/env python3
"""Measures the time without descriptors when a stage is killed and restarts in place.

    cargo build --release -p lariat -p lariat-wire --bins --example traces
    tests/soak/restarts.py [--binary target/release/lariat] [--kills 100] [--seed 1] [KIND...]

KIND is killed with SIGKILL at times selected by a seed: `capture` (of a rendered rope), `files`
(capture of a recording), `folder` (of a folder of pictures), `extract`, `fit`, `sink`. The time is
measured on the monotonic clock, from before the kill to the fit time in the first descriptor whose
trace names the new process. The sink makes no descriptors; its time ends when its entry among the
stages appears, which it writes when it is ready. Prints a row per KIND and its histogram: the
number within the target, the time that the new process ran on a core, and the time that it waited
for one, which is the cost of other programs. Also prints the machine's load. On a shared machine,
`chrt --fifo 5 tests/soak/restarts.py` shows the time without this cost. The exit code is 1 if a
stage did not come back."""

import argparse
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

from rig import Chain, Traces, at, command, wipe

# Target times for the return of each.
TARGET_MS = {"capture": 300, "files": 300, "folder": 300, "extract": 200, "fit": 100, "sink": 100}
LIMIT_S = 20


class Rounds:
    def __init__(self, args):
        self.binary = Path(args.binary).resolve()
        self.traces = str(Path(args.traces).resolve())
        self.domain, self.kills, self.pause_s, self.fps = args.domain, args.kills, args.pause, args.fps
        self.random = random.Random(args.seed)
        self.scratch = Path(tempfile.mkdtemp(prefix="restarts-"))
        # The pause before a restart doubles with each one within this window; here, each restart is
        # the first.
        Path(self.scratch, "lariat.toml").write_text("[run]\nmax_restarts = 100\nrestart_window_s = 0.3\n")

    def film(self):
        """Makes a recording of two seconds, and its pictures."""
        film = self.scratch / "film.mcap"
        if not film.exists():
            command(self.binary, self.domain, self.scratch, "run", "--quiet", "--frames", "200", "--lossless", "--fps", "100",
                    "--record", str(film), limit_s=120)
            done = command(self.binary, self.domain, self.scratch, "export", str(film), "--format", "png", "--out", "pictures",
                           limit_s=120)
            if done.returncode != 0:
                raise SystemExit(f"there is nothing to show: {done.stderr}")
        return film

    def measure(self, kind):
        """Times of all kills in ms, None for a stage that did not come back. Also, for each new
        process, how long it ran on a core until it was back, and how long it waited for one."""
        stage, words = kind, ["--source", "rendered"]
        if kind in ("files", "folder"):
            stage = "capture"
            film = self.film()
            words = ["--source", str(film if kind == "files" else self.scratch / "pictures"), "--loop"]
        chain = Chain(self.binary, self.domain, self.scratch, ["--restart", "on-failure", "--fps", str(self.fps), *words])
        traces = Traces(self.traces, chain.environment)
        if traces.first(lambda line: True, LIMIT_S) is None:
            raise SystemExit("no descriptor came:\n" + chain.text())
        times, shares = [], []
        for _ in range(self.kills):
            time.sleep(self.pause_s + self.random.random() * 2 / self.fps)
            pid = chain.parts()[stage]
            restarts = traces.lines[-1].restarts.get(stage)
            killed_ns = time.monotonic_ns()
            os.kill(pid, signal.SIGKILL)
            if restarts is None:
                took = self.until_ready(chain, stage, pid, killed_ns)
            else:
                new = (restarts + 1) % 256
                line = traces.first(lambda line: line.restarts[stage] == new, LIMIT_S)
                took = line and (line.fitted_ns - killed_ns) / 1e6
            times.append(took)
            shares.append(scheduled(chain.parts().get(stage)))
        traces.end()
        code = chain.end()
        said = chain.count(rf"{stage} was killed by signal 9 \(SIGKILL\); it is restarted")
        if code != 0 or said != self.kills:
            print(f"{kind}: exit code {code}, {said} of {self.kills} restarts said\n{chain.text()[-2000:]}")
            times.append(None)
        wipe(self.domain)
        return times, shares

    def until_ready(self, chain, stage, pid, killed_ns):
        while time.monotonic_ns() - killed_ns < LIMIT_S * 1e9:
            if chain.entry(stage, pid):
                return (time.monotonic_ns() - killed_ns) / 1e6
            time.sleep(0.0005)
        return None


def scheduled(pid):
    """Time that a process's first thread has run on a core, and has waited for one, in ms."""
    try:
        run, waited, _ = Path(f"/proc/{pid}/schedstat").read_text().split()
    except (OSError, ValueError):
        return 0, 0
    return int(run) / 1e6, int(waited) / 1e6


def histogram(times):
    """Histogram with bins that widen with the time."""
    edges = [0, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 500, 1000, 1e9]
    lines = []
    for low, high in zip(edges, edges[1:]):
        count = sum(low <= took < high for took in times)
        if count:
            name = f"{low:4.0f} – {high:.0f}" if high < 1e9 else f"{low:4.0f} –"
            lines.append(f"    {name:12} ms  {count:4}  {'▇' * max(1, round(40 * count / len(times)))}")
    return "\n".join(lines)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("kinds", nargs="*", metavar="KIND", help=" ".join(TARGET_MS))
    words.add_argument("--binary", default="target/release/lariat")
    words.add_argument("--traces", default="target/release/examples/traces")
    words.add_argument("--kills", type=int, default=100)
    words.add_argument("--pause", type=float, default=0.5, help="seconds between a stage's return and the next kill")
    words.add_argument("--fps", type=int, default=120)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--domain", default="restarts")
    args = words.parse_args()
    unknown = set(args.kinds) - set(TARGET_MS)
    if unknown:
        words.error(f"no such kind: {', '.join(unknown)}")
    for program in args.binary, args.traces:
        if not Path(program).is_file():
            words.error(f"{program} is not there: it is built as said above")
    rounds = Rounds(args)
    broken = False
    print("killed     kills     min     p50     p90     max ms   asked  within    core  waits for one, ms (p50)   load")
    for kind in args.kinds or TARGET_MS:
        times, shares = rounds.measure(kind)
        run, waited = (at(sorted(share), 0.5) for share in zip(*shares))
        back = sorted(took for took in times if took is not None)
        broken |= len(back) < len(times)
        target = TARGET_MS[kind]
        within = sum(took <= target for took in back)
        row = " ".join(f"{value:7.1f}" for value in (back[0], at(back, 0.5), at(back, 0.9), back[-1])) if back else "none came back"
        print(f"{kind:10} {len(times):5} {row}     {target:5} {within:7} {run:7.1f} {waited:7.1f} {os.getloadavg()[0]:24.1f}")
        print(histogram(back), flush=True)
    shutil.rmtree(rounds.scratch)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
