"""Generates example pictures for own.sh: `own_example.py PHOTOGRAPH FOLDER` draws cables on a
photograph, with labels.

FOLDER/own has twenty pictures on the photograph's left half, for training. FOLDER/others has forty
on its right half, for evaluation. The cables are drawn differently from those of lariat-scenes.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np

SIDE = 384
SETS = (("own", 20, 11), ("others", 40, 12))  # name, pictures, seed
STEPS = 60  # points of a curve between two of its knots
SHADOW_PX = 14  # maximum distance of a shadow from a cable's edge


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("photograph", type=Path)
    parser.add_argument("folder", type=Path)
    return parser.parse_args()


def curve(random):
    """Returns points along a smooth curve that starts in the picture or at its border."""
    count, heading = random.integers(4, 7), random.uniform(0, 2 * np.pi)
    knots = [random.uniform(0, SIDE, 2)]
    if random.random() < 0.6:
        border, t = random.integers(4), random.uniform(0, SIDE)
        knots = [np.array([(t, -20), (t, SIDE + 20), (-20, t), (SIDE + 20, t)][border], float)]
        inward = SIDE / 2 - knots[0]
        heading = np.arctan2(inward[1], inward[0])
    for _ in range(count):
        heading += random.normal(0, 0.75)
        knots.append(knots[-1] + random.uniform(70, 130) * np.array([np.cos(heading), np.sin(heading)]))
    knots = np.array([2 * knots[0] - knots[1], *knots, 2 * knots[-1] - knots[-2]])
    t = np.linspace(0, 1, STEPS, endpoint=False)[:, None]
    spans = zip(knots, knots[1:], knots[2:], knots[3:])  # Catmull and Rom, 1974
    return np.vstack([0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3) for a, b, c, d in spans])


def places(points, reach_px):
    """Returns, for each pixel, its distance from a curve, the side of the curve, and the position
    along it. The distance is infinite for far pixels.
    """
    drawn = np.ones((SIDE, SIDE), np.uint8)
    cv2.polylines(drawn, [np.round(8 * points).astype(np.int32)], False, 0, 1, cv2.LINE_8, 3)
    y, x = np.nonzero(cv2.distanceTransform(drawn, cv2.DIST_L2, 5) < reach_px)
    pixels = np.stack([x, y], 1)
    nearest, least = np.zeros(len(pixels), int), np.full(len(pixels), np.inf)
    for k in range(0, len(points), 64):
        squares = ((pixels[:, None] - points[None, k : k + 64]) ** 2).sum(2)
        index = squares.argmin(1)
        square = squares[np.arange(len(pixels)), index]
        closer = square < least
        least[closer], nearest[closer] = square[closer], index[closer] + k
    tangent = np.gradient(points, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True) + 1e-9
    along = np.r_[0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    away = pixels - points[nearest]
    maps = np.full((3, SIDE, SIDE), np.inf)
    maps[:, y, x] = np.sqrt(least), tangent[nearest, 0] * away[:, 1] - tangent[nearest, 1] * away[:, 0], along[nearest]
    return maps


def lay(picture, label, number, random):
    """Draws a round cable of one color, sometimes twisted, with a shadow."""
    points, width_px = curve(random), random.uniform(6, 16)
    distance, side, along = places(points, width_px / 2 + SHADOW_PX)
    if np.isinf(distance).all():
        return
    cast = np.roll(distance, (int(0.3 * width_px), int(0.2 * width_px)), (0, 1))
    shadow = np.clip(1 - (cast - width_px / 2) / (0.6 * width_px), 0, 1) * random.uniform(0.1, 0.45)
    picture *= (1 - shadow * (distance >= width_px / 2 - 0.5))[..., None]
    hsv = np.uint8([[[random.integers(180), random.integers(20, 240), random.integers(30, 240)]]])
    color = cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0].astype(float)
    if random.random() < 0.3:
        color = np.full(3, random.uniform(15, 230))
    side, along = (np.where(np.isinf(value), 0, value) for value in (2 * side / width_px, along))
    height = np.sqrt(np.clip(1 - side**2, 0, 1))
    shade = 0.45 + 0.6 * np.clip(0.8 * height + random.uniform(-0.25, 0.25) * side, 0, 1.2)
    if random.random() < 0.4:
        shade *= 1 + 0.25 * np.sin(2 * np.pi * (along / (width_px * random.uniform(0.8, 1.6)) + side / 2))
    shine = random.uniform(0, 60) * 6 * np.clip(height - 0.85, 0, 1)
    cable = np.clip(color * shade[..., None] + shine[..., None], 0, 255)
    cover = np.clip(width_px / 2 + 0.5 - distance, 0, 1)[..., None]
    picture[:] = picture * (1 - cover) + cable * cover
    label[cover[..., 0] > 0.5] = number


def draw(ground, random):
    """Draws one to three cables on a part of the ground. Returns the picture and its label."""
    height, width = ground.shape[:2]
    side = int(min(height, width) * random.uniform(0.5, 0.95))
    top = height // 2 + random.integers(-height // 10, height // 10 + 1) - side // 2
    left = width // 2 + random.integers(-width // 8, width // 8 + 1) - side // 2
    top, left = np.clip([top, left], 0, [height - side, width - side])
    picture = cv2.resize(ground[top : top + side, left : left + side], (SIDE, SIDE)).astype(float)
    picture = np.rot90(picture, random.integers(4)) * random.uniform(0.7, 1.15)
    label = np.zeros((SIDE, SIDE), np.uint8)
    for number in range(random.integers(1, 4)):
        lay(picture, label, number + 1, random)
    picture = cv2.GaussianBlur(picture, (0, 0), random.uniform(0.4, 0.9)) + random.normal(0, random.uniform(1, 4), picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8), label


def main():
    args = arguments()
    photograph = cv2.imread(str(args.photograph))
    if photograph is None:
        raise SystemExit(f"{args.photograph} is no picture")
    middle = photograph.shape[1] // 2
    for (name, count, seed), ground in zip(SETS, (photograph[:, :middle], photograph[:, middle:])):
        for kind in ("images", "labels"):
            (args.folder / name / kind).mkdir(parents=True, exist_ok=True)
        for k in range(count):
            picture, label = draw(ground, np.random.default_rng([seed, k]))
            for kind, value in (("images", picture), ("labels", label)):
                cv2.imwrite(str(args.folder / name / kind / f"{k:02}.png"), value)


if __name__ == "__main__":
    main()
