"""Distance of each rope pixel from the table."""

import timing

(cv2,) = timing.need("cv2")
from threshold import buffers, threshold


def distance(mask):
    return cv2.distanceTransform(mask, cv2.DIST_L2, 3)


if __name__ == "__main__":
    timing.run(lambda *given: threshold(buffers(*given)), distance)
