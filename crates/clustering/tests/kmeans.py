"""Reference clusterings by scikit-learn, for tests/all/kmeans.rs.

    python3 crates/clustering/tests/kmeans.py > crates/clustering/tests/kmeans.json

Made with Python 3.11.7, NumPy 2.4.6, scikit-learn 1.9.1, one thread. Each case contains the runs of
a mask ([row, first column, column after the last]), 40 initial centers, and the result of
sklearn.cluster.KMeans: the centers, the inertia (px²) and the rounds.
"""

import json
import os

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from sklearn.cluster import KMeans

rng = np.random.default_rng(2312)
CENTERS = 40


def mask_of(x, y, width_px, size):
    """Returns the pixels within half a width of the curve (x, y)."""
    columns, rows = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    squares = np.full(columns.shape, np.inf)
    for px, py in zip(x, y):
        squares = np.minimum(squares, (columns - px) ** 2 + (rows - py) ** 2)
    return squares <= (width_px / 2) ** 2


def runs_of(mask):
    edges = np.diff(np.pad(mask.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    begins, ends = np.argwhere(edges == 1), np.argwhere(edges == -1)
    return [[int(y), int(a), int(b)] for (y, a), (_, b) in zip(begins, ends)]


def case(name, mask, start):
    pixels = np.argwhere(mask)[:, ::-1].astype(np.float64)
    found = KMeans(
        len(start), init=start, n_init=1, algorithm="lloyd", max_iter=300, tol=1e-4
    ).fit(pixels)
    return {
        "name": name,
        "runs": runs_of(mask),
        "start": start.tolist(),
        "centers": np.round(found.cluster_centers_, 4).tolist(),
        "inertia": float(found.inertia_),
        "rounds": int(found.n_iter_),
    }


def drawn(mask):
    """Returns initial centers near distinct pixels. They are jittered because exact pixel positions
    would leave many pixels equidistant from two centers, where rounding errors decide."""
    pixels = np.argwhere(mask)[:, ::-1].astype(np.float64)
    chosen = pixels[rng.choice(len(pixels), CENTERS, replace=False)]
    return np.round(chosen + rng.uniform(-0.5, 0.5, chosen.shape), 3)


t = np.linspace(0.0, 1.0, 600)
wave = mask_of(20 + 280 * t, 60 + 40 * np.sin(9 * t), 11, (320, 120))
# A rope that crosses itself three times, with rows, columns and diagonals.
a = 2 * np.pi * t[:560]
knot = mask_of(110 + 80 * np.sin(2 * a), 100 + 80 * np.sin(3 * a), 9, (220, 200))
bar = mask_of(20 + 260 * t, 20 + 50.3 * t, 7, (300, 90))

far = drawn(wave)
far[::4] = [5000.0, 7.0]
cases = [
    case("a wave", wave, drawn(wave)),
    case("crossings", knot, drawn(knot)),
    case("a slanted bar", bar, drawn(bar)),
    case("a wave, with ten centers far off on one place", wave, far),
]
print("[" + ",\n".join(json.dumps(case) for case in cases) + "]")
