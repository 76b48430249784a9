"""A mask thinned to lines of one pixel by OpenCV's contributed modules."""

import timing

cv2, ximgproc = timing.need("cv2", "cv2.ximgproc")
from threshold import buffers, threshold


def thin(mask):
    return ximgproc.thinning(mask, thinningType=ximgproc.THINNING_ZHANGSUEN)


if __name__ == "__main__":
    timing.run(lambda *given: threshold(buffers(*given)), thin)
