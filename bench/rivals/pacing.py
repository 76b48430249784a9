"""Shared code of the latency rivals: paced frames, four processes in a row, and a line of JSON at
the end.

A script receives a request, `{"frames": "FILE", "width": 640, "height": 480, "count": 60, "fps":
120, "seconds": 2}`. The file holds `count` RGB images, which are sent in turn, repeatedly. For each
frame, the script prints the time from the moment it was due until the last process has it, in
nanoseconds of CLOCK_MONOTONIC.
"""

import ctypes
import json
import multiprocessing
import os
import signal
import struct
import sys
import time

# Sizes in bytes of the messages that follow the frame in lariat. The later links carry these sizes.
CENTERLINES, DESCRIPTORS = 26272, 15200
# Frames at the start that are not counted, while connections are made and caches filled.
WARM_UP = 10
# Time without a message after which a link is considered broken.
TIMEOUT_S = 5.0

HEADER = struct.Struct("=qq")

_libc = ctypes.CDLL(None)


def settle():
    """Makes this process end with its parent, and makes its sleeps end on time (the kernel's
    default slack is 50 µs).
    """
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _libc.prctl(1, signal.SIGTERM)
    _libc.prctl(29, 1)


def request():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} REQUEST.json (see the README beside it)")
    with open(sys.argv[1], encoding="utf-8") as file:
        return json.load(file)


def frames(asked):
    """Returns the bytes of the images."""
    size = asked["width"] * asked["height"] * 3
    with open(asked["frames"], "rb") as file:
        return [file.read(size) for _ in range(asked["count"])]


def due(asked):
    """Yields each frame's number and due time when the frame is due."""
    period_ns = 1e9 / asked["fps"]
    start_ns = time.monotonic_ns() + 50_000_000
    for number in range(WARM_UP + max(1, int(asked["seconds"] * asked["fps"]))):
        due_ns = int(start_ns + number * period_ns)
        left_ns = due_ns - time.monotonic_ns()
        if left_ns > 0:
            time.sleep(left_ns / 1e9)
        yield number, due_ns


def answer(whole_ns, versions, work_ns=None):
    line = {"whole_ns": whole_ns[WARM_UP:], "versions": versions}
    if work_ns is not None:
        line["work_ns"] = work_ns[WARM_UP:]
    print(json.dumps(line), flush=True)


def four(asked, ends, versions):
    """Runs four processes in a row: the first sends frames, two forward messages of the same sizes
    as lariat's, the last measures.

    `ends(place)` returns a process's receive() -> (header, buffer) and send(header, buffer). One of
    them is None in the first and the last process.
    """
    context = multiprocessing.get_context("fork")
    ready = [context.Event() for _ in range(4)]
    done = context.Event()
    result, its_end = context.Pipe(duplex=False)
    total = WARM_UP + max(1, int(asked["seconds"] * asked["fps"]))
    longest_s = asked["seconds"] + 2 * TIMEOUT_S

    def source(send):
        images = frames(asked)
        for event in ready:
            event.wait(TIMEOUT_S)
        for number, due_ns in due(asked):
            send(HEADER.pack(number, due_ns), images[number % len(images)])

    def middle(receive, send, payload):
        for _ in range(total):
            send(receive(), payload)

    def sink(receive):
        took_ns = []
        for _ in range(total):
            _, due_ns = HEADER.unpack(receive())
            took_ns.append(time.monotonic_ns() - due_ns)
        its_end.send(took_ns)

    def stage(place):
        settle()
        try:
            receive, send = ends(place)
            ready[place].set()
            if not receive:
                source(send)
            elif send:
                middle(receive, send, bytes({1: CENTERLINES, 2: DESCRIPTORS}[place]))
            else:
                sink(receive)
            done.wait(longest_s)
        except Exception as why:
            sys.exit(f"process {place + 1} of 4: {why!r}")

    processes = [context.Process(target=stage, args=(place,)) for place in range(4)]
    # When this process is terminated, it also ends the others and cleans up.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        for process in reversed(processes):
            process.start()
        took_ns = result.recv() if result.poll(longest_s) else []
    finally:
        remove = left_behind([process.pid for process in processes if process.pid])
        done.set()
        for process in processes:
            if process.pid:
                process.join(1.0)
                process.kill()
                process.join()
        for path in remove:
            if os.path.exists(path):
                os.unlink(path)
    if not took_ns:
        sys.exit("the four processes did not pass every message on in time")
    answer(took_ns, versions)


def left_behind(processes):
    """Returns the shared memory that zenoh leaves in /dev/shm when these processes end."""
    found = set()
    for process in processes:
        try:
            with open(f"/proc/{process}/maps", encoding="utf-8") as maps:
                paths = (line.split()[-1] for line in maps)
                found.update(p for p in paths if p.startswith("/dev/shm/") and p.endswith(".zenoh"))
        except OSError:
            pass
    return found
