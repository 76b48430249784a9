#!/usr/bin/env python3
"""Measures the latency that an open page adds to the chain: the same chain with and without one, in
alternation, in one run.

    tests/view/latency.py LARIAT [--rounds N] [--seconds N] [--load N] [--browser chromium] [-- FLAGS OF LARIAT RUN]

The page is a client that takes each frame and immediately requests the next, as a browser on
another machine does. With --browser, it is a browser on this machine, which draws with the same
cores. Prints the medians of p50 and p99 over the rounds, the median of the ratios within each
round, and how many statuses the page received. Run it on an otherwise idle machine; --load adds
busy programs.
"""

import argparse
import base64
import json
import os
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import threading


class Page:
    """A WebSocket that requests one frame after another."""

    def __init__(self, port):
        self.frames = self.statuses = 0
        self.socket = socket.create_connection(("127.0.0.1", port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((
            f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Protocol: lariat.view.v1\r\n\r\n"
        ).encode())
        self.stream = self.socket.makefile("rb")
        while self.stream.readline().strip():
            pass
        threading.Thread(target=self.run, daemon=True).start()

    def ask(self):
        text = b'{"type":"next","width":1280}'
        # A client must mask its bytes: here with zeros.
        self.socket.sendall(bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text)

    def run(self):
        try:
            self.ask()
            while True:
                first, length = self.stream.read(2)
                if length == 126:
                    (length,) = struct.unpack(">H", self.stream.read(2))
                elif length == 127:
                    (length,) = struct.unpack(">Q", self.stream.read(8))
                self.stream.read(length)
                self.statuses += first & 15 == 1
                if first & 15 == 2:
                    self.frames += 1
                    self.ask()
        except (OSError, ValueError):
            pass

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def latencies(lariat, folder, flags, view, browser):
    """p50 and p99 of one run, and the number of frames and statuses that the page received."""
    report = os.path.join(folder, "report")
    command = [lariat, "run", "--force", "--out", report, *flags]
    server = page = shown = None
    if view:
        port = free_port()
        server = subprocess.Popen([lariat, "view", "--port", str(port)], stderr=subprocess.PIPE, text=True)
        server.stderr.readline()
        if browser:
            address = f"http://127.0.0.1:{port}/"
            shown = subprocess.Popen(
                [browser, "--headless", "--no-sandbox", f"--user-data-dir={folder}/browser", "--remote-debugging-port=0", address],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        else:
            page = Page(port)
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=folder)
    if page:
        page.close()
    for process in [shown, server]:
        if process:
            process.terminate()
            process.wait()
    if done.returncode:
        sys.exit(done.stderr)
    with open(os.path.join(report, "summary.json")) as file:
        total = json.load(file)["latency_us"]["total"]
    return (total["p50"], total["p99"]), (page.frames, page.statuses) if page else (0, 0)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("lariat")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("--load", type=int, default=0, help="busy programs beside it")
    parser.add_argument("--browser")
    parser.add_argument("flags", nargs="*", help="of lariat run, behind --")
    asked = parser.parse_args()
    lariat = os.path.abspath(asked.lariat)
    os.environ.setdefault("LARIAT_DOMAIN", f"lat-{os.getpid()}")
    flags = ["--duration", f"{asked.seconds}s", *asked.flags]
    without, viewed, counts = [], [], []
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(asked.load)]
    with tempfile.TemporaryDirectory() as folder:
        for number in range(asked.rounds):
            pair = [(False, without), (True, viewed)]
            # The two take turns at being first.
            for view, into in pair if number % 2 == 0 else reversed(pair):
                figures, shown = latencies(lariat, folder, flags, view, asked.browser)
                into.append(figures)
                if view:
                    counts.append(shown)
    for process in busy:
        process.kill()
    print(f"{'':>8} {'without':>10} {'a page':>10} {'ratio':>7}")
    for place, name in enumerate(["p50, µs", "p99, µs"]):
        a, b = ([figures[place] for figures in runs] for runs in (without, viewed))
        ratio = statistics.median(y / x for x, y in zip(a, b))
        print(f"{name:>8} {statistics.median(a):10.0f} {statistics.median(b):10.0f} {ratio:7.3f}")
    if not asked.browser:
        frames, statuses = (statistics.median(kind) for kind in zip(*counts))
        print(f"in {asked.seconds} s the page was sent {frames:.0f} frames and {statuses:.0f} statuses")


main()
