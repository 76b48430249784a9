"""Reference clusterings by MiniSom, scikit-learn and scikit-fuzzy, for
crates/clustering/src/references.rs.

    python3 crates/clustering/tests/clusterings.py > crates/clustering/tests/clusterings.json

Made with Python 3.11.7, NumPy 2.4.6, MiniSom 2.3.6, scikit-learn 1.9.1, scikit-fuzzy 0.5.0. The
pixels are those within 4.5 px of a curve that crosses itself. All three begin from the same
centers, chosen among the pixels: each is the farthest of ten candidates from those before it. They
end by the default criteria that our modules name. The results are:

    som        the quantization error after 10,000 samples drawn by splitmix64
    mixture    lower_bound_ and n_iter_, from the means, weights and variances of the pixels nearest to each center,
               where a pixel belongs in equal parts to equidistant centers
    fuzzy      J of the last centers with their own memberships, px^2, and the rounds, from the memberships to the first
               centers; few centers end by the error, many by the number of rounds
"""

import json
import warnings

import numpy as np
from minisom import MiniSom
from skfuzzy.cluster import cmeans
from sklearn.mixture import GaussianMixture

warnings.filterwarnings("ignore")  # convergence warnings
rng = np.random.default_rng(2312)


def mask():
    t = np.linspace(0.0, 1.0, 1500)
    a = -4.4 + 8.8 * t
    curve = np.stack([160 + 14 * a - 34 * np.sin(a), 120 + 70 * np.cos(a)], axis=1)
    y, x = np.mgrid[0:240, 0:320]
    near = np.full(x.shape, np.inf)
    for cx, cy in curve:
        near = np.minimum(near, (x - cx) ** 2 + (y - cy) ** 2)
    return near <= 4.5**2


def runs(mask):
    found = []
    for y, row in enumerate(mask):
        steps = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
        found += [[y, int(a), int(b)] for a, b in zip(steps[::2], steps[1::2])]
    return found


def squares(pixels, centers):
    return ((pixels[:, None] - centers[None]) ** 2).sum(axis=2)


def chosen(pixels, count):
    centers = [pixels[rng.integers(len(pixels))]]
    while len(centers) < count:
        some = pixels[rng.choice(len(pixels), 10, replace=False)]
        centers.append(some[squares(some, np.array(centers)).min(axis=1).argmax()])
    return np.array(centers)


def splitmix64(seed, count):
    mask = (1 << 64) - 1
    numbers = []
    for _ in range(count):
        seed = (seed + 0x9E3779B97F4A7C15) & mask
        z = seed
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        numbers.append(z ^ (z >> 31))
    return numbers


def som(pixels, centers, seed, rounds=10_000):
    map = MiniSom(1, len(centers), 2, sigma=3.0, learning_rate=0.5)
    map._weights = centers[None].copy()
    samples = [(number * len(pixels)) >> 64 for number in splitmix64(seed, rounds)]
    map.train(pixels[samples], rounds)
    return {"seed": seed, "quantization_error": map.quantization_error(pixels)}


def mixture(pixels, centers):
    d = squares(pixels, centers)
    belongs = d == d.min(axis=1, keepdims=True)
    belongs = belongs / belongs.sum(axis=1, keepdims=True)
    n = belongs.sum(axis=0)
    means = belongs.T @ pixels / n[:, None]
    variances = (belongs * squares(pixels, means)).sum(axis=0) / (2 * n) + 1e-6
    fit = GaussianMixture(
        len(centers),
        covariance_type="spherical",
        weights_init=n / len(pixels),
        means_init=means,
        precisions_init=1 / variances,
    ).fit(pixels)
    return {"lower_bound": fit.lower_bound_, "rounds": fit.n_iter_}


def fuzzy(pixels, centers):
    weights = 1 / np.maximum(squares(pixels, centers), 1e-8)
    first = (weights / weights.sum(axis=1, keepdims=True)).T
    found, _, _, _, _, rounds, _ = cmeans(pixels.T, len(centers), 2, 0.005, 300, init=first)
    weights = 1 / np.maximum(squares(pixels, found), 1e-8)
    return {"objective": (1 / weights.sum(axis=1)).sum(), "rounds": rounds, "centers": found.tolist()}


rope = mask()
y, x = np.nonzero(rope)
pixels = np.stack([x, y], axis=1).astype(float)
cases = []
for count in [1, 3, 7, 40, 120]:
    centers = chosen(pixels, count)
    cases.append(
        {
            "centers": centers.tolist(),
            "som": som(pixels, centers, count),
            "mixture": mixture(pixels, centers),
            "fuzzy": fuzzy(pixels, centers),
        }
    )
text = ",\n".join(json.dumps(case) for case in cases)
print('{"runs": ' + json.dumps(runs(rope)) + ',\n"cases": [\n' + text + "\n]}")
