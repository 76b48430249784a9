"""Reference values by SciPy and geomdl, for tests/all/curves.rs.

    python3 crates/fit/tests/curves.py > crates/fit/tests/curves.json

Made with Python 3.11.7, NumPy 2.4.6, SciPy 1.17.1, geomdl 5.4.0. `splines` has B-splines with
points and three derivatives by scipy.interpolate.BSpline, and one knot inserted by geomdl's
`insert_knot`. `beziers` has polynomial and rational Bezier curves with points and derivatives by
geomdl, and for polynomials the control points by geomdl's `degree_elevation`. `lengths` has arc
lengths by scipy.integrate.quad. `nearest` has distances by a grid and
scipy.optimize.minimize_scalar.
"""

import json

import numpy as np
from geomdl import BSpline, NURBS, helpers, operations, utilities
from scipy.integrate import quad
from scipy.interpolate import BSpline as SciPySpline
from scipy.optimize import minimize_scalar

rng = np.random.default_rng(2312)
RHO = [0.0, 0.07, 0.25, 0.4321, 0.5, 0.8, 0.99, 1.0]


def control_points(count, dimension=2):
    return np.round(rng.uniform(0.0, 640.0, (count, dimension)), 3)


def clamped(interior, degree):
    return [0.0] * (degree + 1) + interior + [1.0] * (degree + 1)


def spline(degree, count, interior=None):
    if interior is None:
        pieces = count - degree
        interior = [i / pieces for i in range(1, pieces)]
    knots = clamped(interior, degree)
    points = control_points(count)
    curve = SciPySpline(np.array(knots), points, degree)
    other = BSpline.Curve()
    other.degree = degree
    other.ctrlpts = points.tolist()
    other.knotvector = knots
    operations.insert_knot(other, [0.3], [1])
    return {
        "degree": degree,
        "knots": knots,
        "control_points": points.tolist(),
        "derivatives": [
            [curve(rho, nu=k).tolist() if k <= degree else [0.0, 0.0] for k in range(4)]
            for rho in RHO
        ],
        "inserted": {
            "rho": 0.3,
            "knots": list(other.knotvector),
            "control_points": [list(point) for point in other.ctrlpts],
        },
    }


def bezier(order, dimension=2, rational=False):
    points = control_points(order + 1, dimension)
    weights = np.round(rng.uniform(0.5, 2.0, order + 1), 3) if rational else None
    curve = NURBS.Curve() if rational else BSpline.Curve()
    curve.degree = order
    if rational:
        curve.ctrlptsw = np.column_stack([points * weights[:, None], weights]).tolist()
    else:
        curve.ctrlpts = points.tolist()
    curve.knotvector = utilities.generate_knot_vector(order, order + 1)
    return {
        "weights": weights.tolist() if rational else [],
        "control_points": points.tolist(),
        "derivatives": [[list(d) for d in curve.derivatives(rho, 3)[:4]] for rho in RHO],
        "elevated": [] if rational else [
            list(point) for point in helpers.degree_elevation(order, points.tolist(), num=3)
        ],
    }


def power_form(points):
    """A Bezier curve as NumPy polynomials, one for each coordinate."""
    order = len(points) - 1
    basis = [
        np.polynomial.Polynomial([0, 1]) ** j
        * np.polynomial.Polynomial([1, -1]) ** (order - j)
        * float(np.prod([(order - i) / (i + 1) for i in range(j)]))
        for j in range(order + 1)
    ]
    return [sum(p * b for p, b in zip(column, basis)) for column in points.T]


def length(order):
    points = control_points(order + 1)
    slopes = [polynomial.deriv() for polynomial in power_form(points)]
    speed = lambda rho: float(np.hypot(*[slope(rho) for slope in slopes]))
    to = [0.0, 0.3, 0.9, 1.0]
    parts = [quad(speed, a, b, epsabs=0.0, epsrel=1e-13, limit=500)[0] for a, b in zip(to, to[1:])]
    return {
        "control_points": points.tolist(),
        "to": to[1:],
        "lengths": np.cumsum(parts).tolist(),
    }


def nearest(order):
    points = control_points(order + 1)
    x, y = power_form(points)
    cases = []
    for point in control_points(8):
        distance = lambda rho: float(np.hypot(x(rho) - point[0], y(rho) - point[1]))
        grid = np.linspace(0.0, 1.0, 4001)
        best = int(np.argmin([distance(rho) for rho in grid]))
        bounds = (grid[max(best - 1, 0)], grid[min(best + 1, 4000)])
        found = minimize_scalar(distance, bounds=bounds, method="bounded", options={"xatol": 1e-13})
        ends = min(distance(bounds[0]), distance(bounds[1]))
        cases.append({"point": point.tolist(), "distance": min(found.fun, ends)})
    return {"control_points": points.tolist(), "cases": cases}


print(json.dumps({
    "rho": RHO,
    "splines": [
        spline(1, 5),
        spline(2, 7),
        spline(3, 7),
        spline(3, 20),
        spline(5, 12),
        spline(3, 8, [0.1, 0.4, 0.4, 0.85]),
        spline(4, 9, [0.02, 0.3, 0.31, 0.9]),
    ],
    "beziers": [bezier(3), bezier(8), bezier(4, 3), bezier(12)]
    + [bezier(2, rational=True), bezier(8, rational=True), bezier(3, 3, rational=True)],
    "lengths": [length(order) for order in (2, 3, 8)],
    "nearest": [nearest(order) for order in (3, 5, 8)],
}).replace("]], \"", "]],\n\"").replace("}, {", "},\n{"))
