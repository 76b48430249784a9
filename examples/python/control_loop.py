"""Holds the middle of a rope still in the image: a control law in ten lines. Beside it runs `lariat run`."""

import lariat

GAIN, GOAL = 2.0, (320.0, 240.0)  # 1/s; px


def move(vx: float, vy: float) -> None:
    """Your robot's."""
    print(f"move {vx:8.1f} {vy:8.1f} px/s")


with lariat.Reader(timeout=0.1) as reader:
    for frame in reader:
        match frame.only_rope(max_age=0.05):
            case lariat.Fresh(rope):
                x, y = rope.shape.point_at(0.5)
                move(GAIN * (GOAL[0] - x), GAIN * (GOAL[1] - y))
            case seen:  # Partial, Unsure, Lost, Stale, Absent: not to be steered by, or not so fast.
                move(0.0, 0.0)
                print(f"hold: {seen}")
