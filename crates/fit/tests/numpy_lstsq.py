"""Reference fits by NumPy, for tests/all/numpy_lstsq.rs.

    python3 crates/fit/tests/numpy_lstsq.py > crates/fit/tests/numpy_lstsq.json

Made with Python 3.11.7, NumPy 2.4.6. Each case contains noisy points on a wavy curve (px, rounded
to three decimals), the control points by numpy.linalg.lstsq on the Bernstein matrix, the residuals,
and the matrix's condition number by numpy.linalg.cond.
"""

import json
from math import comb

import numpy as np

rng = np.random.default_rng(2312)


def bernstein_matrix(order, points):
    rho = np.linspace(0.0, 1.0, points)
    return np.array(
        [[comb(order, j) * (1 - r) ** (order - j) * r**j for j in range(order + 1)] for r in rho]
    )


def case(order, points):
    t = np.linspace(0.0, 1.0, points)
    a, b, c = rng.uniform(0.5, 3.0, 3)
    wave = np.stack([320 + 250 * np.cos(a * t + b), 240 + 180 * np.sin(2 * c * t)], axis=1)
    noisy = np.round(wave + rng.normal(0.0, 0.3, (points, 2)), 3)
    matrix = bernstein_matrix(order, points)
    control_points = np.linalg.lstsq(matrix, noisy, rcond=None)[0]
    distances = np.linalg.norm(matrix @ control_points - noisy, axis=1)
    freedom = 2 * (points - order - 1)
    return {
        "order": order,
        "points": noisy.tolist(),
        "control_points": control_points.tolist(),
        "condition": float(np.linalg.cond(matrix)),
        "rms_px": float(np.sqrt(np.mean(distances**2))),
        "max_px": float(distances.max()),
        "residual_variance": float(np.sum(distances**2) / freedom) if freedom else 0.0,
    }


sizes = [(1, 2), (1, 120), (2, 120), (4, 120), (6, 120), (8, 120), (8, 9), (8, 256), (3, 33), (10, 121)]
print("[" + ",\n".join(json.dumps(case(order, points)) for order, points in sizes) + "]")
