"""Connected components of a mask, with their areas and boxes."""

import timing

(cv2,) = timing.need("cv2")
from threshold import buffers, threshold


def components(mask):
    return cv2.connectedComponentsWithStats(mask, connectivity=8, ltype=cv2.CV_16U)


if __name__ == "__main__":
    timing.run(lambda *given: threshold(buffers(*given)), components)
