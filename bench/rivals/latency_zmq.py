"""Four processes connected by ZeroMQ (PUSH and PULL on Unix sockets). They pass a frame and then
messages of the same sizes as lariat's, without doing the stages' work.
"""

import os
import tempfile

import pacing
import timing

(zmq,) = timing.need("zmq")


def ends(folder, place):
    context = zmq.Context()
    receive = send = None
    if place > 0:
        incoming = context.socket(zmq.PULL)
        incoming.setsockopt(zmq.RCVTIMEO, int(1000 * pacing.TIMEOUT_S))
        incoming.bind(f"ipc://{folder}/{place}")

        def receive():
            try:
                # Received without another copy. The payload is then in memory, as a user would find
                # it.
                header, payload = incoming.recv_multipart(copy=False)
            except zmq.Again:
                return None
            assert payload.buffer.nbytes
            return header.bytes

    if place < 3:
        outgoing = context.socket(zmq.PUSH)
        outgoing.setsockopt(zmq.LINGER, 1000)
        outgoing.connect(f"ipc://{folder}/{place + 1}")

        def send(header, payload):
            outgoing.send(header, zmq.SNDMORE)
            outgoing.send(payload, copy=False)

    return receive, send


if __name__ == "__main__":
    pacing.settle()
    with tempfile.TemporaryDirectory() as folder:
        asked = pacing.request()
        versions = {"pyzmq": zmq.__version__, "ZeroMQ": zmq.zmq_version()}
        pacing.four(asked, lambda place: ends(os.path.abspath(folder), place), versions)
