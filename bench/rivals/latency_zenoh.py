"""Four processes connected by zenoh's shared memory. They pass a frame and then messages of the
same sizes as lariat's, without doing the stages' work.

Each link is a session of its own between two peers, so nothing is routed. The frame is copied once,
into shared memory.
"""

import importlib.metadata
import json
import socket
import time

import pacing
import timing

(zenoh,) = timing.need("zenoh")

# Maximum number of messages in flight, with a margin.
SLOTS = 8


def free_ports(count):
    """Returns ports that are currently unused."""
    held = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in held]
    for one in held:
        one.close()
    return ports


def session(listen=None, connect=None):
    config = zenoh.Config()
    config.insert_json5("mode", '"peer"')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("transport/shared_memory/enabled", "true")
    endpoints = {"listen": listen, "connect": connect}
    for name, port in endpoints.items():
        points = [f"tcp/127.0.0.1:{port}"] if port else []
        config.insert_json5(f"{name}/endpoints", json.dumps(points))
    return zenoh.open(config)


def ends(ports, sizes, place):
    receive = send = None
    if place > 0:
        incoming = session(listen=ports[place - 1])
        subscriber = incoming.declare_subscriber(f"link/{place}")

        def receive(_session=incoming):
            # Sleeps until a message arrives. The parent ends the process if the link breaks.
            return subscriber.recv().attachment.to_bytes()

    if place < 3:
        outgoing = session(connect=ports[place])
        publisher = outgoing.declare_publisher(
            f"link/{place + 1}", congestion_control=zenoh.CongestionControl.BLOCK, express=True
        )
        provider = zenoh.shm.ShmProvider.default_backend(SLOTS * (sizes[place] + 4096))
        policy = zenoh.shm.BlockOn(zenoh.shm.GarbageCollect())
        deadline = time.monotonic() + pacing.TIMEOUT_S
        while not publisher.matching_status.matching and time.monotonic() < deadline:
            time.sleep(0.01)

        def send(header, payload, _session=outgoing):
            buffer = provider.alloc(sizes[place], policy=policy)
            buffer[:] = payload
            publisher.put(buffer, attachment=header)

    return receive, send


if __name__ == "__main__":
    pacing.settle()
    asked = pacing.request()
    ports = free_ports(3)
    sizes = [asked["width"] * asked["height"] * 3, pacing.CENTERLINES, pacing.DESCRIPTORS]
    versions = {"zenoh": importlib.metadata.version("eclipse-zenoh")}
    pacing.four(asked, lambda place: ends(ports, sizes, place), versions)
