#!/usr/bin/env python3
"""Picture of the markers in docs/ros2.md: the `markers` and `points` that rclpy receives from a
rig, drawn over the frame of the same stamp.

    lariat run --source rendered --rig cell & lariat ros2 --rig cell &
    pip install pillow; tests/ros2/picture.py cell docs/ros2-markers.webp     # in an environment with rclpy, as tests/ros2/run makes them

Every marker is drawn by its own type, position, size and color; this script knows nothing about
ropes.
"""

import io
import math
import sys
import time

import numpy as np
import rclpy
from PIL import Image, ImageDraw
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage, PointCloud2
from visualization_msgs.msg import Marker, MarkerArray

# Factor of supersampling, for smooth edges.
FINE = 4
# Scale of the picture relative to the rig's view, and margin around the ropes in pixels.
LARGE, MARGIN = 2, 60
PAUSE_S, LONGEST_S = 2, 60


def stamp(header):
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def received(rig):
    """Receives a frame, its markers and its points."""
    rclpy.init()
    node = rclpy.create_node("picture")
    came = {}
    best_effort = QoSProfile(depth=8, reliability=ReliabilityPolicy.BEST_EFFORT)

    def hear(kind, name, header):
        def take(message):
            came.setdefault(stamp(header(message)), {})[name] = message

        node.create_subscription(kind, f"/lariat/{rig}/{name}", take, best_effort)

    hear(CompressedImage, "image/compressed", lambda message: message.header)
    hear(PointCloud2, "points", lambda message: message.header)
    hear(MarkerArray, "markers", lambda message: message.markers[0].header)
    begin = time.monotonic()
    while time.monotonic() < begin + LONGEST_S:
        rclpy.spin_once(node, timeout_sec=0.1)
        whole = [messages for messages in came.values() if len(messages) == 3]
        crossed = [m for m in whole if any(marker.ns == "crossings" for marker in m["markers"].markers)]
        if time.monotonic() > begin + PAUSE_S and crossed:
            return crossed[-1]
    sys.exit(f"no frame with a crossing came of rig {rig} in {LONGEST_S} s: of {len(came)} something did")


def color(c):
    return tuple(round(255 * part) for part in (c.r, c.g, c.b, c.a))


class Drawing:
    """A picture seen straight from above, with this many of its pixels per meter or pixel."""

    def __init__(self, picture, scale):
        self.scale = scale
        self.size = [side * scale for side in picture.size]
        self.picture = picture.convert("RGBA").resize(self.size, Image.Resampling.BICUBIC)

    def layer(self, draw):
        """Draws with transparent colors over the existing content."""
        layer = Image.new("RGBA", self.size)
        draw(ImageDraw.Draw(layer))
        self.picture.alpha_composite(layer)

    def at(self, point):
        # The middle of a pixel is a whole number.
        return (self.scale * (point.x + 0.5), self.scale * (point.y + 0.5))

    def marker(self, marker):
        fill = color(marker.color)
        if marker.type == Marker.LINE_STRIP:
            width = max(round(self.scale * marker.scale.x), 1)
            points = [self.at(point) for point in marker.points]
            self.layer(lambda d: d.line(points, fill, width, joint="curve"))
        elif marker.type == Marker.SPHERE_LIST:
            self.layer(lambda d: [d.circle(self.at(p), self.scale * marker.scale.x / 2, fill) for p in marker.points])
        elif marker.type in (Marker.CYLINDER, Marker.SPHERE):
            yaw = 2 * math.atan2(marker.pose.orientation.z, marker.pose.orientation.w)
            turns = [2 * math.pi * i / 90 for i in range(90)]
            x, y = self.at(marker.pose.position)
            long, short = (self.scale * side / 2 for side in (marker.scale.x, marker.scale.y))
            around = [(long * math.cos(t), short * math.sin(t)) for t in turns]
            outline = [(x + a * math.cos(yaw) - b * math.sin(yaw), y + a * math.sin(yaw) + b * math.cos(yaw)) for a, b in around]
            self.layer(lambda d: d.polygon(outline, fill, (*fill[:3], 255), 2))

    def points(self, cloud):
        rows = np.frombuffer(bytes(cloud.data), np.uint8).reshape(-1, cloud.point_step)
        radius = self.scale * 0.7
        places = [(self.scale * (x + 0.5), self.scale * (y + 0.5)) for x, y in rows[:, :8].copy().view(np.float32)]
        self.layer(lambda d: [d.circle(at, radius, (20, 20, 20, 160)) for at in places])


def height(marker):
    return marker.points[0].z if marker.points else marker.pose.position.z


def main():
    rig, path = sys.argv[1:]
    came = received(rig)
    frame = Image.open(io.BytesIO(bytes(came["image/compressed"].data)))
    drawing = Drawing(frame, FINE)
    markers = sorted((m for m in came["markers"].markers if m.action == Marker.ADD), key=height)
    for marker in markers:
        drawing.marker(marker)
    drawing.points(came["points"])
    places = [(point.x, point.y) for marker in markers for point in marker.points]
    box = []
    for side, at in zip(frame.size, zip(*places)):
        box.append((max(round(min(at)) - MARGIN, 0), min(round(max(at)) + MARGIN, side)))
    (left, right), (top, bottom) = box
    part = drawing.picture.convert("RGB").crop([FINE * side for side in (left, top, right, bottom)])
    part.resize([LARGE * (right - left), LARGE * (bottom - top)], Image.Resampling.LANCZOS).save(path, quality=80, method=6)


if __name__ == "__main__":
    main()
