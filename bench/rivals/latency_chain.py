"""The whole chain as users of OpenCV and NumPy script it: one process with one thread, no hop
between processes, and a Bezier curve of order 8.

Each frame is taken when it is due. Its rope becomes 120 points (`chain.py`), and these become nine
control points by a precomputed pseudo-inverse.
"""

import math
import time

import pacing
import timing

cv2, numpy = timing.need("cv2", "numpy")
import chain

ORDER = 8


def fitter():
    """Returns the matrix from points to control points: the pseudo-inverse of the Bernstein
    polynomials on an even grid.
    """
    rho = numpy.linspace(0.0, 1.0, chain.POINTS)[:, None]
    j = numpy.arange(ORDER + 1)
    binomials = numpy.array([math.comb(ORDER, int(k)) for k in j])
    return numpy.linalg.pinv(binomials * rho**j * (1.0 - rho) ** (ORDER - j))


def main():
    asked = pacing.request()
    ranges = [tuple(numpy.array(b, numpy.uint8) for b in bounds) for bounds in asked["ranges"]]
    shape = (asked["height"], asked["width"], 3)
    # OpenCV users have BGR images.
    images = [
        numpy.ascontiguousarray(numpy.frombuffer(frame, numpy.uint8).reshape(shape)[:, :, ::-1])
        for frame in pacing.frames(asked)
    ]
    (_, ranges, hsv, masks), thin, thinning = chain.prepare(images[0], ranges)
    pseudo_inverse = fitter()
    whole_ns, work_ns = [], []
    for number, due_ns in pacing.due(asked):
        started_ns = time.monotonic_ns()
        prepared = images[number % len(images)], ranges, hsv, masks
        _, points, _ = chain.chain((prepared, thin, thinning))
        if len(points):
            pseudo_inverse @ points
        done_ns = time.monotonic_ns()
        whole_ns.append(done_ns - due_ns)
        work_ns.append(done_ns - started_ns)
    pacing.answer(whole_ns, timing.versions(), work_ns)


if __name__ == "__main__":
    if not chain.thinnings():
        timing.need("skimage")
    pacing.settle()
    main()
