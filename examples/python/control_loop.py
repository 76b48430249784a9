"""Holds a rope's middle still in the image, in ten lines. Run `lariat run` alongside."""

import lariat

GAIN, GOAL = 2.0, (320.0, 240.0)  # 1/s; px


def move(vx: float, vy: float) -> None:
    """Replace this with your robot."""
    print(f"move {vx:8.1f} {vy:8.1f} px/s")


with lariat.Reader(timeout=0.1) as reader:
    for frame in reader:
        match frame.only_rope(max_age=0.05):
            case lariat.Fresh(rope):
                x, y = rope.shape.point_at(0.5)
                move(GAIN * (GOAL[0] - x), GAIN * (GOAL[1] - y))
            case seen:  # Partial, Unsure, Lost, Stale, Absent: do not steer by them, or only slowly.
                move(0.0, 0.0)
                print(f"hold: {seen}")
