#!/usr/bin/env python3
"""Reads a recording with the standard Python packages: decodes every topic with them, and checks
that the contents are consistent.

    read.py FILE.mcap [FRAMES]

Checks that every message decodes by the schema in the file, that each topic has the right number of
messages, and that times can be restored exactly. Each frame's centerline must lie on its truth
and its curve on its centerline, and the image must show the rope where the centerline is. With
depth, the 3-D curve must lie on its points, and every ellipsoid must have a volume. FRAMES:
expected number of frames. Needs requirements.txt. Only for recordings of a rendered rope.
"""

import collections
import io
import math
import sys

import numpy
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from PIL import Image

BEZIER = 1
B_SPLINE = 2
KNOWN = 1


def check(holds, what):
    if not holds:
        sys.exit(f"read.py: {what}")


def read(path):
    """All decoded messages by topic, the metadata, and the names of the attachments."""
    topics = collections.defaultdict(list)
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        summary = reader.get_summary()
        check(summary is not None, "the file has no index")
        for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            topics[channel.topic].append((message, decoded))
        counts = summary.statistics.channel_message_counts
        for id, channel in summary.channels.items():
            check(counts[id] == len(topics[channel.topic]), f"{channel.topic} has another count than the index says")
        about = {}
        for metadata in reader.iter_metadata():
            about |= metadata.metadata
        attachments = {attachment.name: attachment.data for attachment in reader.iter_attachments()}
    return topics, about, attachments


def points(of):
    return numpy.array([[p.x, p.y] for p in of], float).reshape(-1, 2)


def bezier(control, count):
    """Points of a Bezier curve at equal parameter steps."""
    n = len(control) - 1
    t = numpy.linspace(0, 1, count)[:, None]
    k = numpy.arange(n + 1)
    binomials = numpy.array([math.comb(n, i) for i in k], float)
    return (binomials * t**k * (1 - t) ** (n - k)) @ control


def spline(control, degree, inner, count):
    """Points of a clamped B-spline at equal parameter steps (de Boor's algorithm)."""
    knots = numpy.concatenate([numpy.zeros(degree + 1), inner, numpy.ones(degree + 1)])
    points = []
    for t in numpy.linspace(0, 1, count):
        k = min(numpy.searchsorted(knots, t, "right") - 1, len(control) - 1)
        at = [control[k - degree + j] for j in range(degree + 1)]
        for level in range(1, degree + 1):
            for j in range(degree, level - 1, -1):
                low, high = knots[k - degree + j], knots[k + 1 + j - level]
                at[j] = at[j - 1] + (t - low) / (high - low) * (at[j] - at[j - 1])
        points.append(at[degree])
    return numpy.array(points)


def along(shape, control, count):
    """Points of an open rope's curve at equal parameter steps."""
    check(shape.basis in (BEZIER, B_SPLINE), f"the curve's basis is {shape.basis}")
    return bezier(control, count) if shape.basis == BEZIER else spline(control, shape.degree, shape.knots, count)


def distances(points, line):
    """Distance of each point from a polyline of many short segments."""
    a, b = line[:-1], line[1:]
    way = b - a
    t = ((points[:, None] - a) * way).sum(2) / numpy.maximum((way**2).sum(1), 1e-12)
    nearest = a + numpy.clip(t, 0, 1)[..., None] * way
    return numpy.linalg.norm(points[:, None] - nearest, axis=2).min(1)


def pixels(message):
    """The picture of an image message as RGB."""
    if hasattr(message, "format"):
        return numpy.asarray(Image.open(io.BytesIO(bytes(message.data))).convert("RGB"), float)
    check(message.encoding == "rgb8", f"an image of a rendered rope is rgb8, not {message.encoding}")
    rows = numpy.frombuffer(bytes(message.data), numpy.uint8)
    return rows.reshape(message.height, message.step)[:, : 3 * message.width].reshape(message.height, message.width, 3) + 0.0


def check_times(topics, rig, about):
    offset = int(about["monotonic_to_wall_ns"])
    stamps = {"frames": "captured_ns", "truth": "captured_ns", "centerlines": "extracted_ns", "descriptors": "fitted_ns"}
    for topic, stamp in stamps.items():
        for message, decoded in topics[f"/{rig}/{topic}"]:
            check(message.log_time == getattr(decoded.trace, stamp) + offset, f"a log time of {topic} is another")
            check(message.sequence == decoded.trace.sequence & 0xFFFFFFFF, f"a sequence of {topic} is another")
    for message, image in topics[f"/{rig}/image"]:
        stamp = image.header.stamp
        check(stamp.sec * 10**9 + stamp.nanosec <= message.log_time, "an image was captured before it was taken")


def check_geometry(topics, rig):
    """Compares each frame's truth, centerline, curve and image."""
    by = lambda topic: {d.trace.sequence: d for _, d in topics[f"/{rig}/{topic}"]}
    truths, seen, shapes = by("truth"), by("centerlines"), by("descriptors")
    images = {m.sequence: d for m, d in topics[f"/{rig}/image"]}
    worst = 0.0
    for sequence, centerlines in seen.items():
        check(len(centerlines.curves) == 1, f"frame {sequence} shows {len(centerlines.curves)} ropes")
        curve = points(centerlines.curves[0].points)
        truth = points(truths[sequence].curves[0].points)
        off = distances(curve, truth).mean()
        worst = max(worst, off)
        check(off < 1.0, f"the centerline of frame {sequence} is {off:.2f} px off its truth")
        if sequence in shapes:
            shape = shapes[sequence].curves[0]
            on = along(shape, points(shape.control_points), shape.samples)
            rms = numpy.sqrt(((on - curve) ** 2).sum(1).mean())
            check(abs(rms - shape.rms) < 1e-3, f"the curve of frame {sequence} is {rms:.4f} px from its points, said {shape.rms:.4f}")
        if sequence in images:
            picture = pixels(images[sequence])
            table = numpy.median(picture.reshape(-1, 3), axis=0)
            x, y = numpy.rint(curve[5:-5]).astype(int).T
            rope = numpy.abs(picture[y, x] - table).max(1)
            check((rope > 25).mean() > 0.98, f"the rope of frame {sequence} is not where its centerline says")
    return worst


def check_space(topics, rig):
    """Checks each frame's depth image, and the consistency of its 3-D rope."""
    depths = {m.sequence: d for m, d in topics[f"/{rig}/depth_image"]}
    known = 0
    for message, ropes in topics[f"/{rig}/descriptors3"]:
        sequence = ropes.trace.sequence
        check(sequence & 0xFFFFFFFF in depths, f"frame {sequence} is in space without a depth image")
        depth = depths[sequence & 0xFFFFFFFF]
        check(depth.encoding == "mono16" and depth.step == 2 * depth.width, f"a depth image is {depth.encoding}")
        units = numpy.frombuffer(bytes(depth.data), "<u2")
        check(len(units) == depth.width * depth.height, "a depth image has another size than it says")
        check((units > 0).mean() > 0.5, "a depth image is mostly empty")
        for rope in ropes.curves:
            if rope.place != KNOWN:
                continue
            known += 1
            triple = lambda of: numpy.array([[p.x, p.y, p.z] for p in of], float)
            line, control = triple(rope.points), triple(rope.control_points)
            on = along(rope, control, len(line))
            rms = numpy.sqrt(((on - line) ** 2).sum(1).mean())
            check(abs(rms - rope.rms) < 1e-3, f"the curve of frame {sequence} is {rms:.4f} mm from its points, said {rope.rms:.4f}")
            steps = numpy.linalg.norm(numpy.diff(line, axis=0), axis=1)
            check(abs(steps.sum() - rope.length) < 0.02 * rope.length, "a rope in space is not as long as it says")
            for c in rope.covariances:
                square = numpy.array([[c.xx, c.xy, c.xz], [c.xy, c.yy, c.yz], [c.xz, c.yz, c.zz]])
                check(numpy.linalg.eigvalsh(square)[0] > 0, f"an ellipsoid of frame {sequence} has no volume")
            check(min(rope.sigmas) > 0, f"a point of frame {sequence} is sure of its depth")
    check(known > 0, "no rope is known in space")
    return known


def check_annotations(topics, rig):
    """Checks that the drawing over the image is the centerline, measured from the pixel's
    corner."""
    seen = {m.log_time: d for m, d in topics[f"/{rig}/centerlines"]}
    for message, drawn in topics[f"/{rig}/annotations/ropes"]:
        for line, curve in zip(drawn.points, seen[message.log_time].curves, strict=True):
            off = numpy.abs(points(line.points) - 0.5 - points(curve.points)).max()
            check(off < 1e-3, "an annotation is not where the rope is")


def main():
    path = sys.argv[1]
    topics, about, attachments = read(path)
    rig = about["rig"]
    count = {topic.removeprefix(f"/{rig}/"): len(messages) for topic, messages in topics.items()}
    frames = int(sys.argv[2]) if len(sys.argv) > 2 else count["frames"]
    check(count["frames"] == frames, f"there are {count['frames']} frames, not {frames}")
    wanted = ["truth", "centerlines", "descriptors", "annotations/ropes", "annotations/control_points"]
    wanted += ["image"] if about["images"] != "none" else []
    # A recording on a full disk ends without its last count.
    losses = topics[f"/{rig}/losses"][-1][1] if f"/{rig}/losses" in topics else None
    dropped = {"truth": losses.dropped_truth, "image": losses.dropped_frames} if losses else {}
    if losses and losses.capture + losses.extract + losses.fit + losses.dropped_centerlines + losses.dropped_descriptors == 0:
        for topic in wanted:
            there = count.get(topic, 0) + dropped.get(topic, 0)
            check(there == frames, f"{topic} has {there} messages for {frames} frames")
    check("lariat.toml" in attachments, "the settings are not attached")
    check_times(topics, rig, about)
    check_annotations(topics, rig)
    if f"/{rig}/descriptors3" in topics:
        known = check_space(topics, rig)
        print(f"{path}: {frames} frames, {count['depth_image']} depth images, {known} ropes in space")
        return
    worst = check_geometry(topics, rig)
    print(f"{path}: {frames} frames, {sum(count.values())} messages on {len(count)} topics; the centerlines are at most {worst:.2f} px off in the mean")


if __name__ == "__main__":
    main()
