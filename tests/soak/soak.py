#!/usr/bin/env python3
"""Runs an unattended chain for an hour, with a different fault every few seconds.

    tests/soak/soak.py [--seconds 3600] [--seed 1] [--binary target/release/lariat] [--json FILE]

A rendered rope at 120 frames/s with a known centerline. A recorder keeps the last seconds in memory
and writes them on request, the settings file is watched, and there are eight readers: `traces` and
two of `control_loop` in Rust, three of `lariat topic`, and two more. `--c` and `--python` name
programs for these in other languages (examples/c/follow.c and examples/python/control_loop.py,
built and installed by the user with the library in its search path). Without them, `control_loop`
takes their place, which is reported. Every `--every` seconds there is a fault, selected by a seed:

  kill      a part (a stage or the recorder) is killed with SIGKILL
  stop      a stage is stopped for 3 s
  hang      a stage is stopped until the chain kills it (hang_s = 5)
  set       `lariat set` of a setting; now and then of an invalid one
  restart   `lariat restart` of a stage
  edit      the settings file is edited; now and then so that it is invalid
  reader    a reader is killed
  flush     the recorder is told to write what it holds
  disk      the same, onto a full disk
  shm       /dev/shm is full for 3 s, and a stage is killed meanwhile
  clock     the wall clock is an hour ahead for 3 s (only with --clock, because it affects the whole
            machine)

/dev/shm and the disk are small ones in a mount namespace of the script; without one, `disk` and
`shm` are skipped, which is reported. There is a minute without faults before the first one (a tenth
of the run, if that is less), and after the last one.

Afterwards, a run without faults shows as many frames of the same rope as fast as possible. Its
distances between curves and rope are the reference. Each requirement is a row of the final table.
Memory and files are compared by the medians of the first and the last third of the moments between
faults. The exit code is 1 if a requirement is violated."""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from rig import STAGES, Chain, Traces, at, command, kept, shared, wipe

FAULTS = {"kill": 5, "stop": 2, "hang": 1, "set": 3, "restart": 3, "edit": 2, "reader": 3, "flush": 1, "disk": 1, "shm": 1}
# None of these changes moves the curve away from the rope, so errors can be compared with those of
# a run without changes.
CHANGES = ["fit.solver=qr", "fit.solver=pinv", "fit.solver=cholesky", "fit.tolerance=0.05", "fit.tolerance=0.06",
           "extract.points=120", "extract.points=140", "extract.min_confidence=0.2", "extract.ropes=3"]
REFUSED = ["fit.control_points=100", "fit.odrer=3", "run.rig=other", "extract.network=none.weights"]
SETTINGS = """\
[run]
max_restarts = 1000
restart_window_s = 4
hang_s = 5
[record]
ring_s = 5
ring_mb = 48
[capture]
source = "rendered"
fps = {fps}
seed = 1
[simulation]
stiffness = {stiffness}
[fit]
# An order that is chosen depends on when a rope was seen.
control_points = 11
"""
# Time after a fault during which the chain may still be affected.
CALM_AFTER_S = 2.0
MB = 1 << 20


def in_namespace(args):
    """Restarts this script with its own /dev/shm, if allowed."""
    if "LARIAT_SOAK_OWN" in os.environ:
        return os.environ["LARIAT_SOAK_OWN"] == "1"
    for unshare in (["unshare", "--mount"], ["unshare", "--mount", "--map-root-user"]):
        try:
            works = subprocess.run([*unshare, "mount", "-t", "tmpfs", "none", "/dev/shm"], capture_output=True).returncode == 0
        except OSError:
            works = False
        if works:
            os.environ["LARIAT_SOAK_OWN"] = "1"
            mounts = f"mount -t tmpfs -o size={args.shm_mb}m none /dev/shm && exec \"$@\""
            os.execvp("unshare", [*unshare, "sh", "-c", mounts, "sh", sys.executable, *sys.argv])
    return False


class Readers:
    """Eight readers; one that has ended is started again."""

    def __init__(self, chain, traces, args):
        loop = str(Path(args.control_loop).resolve())
        topic = [chain.binary, "topic"]
        self.commands = {
            "traces": [traces],
            "control_loop": [loop],
            "control_loop 2": [loop],
            "echo": [*topic, "echo", "centerlines"],
            "hz": [*topic, "hz", "frames"],
            "delay": [*topic, "delay"],
            "C": [args.c] if args.c else [loop],
        }
        self.commands["Python"] = args.python.split() if args.python else [loop]
        self.chain, self.children, self.ended = chain, {}, {}
        for name in self.commands:
            self.start(name)

    def start(self, name):
        log = open(self.chain.folder / f"{name.replace(' ', '-')}.err", "a")
        self.children[name] = subprocess.Popen(self.commands[name], env=self.chain.environment, cwd=self.chain.folder,
                                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log)

    def look(self, killed=None):
        """Restarts readers that have ended; only the killed one should have."""
        for name, child in list(self.children.items()):
            if child.poll() is None:
                continue
            if name != killed:
                self.ended.setdefault(name, []).append(child.returncode)
            self.start(name)

    def end(self):
        for child in self.children.values():
            child.kill()
            child.wait()


class Soak:
    def __init__(self, args, owns):
        self.args, self.owns = args, owns
        self.random = random.Random(args.seed)
        self.scratch = Path(tempfile.mkdtemp(prefix="soak-"))
        self.disk = self.scratch / "disk"
        self.disk.mkdir()
        if owns:
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={args.disk_mb}m", "none", self.disk], check=True)
        self.traces = str(Path(args.traces).resolve())
        # Windows of the monotonic clock with a disturbance.
        self.amiss, self.made, self.problems = [], {}, []
        self.killed = dict.fromkeys((*STAGES, "recorder"), 0)
        self.renewed, self.samples = 0, []

    def chain(self, name, *words):
        folder = self.scratch / name
        folder.mkdir()
        Path(folder, "lariat.toml").write_text(self.settings())
        return Chain(Path(self.args.binary).resolve(), self.args.domain, folder, ["--out", "out", *words])

    def settings(self, stiffness=0.1):
        return SETTINGS.format(fps=self.args.fps, stiffness=stiffness)

    def command(self, *words):
        """Runs a command of lariat outside the chain's folder, because the settings file there may
        be invalid."""
        return command(self.main.binary, self.args.domain, self.scratch, *words)

    def run(self):
        wipe(self.args.domain)
        self.main = self.chain("soak", "--restart", "on-failure", "--watch", "--record", str(self.disk / "ring.mcap"))
        self.watcher = Traces(self.traces, self.main.environment)
        self.readers = Readers(self.main, self.traces, self.args)
        begin = time.monotonic()
        quiet = min(60, self.args.seconds / 10)
        threading.Thread(target=self.sample, daemon=True).start()
        kinds = {kind: weight for kind, weight in FAULTS.items() if self.owns or kind not in ("disk", "shm")}
        if self.args.clock:
            kinds["clock"] = 1
        if self.args.only:
            kinds = dict.fromkeys(self.args.only.split(","), 1)
        time.sleep(quiet)
        self.first_fault = time.monotonic()
        due = self.first_fault
        while due < begin + self.args.seconds - quiet and self.main.child.poll() is None:
            time.sleep(max(0, due - time.monotonic()))
            kind = self.random.choices(list(kinds), kinds.values())[0]
            since = time.monotonic()
            killed = getattr(self, f"do_{kind}")()
            self.amiss.append((since, time.monotonic(), kind))
            self.made[kind] = self.made.get(kind, 0) + 1
            if self.args.verbose:
                print(f"{since - begin:7.1f} s  {kind} {killed or ''}", flush=True)
            self.readers.look(killed if kind == "reader" else None)
            due = max(due + self.args.every, time.monotonic() + 1)
        self.last_fault = time.monotonic()
        time.sleep(quiet)
        self.has_ended = True
        return self.verdict(begin)

    has_ended = False

    def without_faults(self, frames):
        """Figures of a run without faults: the same ropes and number of frames, as fast as
        possible."""
        chain = self.chain("without", "--frames", str(frames), "--fps", "max", "--lossless")
        chain.child.wait()
        return json.loads(Path(chain.folder, "out", "summary.json").read_text())

    # The faults.

    def part(self, parts=STAGES):
        """A live part, and its process."""
        there = self.main.parts()
        name = self.random.choice([part for part in parts if part in there] or list(there))
        return name, there[name]

    def strike(self, parts=(*STAGES, "recorder")):
        name, pid = self.part(parts)
        os.kill(pid, signal.SIGKILL)
        self.killed[name] += 1
        return name

    def do_kill(self):
        return self.strike()

    def do_stop(self):
        name, pid = self.part()
        os.kill(pid, signal.SIGSTOP)
        time.sleep(3)
        os.kill(pid, signal.SIGCONT)
        return name

    def do_hang(self):
        name, pid = self.part()
        os.kill(pid, signal.SIGSTOP)
        until = time.monotonic() + 15
        while time.monotonic() < until and self.main.parts().get(name) == pid:
            time.sleep(0.05)
        if self.main.parts().get(name) == pid:
            self.problems.append(f"{name} hung for 15 s, and was not restarted")
            os.kill(pid, signal.SIGCONT)
            return name
        self.killed[name] += 1
        return name

    def do_set(self):
        if self.random.random() < 0.2:
            change = self.random.choice(REFUSED)
            if self.command("set", change).returncode != 1:
                self.problems.append(f"{change} was not refused")
            return change
        change = self.random.choice(CHANGES)
        self.must(self.command("set", change))
        return change

    def do_restart(self):
        name = self.random.choice(STAGES)
        self.must(self.command("restart", name))
        return name

    def must(self, done):
        if done.returncode != 0:
            self.problems.append(f"{' '.join(map(str, done.args[1:]))}: exit code {done.returncode}: {done.stderr.strip()}")
        self.renewed += done.stdout.count("restarted")

    def do_edit(self):
        file = Path(self.main.folder, "lariat.toml")
        if self.random.random() < 0.3:
            file.write_text(self.settings() + "solver = \"guess\"\n")
            return "nonsense"
        # The first change restarts capture, and does not alter the picture of a rendered rope.
        stiffness, solver = self.random.choice([0.1, 0.1, 0.2]), self.random.choice(["qr", "pinv", "cholesky"])
        file.write_text(self.settings(stiffness) + f"solver = \"{solver}\"\n")
        return f"stiffness {stiffness}, {solver}"

    def do_reader(self):
        name = self.random.choice(list(self.readers.children))
        self.readers.children[name].kill()
        self.readers.children[name].wait()
        return name

    def do_flush(self):
        self.must(self.command("record", "--flush"))
        time.sleep(2)
        files = sorted(self.disk.glob("*.mcap"))
        if not files:
            self.problems.append("the recorder wrote nothing when it was told to")
        for file in files:
            done = self.command("info", str(file))
            if done.returncode != 0:
                self.problems.append(f"{file.name} cannot be read: {done.stderr.strip()}")
            file.unlink()
        return f"{len(files)} files"

    def do_disk(self):
        ballast = self.disk / "ballast"
        fill(self.disk, ballast)
        self.command("record", "--flush")
        time.sleep(3)
        ballast.unlink(missing_ok=True)
        for file in self.disk.glob("*.mcap"):
            file.unlink()

    def do_shm(self):
        ballast = Path("/dev/shm/lariat-soak-ballast")
        fill("/dev/shm", ballast)
        name = self.strike()
        time.sleep(3)
        ballast.unlink(missing_ok=True)
        return name

    def do_clock(self):
        day, clock = time.time(), time.monotonic()
        time.clock_settime(time.CLOCK_REALTIME, day + 3600)
        time.sleep(3)
        time.clock_settime(time.CLOCK_REALTIME, day + time.monotonic() - clock)

    # Measurements.

    def sample(self):
        """Samples memory, file descriptors and files once a second."""
        while not self.has_ended and self.main.child.poll() is None:
            try:
                parts = dict(self.main.parts(), chain=self.main.child.pid)
                files = shared(self.args.domain)
                self.samples.append({
                    "at": time.monotonic(),
                    "rss": {part: resident(pid) for part, pid in parts.items()},
                    "open": {part: len(os.listdir(f"/proc/{pid}/fd")) for part, pid in parts.items()},
                    "shared": len(files),
                    "shared_mb": sum(files.values()) / MB,
                    "kept": len(kept(self.args.domain)),
                })
            except OSError:
                pass
            time.sleep(1)

    def is_calm(self, moment):
        return not any(since - 0.1 <= moment <= until + CALM_AFTER_S for since, until, _ in self.amiss)

    def verdict(self, begin):
        lasted = time.monotonic() - begin
        lines = self.watcher.lines
        self.watcher.end()
        self.readers.look()
        self.readers.end()
        code = self.main.end()
        left = [*shared(self.args.domain), *kept(self.args.domain)]
        rows = []

        def row(name, holds, said):
            rows.append({"what": name, "holds": bool(holds), "said": said})

        row("exit code", code == 0, str(code))
        summary = json.loads(Path(self.main.folder, "out", "summary.json").read_text())
        frames = summary["frames"]
        lost = {link: count for link, count in frames["lost"].items() if link != "source"}
        row("sent = received + lost", summary["finished"] and frames["published"] == frames["received"] + sum(lost.values()),
            f"{frames['published']} = {frames['received']} + {sum(lost.values())} "
            f"({', '.join(f'{link} {count}' for link, count in lost.items() if count)}); "
            f"{sum(frames['at_restart'].values())} at restarts")
        said = {part: self.main.count(rf"{part} was killed by signal (9|7) .*it is restarted") for part in self.killed}
        # Without shared memory a stage also fails by itself, and restarts repeatedly until there is
        # some.
        fell = self.main.count("failed with exit code .*it is restarted")
        row("every restart said", all(said[part] >= count for part, count in self.killed.items()),
            ", ".join(f"{part} {said[part]} of {count}" for part, count in self.killed.items()) + f"; {fell} fell by themselves")
        truth = self.without_faults(frames["published"])
        # A decreasing count would mean that the run started over.
        row("one run", all(a.fitted < b.fitted for a, b in zip(lines, lines[1:])), f"{len(lines)} frames seen, their numbers rise")
        for kind in ("centerline", "curve"):
            usual, now = (of["error_px"][kind] for of in (truth, summary))
            # The maximum over some million points depends on one frame: 120 or 140 points change it
            # by a third.
            allowed = {"mean": 1.25, "p95": 1.25, "p999": 1.25, "max": 2}
            row(f"{kind} on the rope", all(now[key] <= times * usual[key] + 0.01 for key, times in allowed.items()),
                "px " + ", ".join(f"{key} {now[key]:.3f} ({usual[key]:.3f} without faults)" for key in allowed))
        ropes = sum(line.ropes != 1 for line in lines)
        row("one rope", ropes <= len(lines) / 1000, f"{ropes} of {len(lines)} frames with another number of ropes")
        calm = [sample for sample in self.samples if self.is_calm(sample["at"])]
        third = len(calm) // 3
        # A part keeps the memory that a change of settings frees. A part that starts when readers
        # exist knows more of them than the first one did.
        for name, of, slack in (
            ("memory", lambda sample: sample["rss"], 16),
            ("open descriptors", lambda sample: sample["open"], 16),
            ("files", lambda sample: {"/dev/shm": sample["shared"], "MB": sample["shared_mb"], "folder": sample["kept"]}, 3),
        ):
            if third == 0:
                continue
            grown, of_each = [], []
            for part in of(calm[0]):
                first, last = (middle(of(sample).get(part) for sample in some) for some in (calm[:third], calm[-third:]))
                grown += [part] * (last > 1.1 * first + slack)
                of_each.append(f"{part} {first:.4g} → {last:.4g}")
            row(f"{name} flat", not grown, ", ".join(of_each))
        before = [line for line in lines if line.in_hand_ns < self.first_fault * 1e9]
        outside = [line for line in lines if line.in_hand_ns > self.first_fault * 1e9 and self.is_calm(line.exposed_ns / 1e9)]
        waits = [sorted((line.fitted_ns - line.exposed_ns) / 1e3 for line in part) for part in (before, outside)]
        if all(waits):
            (p50, p99), (now50, now99) = ((at(part, 0.5), at(part, 0.99)) for part in waits)
            row("latency outside of faults", now99 <= 1.5 * p99 + 1000,
                f"µs p50 {p50:.0f}, p99 {p99:.0f} before the first; p50 {now50:.0f}, p99 {now99:.0f} between them")
        row("readers go on", not self.readers.ended, str(self.readers.ended or "none ended by itself"))
        row("commands do what they say", not self.problems, "; ".join(self.problems) or "all did")
        row("nothing left", not left, " ".join(left[:5]) or "nothing")
        print(f"seed {self.args.seed}: {lasted:.0f} s, {sum(self.made.values())} faults: "
              + ", ".join(f"{count} {kind}" for kind, count in sorted(self.made.items())))
        for name, is_out in (("disk and shm (no mount namespace)", not self.owns), ("clock (--clock)", not self.args.clock),
                             ("a reader in C (--c)", not self.args.c), ("a reader in Python (--python)", not self.args.python)):
            if is_out:
                print(f"left out: {name}")
        for entry in rows:
            print(f"{'ok  ' if entry['holds'] else 'FAIL'} {entry['what']:30} {entry['said']}")
        print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
        if self.args.json:
            told = {"seed": self.args.seed, "seconds": lasted, "faults": self.made, "rows": rows, "summary": summary,
                    "samples": self.samples}
            Path(self.args.json).write_text(json.dumps(told, indent=1) + "\n")
        Path(self.scratch, "said").write_text(self.main.text() + "\n")
        broken = not all(entry["holds"] for entry in rows)
        if self.owns:
            subprocess.run(["umount", self.disk])
        if broken or self.args.keep:
            print(f"what the chain and the readers said: {self.scratch}")
        else:
            shutil.rmtree(self.scratch)
        wipe(self.args.domain)
        return 1 if broken else 0


def fill(folder, ballast):
    """Fills the remaining space except a few kilobytes."""
    room = os.statvfs(folder)
    with open(ballast, "wb") as file:
        os.posix_fallocate(file.fileno(), 0, max(room.f_bavail * room.f_frsize - 16384, 4096))


def middle(values):
    """Median of the values that exist."""
    return at(sorted(value for value in values if value is not None), 0.5)


def resident(pid):
    """Private memory of a process, in MB; shared memory is counted separately."""
    fields = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines() if ":" in line)
    return int(fields["RssAnon"].split()[0]) / 1024


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--binary", default="target/release/lariat")
    words.add_argument("--traces", default="target/release/examples/traces")
    words.add_argument("--control-loop", default="target/release/examples/control_loop")
    words.add_argument("--c", help="a reader in C")
    words.add_argument("--python", help="a reader in Python, as a command")
    words.add_argument("--seconds", type=float, default=3600)
    words.add_argument("--every", type=float, default=5)
    words.add_argument("--only", help="faults of these kinds alone: kill,stop")
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--fps", type=int, default=120)
    words.add_argument("--shm-mb", type=int, default=256)
    words.add_argument("--disk-mb", type=int, default=160)
    words.add_argument("--clock", action="store_true", help="move the machine's clock, too")
    words.add_argument("--domain", default="soak")
    words.add_argument("--json", help="write what the table says into this file, too")
    words.add_argument("--keep", action="store_true", help="keep what the chain and the readers said")
    words.add_argument("--verbose", action="store_true", help="say each fault")
    args = words.parse_args()
    return Soak(args, in_namespace(args)).run()


if __name__ == "__main__":
    sys.exit(main())
