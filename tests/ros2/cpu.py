#!/usr/bin/env python3
"""Cost of `lariat ros2`, in percent of a core: idle, without subscribers, and while rclpy
subscribes to a rendered rope's topics at 30/s. Includes all its threads, by the kernel's own count,
and prints the machine's load next to it.

    tests/ros2/cpu.py [SECONDS]     60 each by default; in an environment with rclpy, as tests/ros2/run makes them. LARIAT and LARIAT_ROS2 name the programs
"""

import os
import signal
import subprocess
import sys
import time

LARIAT = os.environ.get("LARIAT", "lariat")
BRIDGE = os.environ.get("LARIAT_ROS2", "lariat-ros2")
KINDS = {
    "points": ("sensor_msgs", "PointCloud2"),
    "endpoints": ("geometry_msgs", "PoseArray"),
    "path/rope_0": ("nav_msgs", "Path"),
    "markers": ("visualization_msgs", "MarkerArray"),
    "diagnostics": ("diagnostic_msgs", "DiagnosticArray"),
    "image/compressed": ("sensor_msgs", "CompressedImage"),
    "overlay/compressed": ("sensor_msgs", "CompressedImage"),
}
SHAPES = ["points", "endpoints", "path/rope_0", "markers", "diagnostics"]
PICTURES = ["image/compressed", "overlay/compressed"]


def listen(topics):
    """Subscribes to the topics and ignores the messages, in a separate process."""
    from importlib import import_module

    import rclpy
    from rclpy.qos import QoSProfile, ReliabilityPolicy

    rclpy.init()
    node = rclpy.create_node("listener")
    for topic in topics:
        package, kind = KINDS[topic]
        kind = getattr(import_module(f"{package}.msg"), kind)
        node.create_subscription(kind, f"/lariat/cpu/{topic}", lambda _: None, QoSProfile(depth=8, reliability=ReliabilityPolicy.BEST_EFFORT))
    rclpy.spin(node)


def spent(pid):
    """CPU time of the process's threads in seconds, and their number of wake-ups."""
    run_ns = woken = 0
    for task in os.listdir(f"/proc/{pid}/task"):
        run_ns += int(open(f"/proc/{pid}/task/{task}/schedstat").read().split()[0])
        status = dict(line.split(":", 1) for line in open(f"/proc/{pid}/task/{task}/status"))
        woken += int(status["voluntary_ctxt_switches"])
    return run_ns / 1e9, woken


def measure(what, pid, seconds):
    time.sleep(5)
    (run, woken), begin = spent(pid), time.monotonic()
    time.sleep(seconds)
    (run_now, woken_now), took = spent(pid), time.monotonic() - begin
    load = os.getloadavg()[0]
    print(f"{what:<60} {100 * (run_now - run) / took:7.3f} % of a core, {(woken_now - woken) / took:6.1f} wakings/s; load {load:.1f}", flush=True)


def end(process, how=signal.SIGINT):
    process.send_signal(how)
    process.wait()


def main():
    if sys.argv[1:2] == ["listen"]:
        return listen(sys.argv[2:])
    seconds = float(sys.argv[1]) if sys.argv[1:] else 60
    os.environ |= {"LARIAT_DOMAIN": f"cpu-{os.getpid()}", "ROS_DOMAIN_ID": str(1 + os.getpid() % 99), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    words = [BRIDGE, "--rig", "cpu"]
    for more in (["--best-effort"], []):
        bridge = subprocess.Popen([*words, *more], stderr=subprocess.DEVNULL)
        measure(" ".join(["nobody listens", *more]), bridge.pid, seconds)
        end(bridge)
    chain = subprocess.Popen([LARIAT, "--quiet", "run", "--source", "rendered", "--rig", "cpu", "--fps", "30"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    bridge = subprocess.Popen(words, stderr=subprocess.DEVNULL)
    for topics in (["points"], SHAPES, PICTURES[:1], PICTURES):
        listener = subprocess.Popen([sys.executable, __file__, "listen", *topics])
        measure(", ".join(topics), bridge.pid, seconds)
        # rclpy may hang during shutdown.
        end(listener, signal.SIGKILL)
        time.sleep(2)
    end(bridge)
    end(chain)


if __name__ == "__main__":
    main()
