"""Converts color ranges to a mask, as OpenCV users do."""

import timing

cv2, numpy = timing.need("cv2", "numpy")


def buffers(picture, ranges):
    """Returns the picture, its ranges, and memory for HSV and masks. A program in a loop would also
    allocate this memory only once.
    """
    size = picture.shape[:2]
    masks = [numpy.empty(size, numpy.uint8) for _ in range(2)]
    return picture, ranges, numpy.empty_like(picture), masks


def threshold(prepared):
    """Returns 255 where the pixel is in one of the ranges, and 0 elsewhere."""
    picture, ranges, hsv, (mask, other) = prepared
    cv2.cvtColor(picture, cv2.COLOR_BGR2HSV, dst=hsv)
    cv2.inRange(hsv, *ranges[0], dst=mask)
    for bounds in ranges[1:]:
        cv2.inRange(hsv, *bounds, dst=other)
        cv2.bitwise_or(mask, other, dst=mask)
    return mask


if __name__ == "__main__":
    timing.run(buffers, threshold)
