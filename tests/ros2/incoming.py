#!/usr/bin/env python3
"""Input of `lariat ros2` from other nodes of a ROS 2 graph: rclpy's images, masks, gripper
velocities and calibrations, and the results that return over ROS.

Each part has a separate chain and bridge. No time is asserted. Latencies are printed next to those
of a bare rclpy node that answers images of the same size with points of the same size. Usage:
incoming.py IMAGES (tests/ros2/run starts it; LARIAT and LARIAT_ROS2 name the programs).
"""

import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from array import array
from pathlib import Path

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2

LARIAT = os.environ.get("LARIAT", "lariat")
BRIDGE = os.environ.get("LARIAT_ROS2", "lariat-ros2")
WIDTH, HEIGHT, FPS = 640, 480, 30
SENSOR = QoSProfile(depth=8, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=8, reliability=ReliabilityPolicy.RELIABLE)
Y, X = np.mgrid[0:HEIGHT, 0:WIDTH]


def rope(phase):
    """Pixels of a swinging rope."""
    return (abs(Y - (240 + 80 * np.sin(X / 90 + phase))) < 7) & (X > 80) & (X < 560)


def picture(phase):
    """A picture of the rope, dark red on light gray."""
    image = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    image[rope(phase)] = (160, 40, 30)
    return image


def yuv(rgb):
    r, g, b = (rgb[..., i].astype(float) for i in range(3))
    y = 0.299 * r + 0.587 * g + 0.114 * b
    return [np.clip(c, 0, 255).astype(np.uint8) for c in (y, 128 + 0.564 * (b - y), 128 + 0.713 * (r - y))]


def packed(rgb, order):
    y, u, v = yuv(rgb)
    parts = {"y0": y[:, ::2], "y1": y[:, 1::2], "u": u[:, ::2], "v": v[:, ::2]}
    return np.stack([parts[name] for name in order], axis=-1).reshape(HEIGHT, -1)


def bayer(rgb, pattern):
    mosaic = np.empty((HEIGHT, WIDTH), np.uint8)
    for place, color in enumerate(pattern):
        mosaic[place // 2 :: 2, place % 2 :: 2] = rgb[place // 2 :: 2, place % 2 :: 2, "rgb".index(color)]
    return mosaic


def opaque(image):
    return np.concatenate([image, np.full((HEIGHT, WIDTH, 1), 255, np.uint8)], axis=-1)


ENCODINGS = {
    "rgb8": lambda rgb: rgb,
    "bgr8": lambda rgb: rgb[..., ::-1],
    "rgba8": opaque,
    "bgra8": lambda rgb: opaque(rgb[..., ::-1]),
    "mono8": lambda rgb: yuv(rgb)[0],
    "yuv422_yuy2": lambda rgb: packed(rgb, ["y0", "u", "y1", "v"]),
    "uyvy": lambda rgb: packed(rgb, ["u", "y0", "v", "y1"]),
    "nv12": lambda rgb: np.concatenate([yuv(rgb)[0], np.stack([c[::2, ::2] for c in yuv(rgb)[1:]], axis=-1).reshape(HEIGHT // 2, -1)]),
    "bayer_rggb8": lambda rgb: bayer(rgb, "rggb"),
    "bayer_bggr8": lambda rgb: bayer(rgb, "bggr"),
    "bayer_grbg8": lambda rgb: bayer(rgb, "grbg"),
    "bayer_gbrg8": lambda rgb: bayer(rgb, "gbrg"),
}


def png(pixels):
    """A PNG of these pixels, in color or gray, of 8 or 16 bits."""
    chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    color = 2 if pixels.ndim == 3 else 0
    rows = b"".join(b"\0" + row.astype(row.dtype.newbyteorder(">")).tobytes() for row in pixels)
    head = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8 * pixels.itemsize, color, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")


def stamped(message, stamp_ns=None):
    stamp_ns = time.time_ns() if stamp_ns is None else stamp_ns
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    message.header.frame_id = "camera"
    return message


def stamp_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def image(pixels, encoding="rgb8", stamp_ns=None, **lies):
    """An image of these pixels; `lies` are false values for its fields."""
    message = Image(width=WIDTH, height=HEIGHT, encoding=encoding, step=pixels[0].size)
    message.data = array("B", np.ascontiguousarray(pixels).tobytes())
    for name, value in lies.items():
        setattr(message, name, value)
    return stamped(message, stamp_ns)


def file(pixels, stamp_ns=None):
    message = CompressedImage(format="png")
    message.data = array("B", png(pixels))
    return stamped(message, stamp_ns)


def xy(cloud):
    """Positions of the points of a visible rope."""
    rows = np.frombuffer(bytes(cloud.data), np.uint8).reshape(-1, cloud.point_step)
    return rows[:, :8].copy().view(np.float32)


def apart(points, others):
    """Mean distance of the points from the nearest of the others: ends differ by a few pixels,
    because colors are blurred."""
    return np.mean([np.linalg.norm(others - point, axis=1).min() for point in points])


class Rig:
    """A chain, a bridge, and a node that receives their messages."""

    names = 0

    def __init__(self, chain, bridge):
        Rig.names += 1
        self.name = f"ros2in_{os.getpid()}_{Rig.names}"
        self.log = tempfile.TemporaryFile("w+")
        run = [LARIAT, "--quiet", "run", "--rig", self.name, *chain]
        self.chain = subprocess.Popen(run, stdout=subprocess.DEVNULL)
        self.bridge = subprocess.Popen([BRIDGE, "--rig", self.name, *bridge], stderr=self.log)
        self.node = rclpy.create_node(f"peer_{Rig.names}")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.points, self.health = {}, []
        self.hears(PointCloud2, "points", lambda cloud: self.points.update({stamp_of(cloud): (time.monotonic_ns(), cloud)}))
        self.hears(DiagnosticArray, "diagnostics", lambda said: self.health.append({p.key: p.value for p in said.status[0].values}))

    def hears(self, kind, name, callback):
        self.node.create_subscription(kind, f"/lariat/{self.name}/{name}", callback, SENSOR)

    def publisher(self, kind, name, qos=SENSOR):
        publisher = self.node.create_publisher(kind, name, qos)
        self.until(lambda: publisher.get_subscription_count() > 0, f"a listener to {name}")
        # The other side may discover it a moment later.
        self.spin(0.5)
        return publisher

    def spin(self, seconds):
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            self.executor.spin_once(timeout_sec=left)

    def until(self, condition, what, seconds=30):
        until = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < until, f"{what} did not come; the bridge said:\n{self.said()}"
            assert self.bridge.poll() is None and self.chain.poll() is None, f"a program has ended; the bridge said:\n{self.said()}"
            self.executor.spin_once(timeout_sec=0.05)

    def said(self):
        self.log.seek(0)
        return self.log.read()

    def values(self):
        """Diagnostics, after a short wait."""
        self.spin(0.5)
        seen = len(self.health)
        self.until(lambda: len(self.health) > seen + 1, "diagnostics")
        return self.health[-1]

    def count(self, what, how):
        [value] = [value for key, value in self.health[-1].items() if key.startswith(what) and key.endswith(how)]
        return int(value)

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        self.node.destroy_node()
        codes = []
        for process in (self.bridge, self.chain):
            process.send_signal(signal.SIGINT)
            codes.append(process.wait(timeout=30))
        assert kind or codes == [0, 0], f"exit codes {codes}; the bridge said:\n{self.said()}"


def images(count):
    """Images of each kind become frames with their original stamp. Invalid ones are counted and
    reported; all are accounted for."""
    with Rig(["--source", "external"], ["--image", "/camera/image_raw"]) as rig:
        publisher = rig.publisher(Image, "/camera/image_raw")
        published = 0

        def publish(message):
            nonlocal published
            publisher.publish(message)
            published += 1
            rig.spin(1 / FPS)
            return stamp_of(message)

        # The chain is up when the first points arrive.
        while not rig.points:
            publish(image(picture(0)))
            assert published < 1000, rig.said()
        reference = xy(list(rig.points.values())[-1][1])
        for encoding, made in ENCODINGS.items():
            stamps = [publish(image(made(picture(0)), encoding)) for _ in range(10)]
            rig.spin(0.3)
            came = [stamp for stamp in stamps if stamp in rig.points]
            assert came, f"{encoding}: no points with an image's own stamp"
            far = apart(xy(rig.points[came[-1]][1]), reference)
            assert far < 2, f"{encoding}: points are {far:.2f} px from those of rgb8"
        print(f"images: {', '.join(ENCODINGS)} are the same rope")

        plain = picture(0)
        refused = [
            image(plain, step=WIDTH),
            image(plain, encoding="rgb32"),
                image(plain, height=HEIGHT + 1),
            image(plain, width=0, height=0),
            image(plain, width=2**32 - 1, step=2**32 - 1),
            image(plain, stamp_ns=time.time_ns() - 60 * 10**9),
            image(plain, stamp_ns=5 * 10**9),
        ]
        for message in refused:
            publish(message)
        ahead = publish(image(plain, stamp_ns=time.time_ns() + 3600 * 10**9))
        unstamped = publish(image(plain, stamp_ns=0))
        assert unstamped == 0
        # Another publisher counts from 1 again, which is not a gap.
        rig.node.destroy_publisher(publisher)
        publisher = rig.publisher(Image, "/camera/image_raw")
        stamps = [publish(image(picture(0.05 * i))) for i in range(count)]
        values = rig.values()
        taken, lost, no = (rig.count("images", how) for how in ("taken", "lost on the way", "refused"))
        assert (taken + lost + no, no) == (published, len(refused)), f"{published} published: {taken} taken, {lost} lost, {no} refused"
        assert rig.count("images", "another stamp") == 2, values
        assert ahead in rig.points, "an image from the future keeps its stamp on the way back"
        received = int(values["frames received"])
        gone = {key: int(value) for key, value in values.items() if key.startswith("lost a")}
        # Frames that were read before anybody subscribed to the points are not counted.
        assert gone["lost at the source"] == lost + no, (gone, lost, no)
        print(f"images: {published} published = {taken} taken + {lost} lost on the way + {no} refused; {received} received back, {gone}")
        said = rig.said()
        for word in ("step", '"rgb32"', "ahead of this machine's clock", "--stamp-on-arrival", "no stamp"):
            assert word in said, f"{word} was not said: {said}"
        assert len(said.splitlines()) < 15, f"it is said once: {said}"
        assert len([stamp for stamp in stamps if stamp in rig.points]) + lost + sum(gone.values()) >= count


def files():
    """Compressed images are read, and invalid ones are counted."""
    with Rig(["--source", "external"], ["--image", "/camera/image_raw/compressed", "--reliable-images"]) as rig:
        publisher = rig.publisher(CompressedImage, "/camera/image_raw/compressed", RELIABLE)
        broken = file(picture(0))
        broken.data = broken.data[: len(broken.data) // 2]
        messages = [file(picture(0)) for _ in range(3 * FPS)] + [broken, file(yuv(picture(0))[0])]
        for message in messages:
            publisher.publish(stamped(message))
            rig.spin(1 / FPS)
        rig.until(lambda: rig.points, "points of compressed images")
        rig.values()
        counts = [rig.count("images", how) for how in ("taken", "lost on the way", "refused")]
        assert counts == [len(messages) - 1, 0, 1], counts
        assert "cannot be read" in rig.said(), rig.said()
        print(f"compressed images: {len(messages)} published, taken, lost and refused: {counts}")


def jpegs():
    """The JPEG pictures of one rig are the frames of another: the same rope with the same
    stamps."""
    with Rig(["--source", "rendered", "--fps", "10"], []) as one:
        with Rig(["--source", "external"], ["--image", f"/lariat/{one.name}/image/compressed"]) as other:
            both = lambda: one.spin(0.05) or [stamp for stamp in other.points if stamp in one.points]
            other.until(lambda: len(both()) > 20, "points of JPEGs")
            far = max(apart(xy(one.points[stamp][1]), xy(other.points[stamp][1])) for stamp in both())
            assert far < 2, f"points are {far:.2f} px from those of the picture itself"
            other.values()
            assert other.count("images", "refused") == 0, other.said()
            print(f"JPEGs: {len(both())} of a rig's pictures are another's frames, their points at most {far:.2f} px off")


def masks():
    """Masks are matched to images by stamp, whichever comes first; the images here show nothing."""
    settings = tempfile.NamedTemporaryFile("w", suffix=".toml")
    settings.write('[extract]\nmask = "external"\nmask_deadline_us = 200000\n')
    settings.flush()
    with Rig(["--source", "external", "--config", settings.name], ["--image", "/camera/image_raw", "--mask", "/segmentation/mask"]) as rig:
        pictures = rig.publisher(Image, "/camera/image_raw")
        masks = rig.publisher(Image, "/segmentation/mask")
        gray = np.full((HEIGHT, WIDTH), 200, np.uint8)
        stamps = []
        for i in range(4 * FPS):
            mask = image(np.where(rope(0.05 * i), 255, 0).astype(np.uint8), "mono8")
            stamps.append(stamp_of(mask))
            pair = [(pictures, image(gray, "mono8", stamps[-1])), (masks, mask)]
            for publisher, message in pair if i % 2 else reversed(pair):
                publisher.publish(message)
            rig.spin(1 / FPS)
        came = {i: xy(rig.points[stamp][1]) for i, stamp in enumerate(stamps) if stamp in rig.points}
        for parity, order in ((0, "mask first"), (1, "image first")):
            assert sum(i % 2 == parity for i in came) > FPS, f"{order}: {len(came)} of {len(stamps)} came; {rig.said()}"
        for i, points in came.items():
            x, y = points[len(points) // 2]
            assert abs(y - (240 + 80 * np.sin(x / 90 + 0.05 * i))) < 3, f"image {i} has the mask of another"
        small = Image(width=8, height=8, encoding="mono8", step=8, data=array("B", bytes(64)))
        for message in (stamped(small, stamps[-1]), image(picture(0)), *(image(gray, "mono8") for _ in range(5))):
            masks.publish(message)
            rig.spin(1 / FPS)
        rig.values()
        refused = rig.count("masks", "refused")
        assert refused == 3, f"of another size, in color, and one of five without an image: {refused}; {rig.said()}"
        for word in ("8×8", "mono8, and not", "no image"):
            assert word in rig.said(), f"{word} was not said: {rig.said()}"
        print(f"masks: {len(came)} of {len(stamps)} images came back with their own mask")


def stopped():
    """A bridge that was stopped for a while (Ctrl-Z) continues when resumed, although its transport
    does not."""
    with Rig(["--source", "external"], ["--image", "/camera/image_raw"]) as rig:
        publisher = rig.publisher(Image, "/camera/image_raw")

        def come():
            publisher.publish(image(picture(0)))
            rig.spin(1 / FPS)
            return rig.points

        for _ in range(2):
            rig.points.clear()
            rig.until(come, "points")
            rig.bridge.send_signal(signal.SIGSTOP)
            rig.spin(0.5)
            rig.bridge.send_signal(signal.SIGCONT)
            # The messages in flight have been processed.
            rig.spin(1)
        rig.points.clear()
        rig.until(come, "points after a stop")
        print("stopped twice and let go on: images become points as before")


def truth(rig):
    """True positions of the simulated rope's ends."""
    echo = [LARIAT, "topic", "echo", "truth", "--once", "--json", "--rig", rig.name]
    message = json.loads(subprocess.run(echo, check=True, capture_output=True, text=True, timeout=30).stdout)
    points = message["curves"][0]["points"]
    return np.array([points[0], points[-1]], float)


def grippers():
    """Each gripper follows its own topic as long as commands arrive; old or invalid values move
    nothing."""
    with Rig(["--source", "simulated"], ["--gripper", "/left/cmd_vel", "--gripper", "/right/cmd_vel"]) as rig:
        topics = [rig.publisher(TwistStamped, f"/{side}/cmd_vel") for side in ("left", "right")]

        def tell(seconds, side, y, age_ns=0):
            until = time.monotonic() + seconds
            while time.monotonic() < until:
                twist = TwistStamped()
                twist.twist.linear.y = y
                topics[side].publish(stamped(twist, time.time_ns() - age_ns))
                rig.spin(0.02)

        start = truth(rig)
        tell(1.0, 0, 30.0)
        rig.spin(0.5)
        moved = truth(rig)
        assert 15 < (moved - start)[0][1] < 60 and abs((moved - start)[1]).max() < 2, (start, moved)
        tell(1.0, 1, -30.0)
        rig.spin(0.5)
        both = truth(rig)
        assert -60 < (both - moved)[1][1] < -15 and abs((both - moved)[0]).max() < 2, (moved, both)
        tell(0.5, 0, 30.0, age_ns=10**9)
        tell(0.5, 0, float("nan"))
        rig.spin(0.5)
        assert abs(truth(rig) - both).max() < 2, "what was old moved a gripper"
        for word in ("not a finite number", "stamped 1.0"):
            assert word in rig.said(), f"{word} was not said: {rig.said()}"
        print("velocities: each gripper goes by its own topic, and not by what is old or no number")


def calibration():
    """The camera's calibration becomes the chain's, and appears in the camera_info of the rig."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "camera.yaml"
        with Rig(["--source", "external"], ["--image", "/camera/image_raw", "--camera-info", "/camera/camera_info", "--calibration-out", str(path)]) as rig:
            said = []
            rig.hears(CameraInfo, "camera_info", said.append)
            pictures = rig.publisher(Image, "/camera/image_raw")
            infos = rig.publisher(CameraInfo, "/camera/camera_info")
            info = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", d=[-0.2, 0.05, 0.001, -0.002, 0.01])
            info.k = [600.5, 0.0, 320.25, 0.0, 601.5, 239.75, 0.0, 0.0, 1.0]
            info.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
            info.p = [600.5, 0.0, 320.25, 0.0, 0.0, 601.5, 239.75, 0.0, 0.0, 0.0, 1.0, 0.0]
            infos.publish(stamped(CameraInfo(width=WIDTH, height=HEIGHT)))

            def come():
                pictures.publish(image(picture(0)))
                infos.publish(stamped(info))
                rig.spin(1 / FPS)
                return said and any(said[-1].k)

            while not said:
                pictures.publish(image(picture(0)))
                rig.spin(1 / FPS)
            assert not any(said[0].k) and not path.exists(), "before there is a calibration K is 0"
            rig.until(come, "a camera_info with K")
            back = said[-1]
            for name in ("k", "d", "r", "p"):
                assert list(getattr(back, name)) == list(getattr(info, name)), (name, back)
            assert (back.width, back.height, back.distortion_model) == (WIDTH, HEIGHT, "plumb_bob")
            assert "camera_matrix" in path.read_text()
            assert "the chain goes by it now" in rig.said() and "not calibrated" in rig.said(), rig.said()
            info.k[0] = 700.0
            rig.until(lambda: come() and said[-1].k[0] == 700.0, "another calibration while it runs")
            print("camera_info: the calibration is the chain's, comes back number by number, and so does another one later")


def parameters():
    """The chain's settings are the node's parameters: the chain accepts or refuses changes, and
    changes made elsewhere become visible."""
    with Rig(["--source", "rendered"], []) as rig:
        client = AsyncParameterClient(rig.node, f"/lariat_{rig.name}")
        rig.until(client.services_are_ready, "parameter services")

        def answer(future):
            rig.until(future.done, "an answer")
            return future.result()

        def value(name):
            return parameter_value_to_python(answer(client.get_parameters([name])).values[0])

        def results(name, value):
            return answer(client.set_parameters([Parameter(name, value=value)])).results[0]

        rig.until(lambda: "fit.filter" in answer(client.list_parameters([], 0)).result.names, "the chain's settings")
        names = answer(client.list_parameters([], 0)).result.names
        assert len(answer(client.get_parameters(names)).values) == len(names) > 20
        assert value("extract.points") == 120 and value("fit.filter") is False, (value("extract.points"), value("fit.filter"))
        for name, wanted in (("fit.control_points", 7), ("fit.filter", True), ("fit.control_points", "auto"), ("fit.control_points", 7)):
            said = results(name, wanted)
            assert said.successful and value(name) == wanted, (name, wanted, said)
        echo = [LARIAT, "topic", "echo", "descriptors", "--once", "--json", "--rig", rig.name]
        degree = lambda: json.loads(subprocess.run(echo, check=True, capture_output=True, text=True, timeout=30).stdout)["curves"][0]["degree"]
        rig.until(lambda: degree() == 6, "curves with the control points that were set")
        for name, wrong, word in (("fit.control_points", 99, "32"), ("fit.degre", 6, "fit.degree"), ("run.hang_s", 3.0, "lariat set"), ("fit.control_points", "7\nfit.filter=false", "one line"), ("fit.control_points", None, "not deleted")):
            said = results(name, wrong)
            assert not said.successful and word in said.reason, (name, wrong, said)
            assert value("fit.control_points") == 7
        subprocess.run([LARIAT, "set", "--rig", rig.name, "extract.ropes=2"], check=True, capture_output=True, timeout=30)
        rig.until(lambda: value("extract.ropes") == 2, "what was set elsewhere")
        print("parameters: the chain takes what is set, refuses what is wrong with its own words, and what it is told elsewhere is seen")


def latency(count):
    """Latency from publish() to the callback with the points, and the same for a bare rclpy node
    that exchanges as many bytes."""
    arrays = [array("B", picture(0.05 * i).tobytes()) for i in range(FPS)]

    def measured(rig, received, name):
        publisher, ages = rig.publisher(Image, name), []
        message = image(picture(0))
        due, sent = time.monotonic(), {}
        for i in range(count + FPS):
            message.data = arrays[i % FPS]
            stamped(message)
            sent[stamp_of(message)] = time.monotonic_ns()
            publisher.publish(message)
            due += 1 / FPS
            while (left := due - time.monotonic()) > 0:
                rig.executor.spin_once(timeout_sec=left)
        rig.spin(0.5)
        # The first second is for warming up.
        stamps = list(sent)[FPS:]
        ages = sorted((received[stamp][0] - sent[stamp]) / 1e6 for stamp in stamps if stamp in received)
        assert ages, f"nothing came back over {name}"
        p50, p99 = ages[len(ages) // 2], ages[int(0.99 * (len(ages) - 1))]
        return f"p50 {p50:.2f} ms, p99 {p99:.2f} ms ({len(ages)} of {len(stamps)})"

    with Rig(["--source", "external"], ["--image", "/camera/image_raw"]) as rig:
        answered = {}
        rig.node.create_subscription(PointCloud2, "/bare/points", lambda cloud: answered.update({stamp_of(cloud): (time.monotonic_ns(), cloud)}), SENSOR)
        bare = subprocess.Popen([sys.executable, __file__, "bare"])
        for turn in (1, 2):
            print(f"latency, image to points, turn {turn}: lariat {measured(rig, rig.points, '/camera/image_raw')}; bare rclpy {measured(rig, answered, '/bare/image_raw')}")
        bare.terminate()
        try:
            bare.wait(timeout=10)
        except subprocess.TimeoutExpired:
            # rclpy may hang during shutdown.
            bare.kill()


def bare():
    """Answers each image with as many points as lariat sends for a rope."""
    rclpy.init()
    node = rclpy.create_node("bare")
    publisher = node.create_publisher(PointCloud2, "/bare/points", SENSOR)
    data = array("B", bytes(120 * 28))

    def answer(message):
        publisher.publish(PointCloud2(header=message.header, width=120, height=1, point_step=28, row_step=len(data), data=data))

    node.create_subscription(Image, "/bare/image_raw", answer, SENSOR)
    try:
        rclpy.spin(node)
    except ExternalShutdownException:
        pass


def main():
    if sys.argv[1] == "bare":
        return bare()
    count, *parts = sys.argv[1:]
    rclpy.init()
    for part in (images, files, jpegs, masks, stopped, grippers, calibration, parameters, latency):
        if not parts or part.__name__ in parts:
            part(*([int(count)] if part in (images, latency) else []))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
