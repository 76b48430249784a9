#!/usr/bin/env python3
"""Compares 3-D ropes that other nodes of a ROS 2 graph receive from `lariat ros2` with the output
of `lariat topic echo descriptors3 --json` for the same frames, and with the drawn rope.

rclpy receives `points`, `endpoints`, `path/<rope>` and `markers`; Cyclone DDS receives
`descriptors3`. Every field is compared, for each frame between a topic's first and last, in the
camera's axes and in a robot's. Usage: space.py MESSAGES (tests/ros2/run starts it; LARIAT and
LARIAT_ROS2 name the programs).
"""

import json
import math
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path as File

import numpy as np
import rclpy
from geometry_msgs.msg import PoseArray
from incoming import LARIAT, Rig, png
from nav_msgs.msg import Path
from peer import BASIS, FIT, STATUS, Cyclone, compare_all, curve, near, stamp_ns
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

WIDTH, HEIGHT, FOCAL, RADIUS_MM, TABLE_MM = 424, 240, 305.0, 6.0, 510.0
PICTURES = 8
CAMERA = f"image_width: {WIDTH}\nimage_height: {HEIGHT}\ncamera_matrix: [305, 0, 211.5, 0, 305, 119.5, 0, 0, 1]\ndistortion_coefficients: [0, 0, 0, 0]\n"
DEPTH = f"image_width: {WIDTH}\nimage_height: {HEIGHT}\nnoise_mm_at_1m: 3.6\nrange_mm: [200, 1500]\n"
# Above the table, looking down: x is the camera's, z points up.
POSE = "rotation: [1, 0, 0, 0]\ntranslation_mm: [0, 0, 510]\n"
ROBOT = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]]), np.array([0, 0, 510.0])
PLACE = {"known": 1}
POINT = struct.Struct("<fffIfffB3x")
FIELDS = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("rope", 12, 6), ("rho", 16, 7), ("width", 20, 7), ("sigma", 24, 7), ("status", 28, 2)]
# Nine of ten points in three dimensions are within this many standard deviations.
DEVIATIONS = 2.5002777


def axis(phase):
    """A rope that is lifted in its middle, in the camera's axes, mm."""
    t = np.linspace(0, 1, 160)
    return np.stack([-110 + 220 * t, 40 * np.sin(6 * t + phase), TABLE_MM - RADIUS_MM - 60 * np.sin(np.pi * t)], axis=1)


def draw(folder):
    """Draws the rope for the color camera and for a depth camera at the same place."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    rays = np.stack([(x - 211.5) / FOCAL, (y - 119.5) / FOCAL], axis=-1)
    for name in ("color", "depth"):
        (folder / name).mkdir()
    for number in range(PICTURES):
        depth = np.full((HEIGHT, WIDTH), TABLE_MM)
        for at in axis(2 * np.pi * number / PICTURES):
            off = np.linalg.norm(rays * at[2] - at[:2], axis=-1)
            raised = np.sqrt(np.maximum(RADIUS_MM**2 - off**2, 0))
            depth = np.where(off < RADIUS_MM, np.minimum(depth, at[2] - raised), depth)
        color = np.where((depth < TABLE_MM - 1e-9)[..., None], (160, 40, 30), (200, 200, 200)).astype(np.uint8)
        (folder / f"color/{number}.png").write_bytes(png(color))
        (folder / f"depth/{number}.png").write_bytes(png(depth.round().astype(np.uint16)))
    for name, text in (("camera", CAMERA), ("depth", DEPTH), ("pose", POSE)):
        (folder / f"{name}.yaml").write_text(text)


def turned(q):
    """The axes to which a quaternion rotates x, y and z, as columns."""
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def metres(point):
    return [c / 1e3 for c in point]


def place(point):
    return [point.x, point.y, point.z]


def is_pose(pose, at, direction, what):
    near(place(pose.position), metres(at), what)
    along, across, _ = turned(pose.orientation).T
    near(along, np.array(direction) / np.linalg.norm(direction), f"{what}, along the rope")
    near([across[2]], [0], f"{what}, level")


def ends(rope):
    points = np.array(rope["control_points"])
    return [(points[0], points[1] - points[0]), (points[-1], points[-1] - points[-2])]


def sure(meant):
    return [r for r in meant["curves"] if r["status"] in ("ok", "partial") and r["place"] == "known" and r["fit"] != "coarse"]


class Compared:
    """Comparisons for each topic, in this frame of reference."""

    def __init__(self, frame_id):
        self.frame_id = frame_id

    def points(self, message, meant):
        assert message.header.frame_id == self.frame_id, message.header
        assert [(f.name, f.offset, f.datatype) for f in message.fields] == FIELDS
        assert (message.height, message.point_step, message.is_bigendian, message.is_dense) == (1, POINT.size, False, True)
        assert message.row_step == message.width * POINT.size == len(message.data)
        wanted = []
        for rope in meant["curves"]:
            if rope["status"] == "lost" or rope["place"] != "known":
                continue
            steps = len(rope["points"]) - (not rope["closed"])
            for i, (at, sigma) in enumerate(zip(rope["points"], rope["sigmas"])):
                wanted.append((*metres(at), rope["track"], i / steps, rope["width"] / 1e3, sigma / 1e3, STATUS[rope["status"]]))
        rows = list(POINT.iter_unpack(bytes(message.data)))
        assert len(rows) == len(wanted) > 0
        for i, (row, want) in enumerate(zip(rows, wanted)):
            near(row, want, f"point {i}")

    def endpoints(self, message, meant):
        assert message.header.frame_id == self.frame_id
        wanted = [end for rope in sure(meant) for end in ends(rope)]
        assert len(message.poses) == len(wanted)
        for i, (pose, end) in enumerate(zip(message.poses, wanted)):
            is_pose(pose, *end, f"end {i}")

    def path(self, message, meant):
        [rope] = [rope for rope in sure(meant) if rope["track"] == 0]
        assert len(message.poses) == 64
        for i, pose in enumerate(message.poses):
            assert pose.header == message.header and pose.header.frame_id == self.frame_id
            near(place(pose.pose.position), metres(curve(rope, i / 63)), f"pose {i}")
        for pose, end in zip(message.poses[:: len(message.poses) - 1], ends(rope)):
            is_pose(pose.pose, *end, "an end")

    def markers(self, message, meant):
        first, *drawn = message.markers
        assert (first.action, first.header.frame_id) == (3, self.frame_id)
        drawn = iter(drawn)
        for rope in sure(meant):
            line, control = next(drawn), next(drawn)
            assert (line.ns, line.id, line.type, len(line.points)) == ("curve", rope["track"], 4, 96)
            for i, at in enumerate(line.points):
                near(place(at), metres(curve(rope, i / 95)), f"curve {i}")
            near([line.scale.x, control.scale.x], [0.3e-3 * rope["width"], 0.5e-3 * rope["width"]], "widths")
            assert (control.ns, control.id, control.type) == ("control_points", rope["track"], 7)
            near([c for p in control.points for c in place(p)], [c for p in rope["control_points"] for c in metres(p)], "control points")
            for i, (at, (xx, xy, xz, yy, yz, zz)) in enumerate(zip(rope["control_points"], rope["covariances"])):
                marker = next(drawn)
                assert (marker.ns, marker.id, marker.type) == ("covariance", 32 * rope["track"] + i, 2)
                near(place(marker.pose.position), metres(at), f"ellipsoid {i}")
                axes = turned(marker.pose.orientation)
                near((axes.T @ axes).flat, np.eye(3).flat, "axes")
                variances = (1e3 * np.array(place(marker.scale)) / 2 / DEVIATIONS) ** 2
                meant_too = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
                near((axes @ np.diag(variances) @ axes.T).flat, meant_too.flat, f"covariance {i}", 1e-6 * np.abs(meant_too).max())
        assert next(drawn, None) is None, "more was drawn than there is"

    def descriptors3(self, message, meant):
        for name, value in meant["trace"].items():
            assert getattr(message.trace, name) == value, name
        assert len(message.curves) == len(meant["curves"])
        for rope, want in zip(message.curves, meant["curves"]):
            said = dict(want, status=STATUS[want["status"]], basis=BASIS[want["basis"]], fit=FIT[want["fit"]], place=PLACE[want["place"]])
            said["border"] = sum(bit << end for end, bit in enumerate(want["border"]))
            for name, value in said.items():
                if isinstance(value, (bool, int, float)):
                    near([getattr(rope, name)], [value], name)
            for name in ("control_points", "velocities", "points"):
                near([c for p in getattr(rope, name) for c in place(p)], [c for p in want[name] for c in p], name)
            covariances = [c for v in rope.covariances for c in (v.xx, v.xy, v.xz, v.yy, v.yz, v.zz)]
            near(covariances, [c for v in want["covariances"] for c in v], "covariances")
            for name in ("weights", "knots", "sigmas"):
                near(getattr(rope, name), want[name], name)


def part(folder, count, chain, bridge, frame_id, axes):
    """Tests one rig: compares all topics, and then the points with the drawn rope."""
    depth = ["--depth-images", str(folder / "depth"), "--depth", str(folder / "depth.yaml"), "--calibration", str(folder / "camera.yaml")]
    source = ["--source", str(folder / "color"), "--loop", "--fps", "20"]
    with Rig([*source, *depth, *chain], bridge) as rig:
        rig.until(lambda: rig.points, "points")
        echo = subprocess.Popen([LARIAT, "topic", "echo", "descriptors3", "--rig", rig.name, "--json"], stdout=subprocess.PIPE, text=True)
        said = []
        threading.Thread(target=lambda: said.extend(map(json.loads, echo.stdout)), daemon=True).start()
        held = Compared(frame_id.format(rig=rig.name))
        topics = {
            "points": (PointCloud2, held.points),
            "endpoints": (PoseArray, held.endpoints),
            "path/rope_0": (Path, held.path),
            "markers": (MarkerArray, held.markers),
        }
        # On a loaded machine, rclpy is late by seconds, because it makes an object of each marker.
        qos = QoSProfile(depth=500, reliability=ReliabilityPolicy.RELIABLE)
        received = {name: [] for name in topics}
        for name, (kind, _) in topics.items():
            hear = lambda message, name=name: received[name].append((time.monotonic_ns(), message))
            rig.node.create_subscription(kind, f"/lariat/{rig.name}/{name}", hear, qos)
        cyclone, dds = Cyclone(rig.name, "Descriptors3"), []
        enough = lambda: dds.extend(cyclone.take()) or min(len(dds), *map(len, received.values())) >= count
        rig.until(enough, f"{count} messages of each topic", 30 + count / 10)
        rig.spin(0.5)
        values = rig.values()
        assert values["messages not sent"] == "0", values
        echo.terminate()
        echo.wait()

        offset = time.time_ns() - time.monotonic_ns()
        frames = {meant["trace"]["sequence"]: meant for meant in said}
        exposed = {meant["trace"]["exposed_ns"]: sequence for sequence, meant in frames.items()}
        for name, (_, compare) in topics.items():
            came, ages = {}, []
            for at, message in received[name]:
                then = stamp_ns(message) - offset
                known = min(exposed, key=lambda ns: abs(ns - then))
                # Clocks may have been adjusted slightly since.
                if abs(known - then) < 2_000_000:
                    came[exposed[known]] = message
                    ages.append((at - frames[exposed[known]]["trace"]["fitted_ns"]) / 1e6)
            compare_all(name, came, compare, frames, ages)
        came = {message.trace.sequence: message for message in dds if message.trace.sequence in frames}
        compare_all("descriptors3", came, held.descriptors3, frames, [])
        assert {meant["axes"] for meant in said} == {axes}
        drawn = [axis(2 * math.pi * number / PICTURES) for number in range(PICTURES)]
        if axes == "robot":
            turn, move = ROBOT
            drawn = [line @ turn.T + move for line in drawn]
        worst = 0
        for _, cloud in received["points"]:
            at = 1e3 * np.array([row[:3] for row in POINT.iter_unpack(bytes(cloud.data))])
            off = [np.linalg.norm(at[:, None] - line, axis=-1).min(axis=1).mean() for line in drawn]
            worst = max(worst, min(off))
        assert worst < 2, f"points are {worst:.2f} mm beside the rope that was drawn"
        print(f"in {frame_id}, the {axes}'s axes: points are at most {worst:.2f} mm from the rope that was drawn, on average over a message")


def main():
    count = int(sys.argv[1])
    rclpy.init()
    with tempfile.TemporaryDirectory() as folder:
        folder = File(folder)
        draw(folder)
        part(folder, count, [], [], "{rig}_camera", "camera")
        pose = ["--pose", str(folder / "pose.yaml")]
        part(folder, 60, pose, [], "{rig}", "robot")
        part(folder, 60, [*pose, "--lossless"], ["--frame-id", "table"], "table", "robot")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
