#!/usr/bin/env python3
"""Receives a PointCloud2 topic with rclpy, and prints the age of its messages by their stamps,
which must be on this machine's clock. It ends 3 s after the last message. Usage: hear.py TOPIC
(tests/bridge/run starts it).
"""

import json
import sys
import time

import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2

LONGEST_S, SILENCE_S = 60, 3


def main():
    rclpy.init()
    node, ages, last = rclpy.create_node("hear"), [], time.monotonic() + LONGEST_S

    def take(message):
        nonlocal last
        stamp = message.header.stamp
        ages.append((time.time_ns() - stamp.sec * 10**9 - stamp.nanosec) / 1e3)
        last = time.monotonic()

    node.create_subscription(PointCloud2, sys.argv[1], take, QoSProfile(depth=64, reliability=ReliabilityPolicy.BEST_EFFORT))
    while time.monotonic() < last + SILENCE_S:
        rclpy.spin_once(node, timeout_sec=0.1)
    ages.sort()
    at = lambda share: round(ages[int(share * (len(ages) - 1))], 1) if ages else None
    print(json.dumps({"count": len(ages), "p50_us": at(0.5), "p99_us": at(0.99), "p999_us": at(0.999), "max_us": at(1)}), flush=True)
    # rclpy may hang during shutdown.
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
