"""A camera of your own as lariat's source, 30 images a second. Beside it runs `lariat run --source external`.

python drawn_camera.py [COUNT]
"""

import itertools
import sys
import time

import numpy as np
from numpy.typing import NDArray

import lariat

HEIGHT, WIDTH = 480, 640
count = int(sys.argv[1]) if len(sys.argv) > 1 else None


def read_camera(image: NDArray[np.uint8], number: int) -> int:
    """Your camera's, into memory that it is given. Here: a dark rope on a light table, which swings."""
    x = np.arange(80, 560)
    y = np.rint(240 + 60 * np.sin(0.012 * x) * np.cos(0.05 * number)).astype(int)
    image[...] = 220
    for across in range(-6, 7):
        image[y + across, x] = (30, 40, 120)
    return time.monotonic_ns()  # when it was taken


with lariat.Writer("frames") as frames:
    for number in itertools.islice(itertools.count(), count):
        with frames.loan(HEIGHT, WIDTH, "rgb8") as slot:  # straight in shared memory: nothing is copied
            slot.exposed_ns = read_camera(slot.array, number)
        time.sleep(1 / 30)
