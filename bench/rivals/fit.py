"""The curve of order 8 through 120 points, by common curve-fitting libraries."""

import json
import statistics
import sys
import time

import timing

# Time limit for measuring a rival, ns: enough calls for a median.
LONGEST_NS = 2e8
ORDER, POINTS = 8, 120


def measured(work):
    """Returns the median time of a call in nanoseconds, over batches long enough for the clock."""
    work()
    start = time.perf_counter_ns()
    work()
    once_ns = max(time.perf_counter_ns() - start, 100)
    batch = max(1, int(2e4 / once_ns))
    times, spent = [], 0
    while spent < LONGEST_NS or len(times) < 5:
        start = time.perf_counter_ns()
        for _ in range(batch):
            work()
        spent_now = time.perf_counter_ns() - start
        spent += spent_now
        times.append(spent_now / batch)
    return statistics.median(times)


def say(name, work, versions):
    print(json.dumps({"name": name, "median_ns": measured(work), "versions": versions}), flush=True)


def main(points):
    (numpy,) = timing.need("numpy")
    from math import comb

    points = numpy.array(points)
    rho = numpy.linspace(0.0, 1.0, POINTS)
    b = numpy.stack(
        [comb(ORDER, j) * (1 - rho) ** (ORDER - j) * rho**j for j in range(ORDER + 1)], axis=1
    )
    inverse = numpy.linalg.pinv(b)
    with_numpy = {"NumPy": numpy.__version__}
    say("NumPy, precomputed pinv @ points", lambda: inverse @ points, with_numpy)
    say("np.linalg.lstsq", lambda: numpy.linalg.lstsq(b, points, rcond=None), with_numpy)
    try:
        import scipy
        from scipy.interpolate import splprep
        from scipy.linalg import cho_factor, cho_solve
    except ImportError:
        print(json.dumps({"missing": timing.PACKAGES["scipy"]}), flush=True)
    else:
        with_scipy = {"SciPy": scipy.__version__}
        factor = cho_factor(b.T @ b)
        say("scipy.linalg.cho_solve", lambda: cho_solve(factor, b.T @ points), with_scipy)
        # s = N is what SciPy's documentation proposes for noise of 1 px.
        say("scipy.interpolate.splprep, s = N", lambda: splprep(points.T, s=POINTS), with_scipy)
    try:
        import geomdl
        from geomdl.fitting import approximate_curve
    except ImportError:
        print(json.dumps({"missing": "geomdl"}), flush=True)
    else:
        listed = points.tolist()
        say(
            "geomdl approximate_curve, cubic",
            lambda: approximate_curve(listed, 3, ctrlpts_size=ORDER + 1),
            {"geomdl": geomdl.__version__},
        )


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} POINTS.json (a list of 120 points [x, y])")
    with open(sys.argv[1], encoding="utf-8") as file:
        main(json.load(file))
