"""A whole extraction as users of the image libraries script it. Finds the rope of the largest
component, as 120 points.

Steps: threshold, largest component, skeleton, the longest of the shortest paths along it,
smoothing, resampling at equal steps of arc length, and widths from the distance transform. After
the threshold only the component's bounding box is processed. The script supports one rope and no
crossing: where a rope crosses itself, the path takes the short cut.
"""

import time

import timing

cv2, numpy, sparse, csgraph, ndimage = timing.need(
    "cv2", "numpy", "scipy.sparse", "scipy.sparse.csgraph", "scipy.ndimage"
)
from components import components
from distance import distance
from threshold import buffers, threshold

POINTS = 120
# Number of skeleton pixels that are averaged, because the skeleton's steps are whole pixels.
SMOOTHED = 9


def thinnings():
    """Returns the installed thinning functions, by name."""
    found = {}
    if hasattr(cv2, "ximgproc"):
        zhang_suen = cv2.ximgproc.THINNING_ZHANGSUEN
        found["cv2.ximgproc.thinning"] = lambda mask: cv2.ximgproc.thinning(mask, thinningType=zhang_suen)
    try:
        from skimage import morphology

        found["skimage.skeletonize"] = lambda mask: morphology.skeletonize(mask > 0)
    except ImportError:
        pass
    return found


def fastest(mask):
    """Returns the fastest way to thin this mask, by the best of three tries, and its name."""

    def best_s(thin):
        thin(mask)
        tries = []
        for _ in range(3):
            start = time.perf_counter()
            thin(mask)
            tries.append(time.perf_counter() - start)
        return min(tries)

    return min(thinnings().items(), key=lambda way: best_s(way[1]))


def rope(prepared):
    """Returns the largest component, alone in its box with a one-pixel border of table, and the
    box's corner.
    """
    mask = threshold(prepared)
    count, labels, stats, _ = components(mask)
    if count < 2:
        return None
    largest = 1 + int(numpy.argmax(stats[1:, cv2.CC_STAT_AREA]))
    x, y, width, height = stats[largest, :4]
    box = cv2.inRange(labels[y : y + height, x : x + width], largest, largest)
    return cv2.copyMakeBorder(box, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0), (x - 1, y - 1)


def path(skeleton):
    """Returns the skeleton's pixels, [x, y], along the path between the two that are farthest
    apart.
    """
    ys, xs = numpy.nonzero(skeleton)
    number = numpy.full(skeleton.shape, -1, numpy.int32)
    number[ys, xs] = numpy.arange(len(xs))
    pairs = []
    # The box has a border of table, so no neighbor is outside.
    for dy, dx in ((0, 1), (1, -1), (1, 0), (1, 1)):
        neighbour = number[ys + dy, xs + dx]
        from_ = numpy.nonzero(neighbour >= 0)[0]
        pairs.append((from_, neighbour[from_]))
    rows = numpy.concatenate([a for a, _ in pairs])
    columns = numpy.concatenate([b for _, b in pairs])
    links = sparse.csr_matrix((numpy.ones(len(rows), numpy.int8), (rows, columns)), (len(xs),) * 2)
    # Only the farthest pixel of the first search is used.
    end = csgraph.breadth_first_order(links, 0, directed=False)[0][-1]
    order, before = csgraph.breadth_first_order(links, end, directed=False)
    before = before.tolist()
    at, walked = int(order[-1]), []
    while at >= 0:
        walked.append(at)
        at = before[at]
    return numpy.column_stack((xs[walked], ys[walked])).astype(float)


def prepare(picture, ranges):
    prepared = buffers(picture, ranges)
    found = rope(prepared)
    name, thin = fastest(found[0]) if found else ("none", None)
    return prepared, thin, name


def chain(given):
    prepared, thin, name = given
    found = rope(prepared)
    if not found:
        return name, [], []
    mask, corner = found
    pixels = path(thin(mask))
    pixels = ndimage.uniform_filter1d(pixels, SMOOTHED, axis=0, mode="nearest")
    steps_px = numpy.hypot(*numpy.diff(pixels, axis=0).T)
    along_px = numpy.concatenate(([0.0], numpy.cumsum(steps_px)))
    wanted_px = numpy.linspace(0.0, along_px[-1], POINTS)
    points = numpy.column_stack([numpy.interp(wanted_px, along_px, pixels[:, c]) for c in (0, 1)])
    nearest = numpy.rint(points).astype(int)
    widths_px = 2.0 * distance(mask)[nearest[:, 1], nearest[:, 0]]
    return name, points + corner, widths_px


def describe(result):
    name, points, widths_px = result
    return {
        "thinning": name,
        "points": [[float(x), float(y)] for x, y in points],
        "widths_px": [float(w) for w in widths_px],
    }


if __name__ == "__main__":
    if not thinnings():
        timing.need("skimage")
    timing.run(prepare, chain, describe)
