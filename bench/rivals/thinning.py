"""A mask thinned to lines of one pixel by scikit-image."""

import timing

# OpenCV makes the mask. This is not timed.
_, morphology = timing.need("cv2", "skimage.morphology")
from threshold import buffers, threshold


def thin(mask):
    return morphology.skeletonize(mask, method="zhang")


if __name__ == "__main__":
    timing.run(lambda *given: threshold(buffers(*given)) > 0, thin)
