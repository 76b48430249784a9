"""Your own camera as lariat's source, 30 images a second.

Run `lariat run --source external` alongside.

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
    """Replace this with your camera, which fills `image`. Here: a swinging dark rope."""
    x = np.arange(80, 560)
    y = np.rint(240 + 60 * np.sin(0.012 * x) * np.cos(0.05 * number)).astype(int)
    image[...] = 220
    for across in range(-6, 7):
        image[y + across, x] = (30, 40, 120)
    return time.monotonic_ns()  # time of the exposure


with lariat.Writer("frames") as frames:
    for number in itertools.islice(itertools.count(), count):
        with frames.loan(HEIGHT, WIDTH, "rgb8") as slot:  # straight into shared memory, without a copy
            slot.exposed_ns = read_camera(slot.array, number)
        time.sleep(1 / 30)
