"""120 centers in a rope's mask, by the libraries for the paper's four clusterings.

Each run starts at the given centers and ends by the same rule as lariat's. The time excludes the
conversion of those centers into the library's initial state (memberships or Gaussians).
"""

import importlib
import importlib.metadata
import json
import sys
import time
import warnings

import timing

LIBRARIES = {"kmeans": "sklearn", "som": "minisom", "gmm": "sklearn", "fcm": "skfuzzy"}
PACKAGES = {"sklearn": "scikit-learn", "minisom": "MiniSom", "skfuzzy": "scikit-fuzzy"}


def squares(pixels, centers):
    return ((pixels[:, None] - centers[None]) ** 2).sum(axis=2)


def measured(work):
    """Returns the time of a call in nanoseconds and its result."""
    begin = time.perf_counter_ns()
    result = work()
    return time.perf_counter_ns() - begin, result


def drawn(seed, rounds, count):
    """Yields the indices below `count` that lariat's map draws, by splitmix64."""
    mask = (1 << 64) - 1
    for _ in range(rounds):
        seed = (seed + 0x9E3779B97F4A7C15) & mask
        z = ((seed ^ (seed >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        yield ((z ^ (z >> 31)) * count) >> 64


def kmeans(pixels, centers, _):
    from sklearn.cluster import KMeans

    fit = KMeans(len(centers), init=centers, n_init=1, algorithm="lloyd", max_iter=300, tol=1e-4)
    ns, fit = measured(lambda: fit.fit(pixels))
    return ns, fit.n_iter_, fit.inertia_


def som(pixels, centers, seed):
    from minisom import MiniSom

    rounds = 10_000
    map = MiniSom(1, len(centers), 2, sigma=3.0, learning_rate=0.5)
    map._weights = centers[None].copy()
    # MiniSom's own random order covers only the first 10,000 pixels: the top of the picture.
    samples = pixels[list(drawn(seed, rounds, len(pixels)))]
    ns, _ = measured(lambda: map.train(samples, rounds))
    return ns, rounds, map.quantization_error(pixels)


def gmm(pixels, centers, _):
    from sklearn.mixture import GaussianMixture

    # Starts with the labels of the nearest centers, as GaussianMixture starts with the labels of
    # its own k-means.
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
    )
    ns, fit = measured(lambda: fit.fit(pixels))
    return ns, fit.n_iter_, fit.lower_bound_


def fcm(pixels, centers, _):
    from skfuzzy.cluster import cmeans

    def weights_to(centers):
        return 1 / squares(pixels, centers).clip(min=1e-8)

    weights = weights_to(centers)
    first = (weights / weights.sum(axis=1, keepdims=True)).T
    ns, fit = measured(lambda: cmeans(pixels.T, len(centers), 2, 0.005, 300, init=first))
    found, rounds = fit[0], fit[5]
    return ns, rounds, (1 / weights_to(found).sum(axis=1)).sum()


def main(request):
    (numpy,) = timing.need("numpy")
    warnings.filterwarnings("ignore")  # warnings about missing convergence
    masks = [numpy.array(mask, float) for mask in request["masks"]]
    for index, run in enumerate(request["runs"]):
        library = LIBRARIES[run["method"]]
        try:
            importlib.import_module(library)
        except ImportError:
            print(json.dumps({"missing": PACKAGES[library]}), flush=True)
            continue
        pixels, centers = masks[run["mask"]], numpy.array(run["centers"], float)
        ns, rounds, objective = globals()[run["method"]](pixels, centers, request["seed"])
        line = {
            "run": index,
            "ns": float(ns),
            "rounds": int(rounds),
            "objective": float(objective),
            "versions": {PACKAGES[library]: importlib.metadata.version(PACKAGES[library])},
        }
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} REQUEST.json (see the README beside it)")
    with open(sys.argv[1], encoding="utf-8") as file:
        main(json.load(file))
