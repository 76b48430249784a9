#!/usr/bin/env python3
"""Compares the messages that other nodes of a ROS 2 graph receive from `lariat ros2` with the
output of `lariat topic echo --json` for the same frames.

rclpy receives `points`, `endpoints`, `path/<rope>`, `markers` and `diagnostics` over Fast DDS.
Cyclone DDS receives `descriptors`, with a type made from the `.msg` files, because rclpy has that
package only in a workspace. Every field is compared, and each frame between a topic's first and
last must have arrived. Finally, the size, type and stamp of some pictures are compared; a picture
takes a debug build longer than a frame. Usage: peer.py RIG MESSAGES (tests/ros2/run starts it, with
the chain and the bridge).
"""

import json
import math
import os
import re
import struct
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path as File
from types import new_class

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import Path
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage, PointCloud2
from visualization_msgs.msg import MarkerArray

SCHEMAS = File(__file__).resolve().parents[2] / "crates/record/schemas"
STATUS = {"ok": 1, "partial": 2, "lost": 3, "doubtful": 4}
BASIS = {"bezier": 1, "bspline": 2}
FIT = {"not judged": 0, "good": 1, "coarse": 2}
# Nine of ten points in a plane are within this many standard deviations.
DEVIATIONS = math.sqrt(-2 * math.log(0.1))
PICTURES = 20
POINT = struct.Struct("<fffIffBB2x")
FIELDS = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("rope", 12, 6), ("rho", 16, 7), ("width", 20, 7), ("hidden", 24, 2), ("status", 25, 2)]


def near(a, b, what, tolerance=1e-6):
    a, b = list(a), list(b)
    assert len(a) == len(b), f"{what}: {len(a)} values, and {len(b)} meant"
    for i, (x, y) in enumerate(zip(a, b)):
        assert math.isclose(x, y, rel_tol=tolerance, abs_tol=tolerance), f"{what}[{i}]: {x}, and {y} meant"


def curve(rope, rho):
    """Point of a rope's B-spline at `rho`, by de Boor's algorithm, or of its Bezier curve, which
    has no inner knots."""
    degree, points = rope["degree"], rope["control_points"]
    knots = [0.0] * (degree + 1) + rope.get("knots", []) + [1.0] * (degree + 1)
    assert len(knots) == len(points) + degree + 1
    span = max(i for i in range(degree, len(points)) if knots[i] <= rho or i == degree)
    near_points = [points[span - degree + j] for j in range(degree + 1)]
    for level in range(1, degree + 1):
        for j in range(degree, level - 1, -1):
            left, right = knots[span - degree + j], knots[span + 1 + j - level]
            share = (rho - left) / (right - left)
            near_points[j] = [(1 - share) * a + share * b for a, b in zip(near_points[j - 1], near_points[j])]
    return near_points[degree]


def direction(rope, end):
    points = rope["control_points"]
    a, b = (points[0], points[1]) if end == 0 else (points[-2], points[-1])
    return math.atan2(b[1] - a[1], b[0] - a[0])


def is_pose(pose, at, yaw, what):
    near([pose.position.x, pose.position.y, pose.position.z], [*at, 0.0], what)
    turned = pose.orientation
    near([turned.x, turned.y, turned.z, turned.w], [0, 0, math.sin(yaw / 2), math.cos(yaw / 2)], what)


def steered_by(meant):
    return [rope for rope in meant["curves"] if rope["status"] in ("ok", "partial") and rope["fit"] != "coarse"]


def points(message, meant):
    assert message.header.frame_id == RIG
    assert [(f.name, f.offset, f.datatype) for f in message.fields] == FIELDS
    assert all(field.count == 1 for field in message.fields)
    assert (message.height, message.point_step, message.is_bigendian, message.is_dense) == (1, POINT.size, False, True)
    assert message.row_step == message.width * POINT.size == len(message.data)
    rows = list(POINT.iter_unpack(bytes(message.data)))
    wanted = []
    for rope in meant["curves"]:
        if rope["status"] == "lost":
            continue
        line = rope["centerline"]
        steps = len(line["points"]) - (not rope["closed"])
        for i, ((x, y), width) in enumerate(zip(line["points"], line["widths"])):
            wanted.append((x, y, 0, rope["track"], i / steps, width, i in line["hidden"], STATUS[rope["status"]]))
    assert len(rows) == len(wanted) > 0
    for i, (row, want) in enumerate(zip(rows, wanted)):
        near(row, want, f"point {i}")


def endpoints(message, meant):
    assert message.header.frame_id == RIG
    ropes = [rope for rope in steered_by(meant) if not rope["closed"]]
    assert len(message.poses) == 2 * len(ropes)
    for place, rope in enumerate(ropes):
        for end in (0, 1):
            is_pose(message.poses[2 * place + end], rope["control_points"][-end], direction(rope, end), f"end {end}")


def path(message, meant):
    [rope] = [rope for rope in steered_by(meant) if rope["track"] == 0]
    assert len(message.poses) == 64
    for i, pose in enumerate(message.poses):
        assert pose.header == message.header and pose.header.frame_id == RIG
        at = pose.pose.position
        near([at.x, at.y, at.z], [*curve(rope, i / 63), 0.0], f"pose {i}")
    for end in (0, 1):
        is_pose(message.poses[-end].pose, rope["control_points"][-end], direction(rope, end), f"end {end}")


def picture(message, meant):
    assert message.header.frame_id == f"{RIG}_camera"
    size = (meant["height"], meant["width"])
    if isinstance(message, CameraInfo):
        assert (message.height, message.width) == size and not any(message.k) and not message.distortion_model
        return
    data = bytes(message.data)
    assert "jpeg" in message.format and data[:2] == b"\xff\xd8" and data[-2:] == b"\xff\xd9", message.format
    at = 2
    while data[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    assert struct.unpack(">HH", data[at + 5 : at + 9]) == size


def ellipse(xx, xy, yy):
    middle, half = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    return math.sqrt(middle + half), math.sqrt(max(middle - half, 0)), math.atan2(2 * xy, xx - yy) / 2


def markers(message, meant):
    first, *others = message.markers
    assert (first.action, first.ns) == (3, "")
    assert all(m.header == first.header and m.action == 0 and not m.frame_locked for m in others)
    assert all((m.texture_resource, m.text, m.mesh_resource, m.mesh_file.filename) == ("", "", "", "") for m in message.markers)
    assert all(len(m.colors) == len(m.uv_coordinates) == len(m.mesh_file.data) == len(m.texture.data) == 0 for m in others)
    drawn = iter(m for m in others if m.ns not in ("crossings", "over", "under"))
    for rope in steered_by(meant):
        line, control = next(drawn), next(drawn)
        assert (line.ns, line.id, line.type, len(line.points)) == ("curve", rope["track"], 4, 96)
        for i, at in enumerate(line.points):
            near([at.x, at.y, at.z], [*curve(rope, i / 95), 0.0], f"curve {i}")
        near([line.scale.x, line.color.a, line.pose.orientation.w], [0.3 * rope["width"], 1, 1], "curve")
        assert (control.ns, control.id, control.type) == ("control_points", rope["track"], 7)
        near([c for p in control.points for c in (p.x, p.y)], [c for p in rope["control_points"] for c in p], "control points")
        for i, (at, covariance) in enumerate(zip(rope["control_points"], rope["covariances"])):
            marker = next(drawn)
            long, short, yaw = ellipse(*covariance)
            assert (marker.ns, marker.id, marker.type) == ("covariance", 32 * rope["track"] + i, 3)
            is_pose(marker.pose, at, yaw, f"ellipse {i}")
            near([marker.scale.x, marker.scale.y], [2 * DEVIATIONS * long, 2 * DEVIATIONS * short], f"ellipse {i}")
    assert next(drawn, None) is None, "more was drawn than there is"


def descriptors(message, meant):
    """Compares every field in the JSON, including those that JSON shows as words."""
    for name, value in meant["trace"].items():
        assert getattr(message.trace, name) == value, name
    assert (message.width, message.height, message.unit) == (meant["width"], meant["height"], 1)
    assert len(message.curves) == len(message.centerlines) == len(meant["curves"])
    for rope, line, want in zip(message.curves, message.centerlines, meant["curves"]):
        said = dict(want, status=STATUS[want["status"]], basis=BASIS[want["basis"]], fit=FIT[want["fit"]])
        said["border"] = sum(bit << end for end, bit in enumerate(want["border"]))
        for name, value in said.items():
            if isinstance(value, (bool, int, float)):
                near([getattr(rope, name)], [value], name)
        pairs = [c for p in rope.control_points for c in (p.x, p.y)]
        near(pairs, [c for p in want["control_points"] for c in p], "control points")
        near(rope.weights, want["weights"], "weights")
        near([c for v in rope.covariances for c in (v.xx, v.xy, v.yy)], [c for v in want["covariances"] for c in v], "covariances")
        near([c for v in rope.velocities for c in (v.x, v.y)], [c for v in want["velocities"] for c in v], "velocities")
        near(rope.knots, want.get("knots", []), "knots")
        near([c for p in line.points for c in (p.x, p.y)], [c for p in want["centerline"]["points"] for c in p], "points")
        near(line.widths, want["centerline"]["widths"], "widths")
        assert line.closed == want["closed"] and len(line.hidden) == len(line.points)
        assert [i for i, hidden in enumerate(line.hidden) if hidden] == want["centerline"]["hidden"]


def dds_type(name):
    """A type for Cyclone DDS, made from the `.msg` file."""
    from cyclonedds.idl import IdlStruct, types

    if name in dds_type.made:
        return dds_type.made[name]
    fields = {}
    for line in (SCHEMAS / f"{name}.msg").read_text().splitlines():
        found = re.match(r"(?:(\w+)/)?(\w+)(\[(?:<=(\d+))?\])?\s+(\w+)\s*(#.*)?$", line)
        if not found or "=" in line.split("#")[0].replace("<=", ""):
            continue
        package, kind, is_list, bound, field, _ = found.groups()
        kind = dds_type(kind) if package else bool if kind == "bool" else getattr(types, kind)
        if is_list:
            kind = types.sequence[kind, int(bound)] if bound else types.sequence[kind]
        fields[field] = kind
    typename = f"lariat_msgs.msg.dds_.{name}_"
    fill = lambda space: space.update(__annotations__=fields, __module__=__name__)
    dds_type.made[name] = dataclass(new_class(f"{name}_", (IdlStruct,), {"typename": typename}, fill))
    return dds_type.made[name]


dds_type.made = {}


class Cyclone:
    """A reader of a rig's topic, such as `Descriptors`."""

    def __init__(self, rig, kind):
        from cyclonedds.core import Policy, Qos
        from cyclonedds.domain import DomainParticipant
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        qos = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(64), Policy.DataRepresentation(use_cdrv0_representation=True))
        self.participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
        topic = Topic(self.participant, f"rt/lariat/{rig}/{kind.lower()}", dds_type(kind), qos=qos)
        self.reader = DataReader(self.participant, topic, qos=qos)

    def take(self):
        return self.reader.take(64)


def stamp_ns(message):
    stamp = message.markers[0].header.stamp if isinstance(message, MarkerArray) else message.header.stamp
    return stamp.sec * 10**9 + stamp.nanosec


def main():
    wanted = int(sys.argv[2])
    echo = subprocess.Popen([os.environ.get("LARIAT", "lariat"), "topic", "echo", "descriptors", "--rig", RIG, "--json"], stdout=subprocess.PIPE, text=True)
    said = []
    threading.Thread(target=lambda: said.extend(map(json.loads, echo.stdout)), daemon=True).start()
    rclpy.init()
    node = rclpy.create_node("peer")
    # On a loaded machine, rclpy is late by seconds, because it makes an object of each marker.
    qos = QoSProfile(depth=500, reliability=ReliabilityPolicy.RELIABLE)
    received, first = {}, []
    topics = {"points": (PointCloud2, points), "endpoints": (PoseArray, endpoints), "path/rope_0": (Path, path), "markers": (MarkerArray, markers)}
    for name, (kind, _) in topics.items():
        received[name] = []
        first.append(node.create_subscription(kind, f"/lariat/{RIG}/{name}", lambda m, name=name: received[name].append((time.monotonic_ns(), m)), qos))
    health = []
    node.create_subscription(DiagnosticArray, f"/lariat/{RIG}/diagnostics", health.append, qos)
    cyclone, dds = Cyclone(RIG, "Descriptors"), []
    until = time.monotonic() + 30 + wanted / 10
    while time.monotonic() < until and (min(len(dds), *map(len, received.values())) < wanted or not health):
        rclpy.spin_once(node, timeout_sec=0.02)
        dds += cyclone.take()
    counts = {name: len(messages) for name, messages in received.items()}
    counts |= {"descriptors": len(dds), "diagnostics": len(health)}
    for subscription in first:
        node.destroy_subscription(subscription)
    pictures = {}
    kinds = {"image/compressed": CompressedImage, "overlay/compressed": CompressedImage, "camera_info": CameraInfo}
    for name, kind in kinds.items():
        pictures[name] = []
        node.create_subscription(kind, f"/lariat/{RIG}/{name}", pictures[name].append, qos)
    until = time.monotonic() + 30
    while time.monotonic() < until and min(map(len, pictures.values())) < PICTURES:
        rclpy.spin_once(node, timeout_sec=0.02)
    time.sleep(0.5)
    echo.terminate()
    echo.wait()
    print(f"{len(said)} frames were said by echo; received: {counts}")
    assert min(counts[name] for name in counts if name != "diagnostics") >= wanted and health, "too few came"

    offset = time.time_ns() - time.monotonic_ns()
    frames = {meant["trace"]["sequence"]: meant for meant in said}
    exposed = {meant["trace"]["exposed_ns"]: sequence for sequence, meant in frames.items()}

    def sequence_of(message):
        """Finds the frame exposed at that time: clocks may have been adjusted slightly since."""
        then = stamp_ns(message) - offset
        known = min(exposed, key=lambda ns: abs(ns - then))
        return exposed[known] if abs(known - then) < 2_000_000 else None

    for name, (_, compare) in topics.items():
        came, ages = {}, []
        for at, message in received[name]:
            if (sequence := sequence_of(message)) is not None:
                came[sequence] = message
                ages.append((at - frames[sequence]["trace"]["fitted_ns"]) / 1e6)
        compare_all(name, came, compare, frames, ages)
    came = {message.trace.sequence: message for message in dds if message.trace.sequence in frames}
    compare_all("descriptors", came, descriptors, frames, [])
    for name, messages in pictures.items():
        assert len(messages) >= PICTURES, f"{name}: {len(messages)} came"
        known = [(m, frames[sequence]) for m in messages if (sequence := sequence_of(m)) is not None]
        assert known, f"{name}: none is of a frame that echo said"
        for message, meant in known:
            picture(message, meant)
        print(f"{name}: {len(messages)} received, {len(known)} compared")
    [status] = health[-1].status
    assert status.hardware_id == RIG and status.level in (b"\x00", b"\x01"), status
    values = {pair.key: pair.value for pair in status.values}
    assert int(values["messages not sent"]) == 0 and int(values["frames received"]) > 0, values
    print(f"diagnostics: {status.message}; {values}")
    node.destroy_node()
    rclpy.shutdown()


def compare_all(name, came, compare, frames, ages):
    assert came, f"{name}: nothing of a frame that echo said"
    for sequence, message in came.items():
        try:
            compare(message, frames[sequence])
        except AssertionError as error:
            raise AssertionError(f"{name}, frame {sequence}: {error}") from error
    first, last = min(came), max(came)
    # A rope that a control loop should not use has no path.
    due = [sequence for sequence, meant in frames.items() if compare is not path or steered_by(meant)]
    missing = [sequence for sequence in due if first < sequence < last and sequence not in came]
    ages.sort()
    age = f", fitted to callback p50 {ages[len(ages) // 2]:.2f} ms" if ages else ""
    print(f"{name}: {len(came)} compared, {len(missing)} missing between the first and the last{age}")
    assert not missing, f"{name}: frames {missing[:10]} are missing"


if __name__ == "__main__":
    RIG = sys.argv[1]
    main()
