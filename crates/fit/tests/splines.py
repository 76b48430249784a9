"""Makes splines.json: least-squares B-splines by SciPy and geomdl.

    python3 -m pip install numpy==2.4.6 scipy==1.17.1 geomdl==5.4.0
    python3 splines.py > splines.json
"""

import json

import numpy
from geomdl.fitting import approximate_curve
from scipy.interpolate import make_lsq_spline

random = numpy.random.default_rng(2312)


def rope(count, uneven):
    """Points along a bent rope with noise, in uneven steps if `uneven`."""
    t = numpy.linspace(0, 1, count)
    if uneven:
        t = numpy.sort(numpy.concatenate([[0, 1], random.uniform(0.01, 0.99, count - 2)]))
    points = numpy.stack([60 + 500 * t, 240 + 130 * numpy.sin(5 * t + 0.3) * numpy.cos(2 * t)], axis=1)
    return points + random.normal(0, 0.4, points.shape)


def clamped(inner, degree):
    return numpy.concatenate([numpy.zeros(degree + 1), inner, numpy.ones(degree + 1)])


cases = []
for degree, control_points, count in [(1, 5, 40), (2, 7, 60), (3, 9, 120), (4, 16, 120), (5, 20, 256)]:
    points = rope(count, False)
    inner = numpy.linspace(0, 1, control_points - degree + 1)[1:-1]
    knots = clamped(inner, degree)
    spline = make_lsq_spline(numpy.linspace(0, 1, count), points, knots, degree)
    cases.append(
        {
            "by": "scipy.interpolate.make_lsq_spline",
            "degree": degree,
            "points": points.tolist(),
            "knots": knots.tolist(),
            "control_points": spline.c.tolist(),
        }
    )
for degree, control_points, count in [(2, 6, 30), (3, 9, 120), (4, 12, 100)]:
    points = rope(count, True)
    # Chord-length parameters, Piegl and Tiller's averaged knots, interpolated ends.
    curve = approximate_curve(points.tolist(), degree, ctrlpts_size=control_points)
    cases.append(
        {
            "by": "geomdl.fitting.approximate_curve",
            "degree": degree,
            "points": points.tolist(),
            "knots": list(curve.knotvector),
            "control_points": [list(point) for point in curve.ctrlpts],
        }
    )
print(json.dumps(cases))
