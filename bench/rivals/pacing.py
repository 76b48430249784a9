"""What the rivals in latency share: frames when they are due, four processes in a row, a line of JSON at the end.

A script is given a request, `{"frames": "FILE", "width": 640, "height": 480, "count": 60, "fps": 120, "seconds": 2}`: the
file holds `count` RGB images, which are sent one after the other, again and again. It prints for each frame how long it
was under way, from the moment it was due to the last process's hands, in nanoseconds of CLOCK_MONOTONIC.
"""

import ctypes
import json
import multiprocessing
import signal
import struct
import sys
import time

# Bytes of lariat's own messages after the frame: what the later links carry.
CENTERLINES, DESCRIPTORS = 26272, 15200
# Frames at the beginning that are not counted: connections are made, caches filled.
WARM_UP = 10
# A link that carries nothing for this long is broken.
TIMEOUT_S = 5.0

HEADER = struct.Struct("=qq")

_libc = ctypes.CDLL(None)


def settle():
    """Ends this process with its parent, and lets its sleeps end when they are due (the kernel's leeway is 50 µs)."""
    _libc.prctl(1, signal.SIGTERM)
    _libc.prctl(29, 1)


def request():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} REQUEST.json (see the README beside it)")
    with open(sys.argv[1], encoding="utf-8") as file:
        return json.load(file)


def frames(asked):
    """The images, as one buffer each."""
    size = asked["width"] * asked["height"] * 3
    with open(asked["frames"], "rb") as file:
        data = memoryview(file.read())
    return [data[i * size : (i + 1) * size] for i in range(asked["count"])]


def due(asked):
    """Each frame's number and the moment it is due, at that moment."""
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
    """Four processes in a row: the first sends frames, two pass on messages of the sizes of lariat's, the last counts.

    `ends(place)` makes a process's receive() -> (header, buffer) and send(header, buffer); either is None at an end.
    """
    context = multiprocessing.get_context("fork")
    ready = [context.Event() for _ in range(4)]
    whole = context.SimpleQueue()
    total = WARM_UP + max(1, int(asked["seconds"] * asked["fps"]))

    def stage(place):
        settle()
        receive, send = ends(place)
        ready[place].set()
        if place == 0:
            images = frames(asked)
            for event in ready:
                event.wait(TIMEOUT_S)
            for number, due_ns in due(asked):
                send(HEADER.pack(number, due_ns), images[number % len(images)])
            return
        payload = bytes([0, CENTERLINES, DESCRIPTORS, 0][place])
        took_ns = []
        for _ in range(total):
            got = receive()
            if got is None:
                break
            if send:
                send(got, payload)
            else:
                took_ns.append(time.monotonic_ns() - HEADER.unpack(got)[1])
        if not send:
            whole.put(took_ns)

    processes = [context.Process(target=stage, args=(place,)) for place in range(4)]
    for process in reversed(processes):
        process.start()
    deadline = time.monotonic() + asked["seconds"] + 4 * TIMEOUT_S
    for process in processes[:3]:
        process.join(max(0.0, deadline - time.monotonic()))
    took_ns = [] if whole.empty() and not processes[3].is_alive() else whole.get()
    for process in processes:
        process.terminate()
        process.join()
    answer(took_ns, versions)
