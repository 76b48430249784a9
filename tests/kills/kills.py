#!/usr/bin/env python3
"""Kills processes of lariat at system calls selected by a seed, and checks what breaks.

    cargo build --release -p lariat -p lariat-wire --bins --example join_and_leave
    tests/kills/kills.py [--binary target/release/lariat] [--reader …] [--kills 200] [--seed 1] [--domain kills]
                         [--restart on-failure] KIND...

KIND selects the process to kill: `reader` (alone in its domain), `beside` (a reader next to a
running chain), `stages` (each process of a chain at its own call of this number, including the
recorder), `launcher` (only the chain's first process). After each kill, another process joins
within 2 s and leaves. Then nothing may be left in /dev/shm and in the domain's folder, and the
other chain must continue. Needs strace. Prints one line per KIND; the exit code is 1 if anything
broke."""

import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PATIENCE_S = 2.0
# Calls in which processes wait, or that neither create nor remove anything.
HARMLESS = {"brk", "clock_nanosleep", "rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "rt_sigsuspend", "sigaltstack",
            "mprotect", "wait4", "gettid", "getpid", "exit_group", "execve", "set_robust_list", "rseq", "arch_prctl",
            "prlimit64", "set_tid_address", "getrandom", "sched_getaffinity"}


def shared(domain):
    return {path.name for path in Path("/dev/shm").glob(f"lariat_{domain}_*")}


def kept(domain):
    """Files in the domain's folder, without empty folders and locks."""
    files = Path(f"/tmp/lariat-{domain}").rglob("*")
    return {path.name for path in files if not path.is_dir() and not path.name.endswith(".lock")}


def wipe(domain):
    shutil.rmtree(f"/tmp/lariat-{domain}", ignore_errors=True)
    for name in shared(domain):
        Path("/dev/shm", name).unlink(missing_ok=True)


class Rounds:
    def __init__(self, args):
        self.binary = str(Path(args.binary).resolve())
        self.reads = str(Path(args.reader).resolve())
        self.domain = args.domain
        self.random = random.Random(args.seed)
        self.kills = args.kills
        self.seconds = args.seconds
        self.scratch = tempfile.mkdtemp(prefix="kills-")
        self.environment = dict(os.environ, LARIAT_DOMAIN=args.domain)
        self.restart = ["--restart", args.restart]
        # A process that is killed at a call is killed there again after each restart.
        Path(self.scratch, "lariat.toml").write_text("[run]\nmax_restarts = 3\n")

    def reader(self):
        return [self.reads]

    def chain(self):
        return [self.binary, "run", "--quiet", "--source", "rendered", "--size", "320x240", "--fps", "200", "--frames", "4",
                "--record", f"{self.scratch}/kills.mcap", *self.restart]

    def files(self):
        return shared(self.domain) | kept(self.domain)

    def run(self, command, limit_s):
        """Exit code and error output, or a timeout; child processes end with it."""
        child = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.PIPE, start_new_session=True, cwd=self.scratch)
        try:
            error = child.communicate(timeout=limit_s)[1]
            return child.returncode, error.decode(errors="replace").strip()
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
            child.communicate()
            return None, "no end"

    def calls(self, command, follow):
        """System calls of the command, with their maximum number in any of its processes."""
        trace = Path(self.scratch, "calls")
        self.run(["strace", *follow, "-o", str(trace), *command], 30)
        count = {}
        for line in trace.read_text(errors="replace").splitlines():
            found = re.match(r"(?:(\d+) +)?(\w+)\(", line)
            if found and found[2] not in HARMLESS:
                key = (found[1], found[2])
                count[key] = count.get(key, 0) + 1
        most = {}
        for (_, call), times in count.items():
            most[call] = max(most.get(call, 0), times)
        return most

    def kill(self, command, follow, calls):
        call = self.random.choice(sorted(calls))
        when = self.random.randint(1, calls[call])
        for recording in Path(self.scratch).glob("kills*.mcap"):
            recording.unlink()
        self.run(["strace", *follow, "-qq", "-o", "/dev/null", "-e", f"inject={call}:signal=KILL:when={when}", *command], 15)
        # The processes of a chain briefly outlive their launcher.
        until = time.monotonic() + 5
        while any(self.domain in text for text in environments()) and time.monotonic() < until:
            time.sleep(0.01)
        return f"{call}#{when}"

    def look(self, kind):
        beside = None
        command, follow = {
            "reader": (self.reader(), ["-f"]),
            "beside": (self.reader(), ["-f"]),
            "stages": (self.chain(), ["-f"]),
            "launcher": (self.chain(), []),
        }[kind]
        broken = {"no join": 0, "left": 0, "chain": 0, "cured": 0}
        told = {}
        killed = 0

        def start():
            child = subprocess.Popen([self.binary, "run", "--quiet", "--source", "rendered", "--fps", "100", *self.restart],
                                     env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                     cwd=self.scratch)
            time.sleep(1.5)
            return child

        wipe(self.domain)
        calls = self.calls(command, follow)
        wipe(self.domain)
        began = time.monotonic()
        if kind == "beside":
            beside = start()
            usual = self.files()
        while killed < self.kills and time.monotonic() - began < self.seconds:
            point = self.kill_beside(command, calls) if beside else self.kill(command, follow, calls)
            killed += 1
            code, error = self.run(self.reader(), PATIENCE_S)
            failed = None
            if code != 0:
                failed = "no join"
            elif beside and beside.poll() is not None:
                failed = "chain"
            elif beside:
                # The chain's writer takes back its end of a connection with its next message.
                until = time.monotonic() + 0.5
                while self.files() != usual and time.monotonic() < until:
                    time.sleep(0.01)
                if self.files() != usual:
                    failed = "left"
                    error = " ".join(sorted(self.files() ^ usual))
            elif self.files():
                failed = "left"
                error = " ".join(sorted(self.files()))
            if not failed:
                continue
            broken[failed] += 1
            told.setdefault((failed, re.sub(r"\d{8,}", "N", error)[-300:]), []).append(point)
            if failed == "no join":
                self.run([self.binary, "doctor", "--clean"], 5)
                code, _ = self.run(self.reader(), PATIENCE_S)
                broken["cured"] += code == 0
            if beside:
                beside.kill()
                beside.wait()
                time.sleep(0.5)
                wipe(self.domain)
                beside = start()
                usual = self.files()
            else:
                wipe(self.domain)
        if beside:
            beside.terminate()
            beside.wait()
        wipe(self.domain)
        print(f"{kind}: {killed} kills, {broken['no join']} times no process could join (doctor cured {broken['cured']}), "
              f"{broken['left']} times files were left, {broken['chain']} times the chain beside ended", flush=True)
        for (failed, error), points in sorted(told.items(), key=lambda entry: -len(entry[1])):
            print(f"  {len(points)} × {failed}: {error or '(silent)'}  [{', '.join(points[:6])}]", flush=True)
        return broken["no join"] + broken["left"] + broken["chain"]

    def kill_beside(self, command, calls):
        call = self.random.choice(sorted(calls))
        when = self.random.randint(1, calls[call])
        self.run(["strace", "-f", "-qq", "-o", "/dev/null", "-e", f"inject={call}:signal=KILL:when={when}", *command], 5)
        return f"{call}#{when}"


def environments():
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            if path.parent.name != str(os.getpid()):
                text = path.read_bytes()
                if b"LARIAT_DOMAIN=" in text and b"lariat" in (path.parent / "comm").read_bytes():
                    yield text.decode(errors="replace")
        except OSError:
            pass


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("kinds", nargs="+", choices=["reader", "beside", "stages", "launcher"])
    words.add_argument("--binary", default="target/release/lariat")
    words.add_argument("--reader", default="target/release/examples/join_and_leave")
    words.add_argument("--kills", type=int, default=200)
    words.add_argument("--seconds", type=float, default=240, help="no new kill after so long, for each KIND")
    words.add_argument("--restart", default="never", help="of chains: on-failure restarts what is killed")
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--domain", default="kills")
    args = words.parse_args()
    for program in args.binary, args.reader:
        if not Path(program).is_file():
            words.error(f"{program} is not there: it is built as said above")
    rounds = Rounds(args)
    broken = sum([rounds.look(kind) for kind in args.kinds])
    shutil.rmtree(rounds.scratch)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
