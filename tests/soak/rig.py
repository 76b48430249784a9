"""A chain in its own domain, inspected and disturbed from outside; shared by the scripts in this
folder."""

import os
import re
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path

STAGES = ("capture", "extract", "fit", "sink")


def command(binary, domain, folder, *words, limit_s=15):
    """Runs a command of lariat in a domain; its exit code is None after a timeout."""
    try:
        return subprocess.run([str(binary), *words], env=dict(os.environ, LARIAT_DOMAIN=domain), cwd=folder, capture_output=True,
                              text=True, stdin=subprocess.DEVNULL, timeout=limit_s)
    except subprocess.TimeoutExpired as late:
        return subprocess.CompletedProcess(late.cmd, None, "", f"no end within {limit_s} s")


class Line:
    """A frame as reported by the reader `traces`."""

    def __init__(self, text):
        numbers = [int(number) for number in text.split()]
        self.fitted, self.exposed_ns, self.fitted_ns, self.in_hand_ns, self.settings = numbers[:5]
        self.restarts = dict(zip(STAGES, numbers[5:8]))
        self.ropes = numbers[8]


class Traces:
    """The reader `traces` and its frames."""

    def __init__(self, program, environment):
        self.lines = []
        self.news = threading.Condition()
        self.child = subprocess.Popen([program], env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                      stderr=subprocess.PIPE, text=True)
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        for text in self.child.stdout:
            with self.news:
                self.lines.append(Line(text))
                self.news.notify_all()

    def first(self, what, limit_s):
        """The next frame that satisfies `what`, and the time when Python received it; None after a
        timeout."""
        until = time.monotonic() + limit_s
        with self.news:
            at = max(len(self.lines) - 1, 0)
            while True:
                while at < len(self.lines):
                    if what(self.lines[at]):
                        return self.lines[at]
                    at += 1
                if not self.news.wait(until - time.monotonic()) and time.monotonic() >= until:
                    return None

    def end(self):
        self.child.kill()
        self.child.wait()


class Chain:
    """`lariat run` with these arguments."""

    def __init__(self, binary, domain, folder, words):
        self.binary, self.domain, self.folder = str(binary), domain, Path(folder)
        self.environment = dict(os.environ, LARIAT_DOMAIN=domain)
        self.said = []
        self.child = subprocess.Popen([self.binary, "run", *words], env=self.environment, cwd=folder, text=True,
                                      stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                      start_new_session=True)
        self.listener = threading.Thread(target=self.listen, daemon=True)
        self.listener.start()
        self.await_ready()

    def listen(self):
        for text in self.child.stderr:
            self.said.append((time.monotonic(), text.rstrip()))

    def await_ready(self):
        until = time.monotonic() + 30
        while not any("→" in text for _, text in self.said):
            if self.child.poll() is not None or time.monotonic() > until:
                raise SystemExit("the chain did not come up:\n" + self.text())
            time.sleep(0.01)

    def text(self):
        return "\n".join(text for _, text in self.said)

    def count(self, sentence):
        """Number of matching lines."""
        return sum(bool(re.search(sentence, text)) for _, text in self.said)

    def parts(self):
        """Its live parts, by name."""
        parts = {}
        children = Path(f"/proc/{self.child.pid}/task/{self.child.pid}/children").read_text().split()
        for pid in map(int, children):
            try:
                state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
                words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if state not in "ZX" and len(words) > 2:
                name = words[1].decode()
                parts["recorder" if name == "record" else name] = pid
        return parts

    def entry(self, stage, pid):
        """The entry of a ready stage, if its process is not this one."""
        for path in Path(f"/tmp/lariat-{self.domain}/lariat-roster").glob(f"default.{stage}.*"):
            if path.suffix != f".{pid}":
                return path
        return None

    def end(self, limit_s=90):
        """Ends the chain in order and returns its exit code; None if it did not end."""
        self.child.send_signal(signal.SIGTERM)
        try:
            code = self.child.wait(limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(self.child.pid, signal.SIGKILL)
            code = None
        self.listener.join(5)
        return code


def shared(domain):
    """The domain's files in shared memory, with their sizes in bytes."""
    found = {}
    for path in Path("/dev/shm").glob(f"lariat_{domain}_*"):
        try:
            found[path.name] = path.stat().st_blocks * 512
        except OSError:
            pass
    return found


def kept(domain):
    """Files in the domain's folder, without empty folders."""
    return [str(path) for path in Path(f"/tmp/lariat-{domain}").rglob("*") if not path.is_dir()]


def wipe(domain):
    shutil.rmtree(f"/tmp/lariat-{domain}", ignore_errors=True)
    for name in shared(domain):
        Path("/dev/shm", name).unlink(missing_ok=True)


def at(ordered, share):
    """The value at this share of a sorted list."""
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]
