"""Shared code of the rivals: one thread, the list of pictures, medians, a line of JSON for each
picture.
"""

import importlib
import json
import os
import statistics
import sys
import time

# Set before any library reads them.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

PACKAGES = {
    "cv2": "opencv-contrib-python-headless",
    "numpy": "numpy",
    "onnx": "onnx",
    "onnxruntime": "onnxruntime",
    "scipy": "scipy",
    "skimage": "scikit-image",
    "zenoh": "eclipse-zenoh",
    "zmq": "pyzmq",
}
NAMES = {"cv2": "OpenCV", "numpy": "NumPy", "scipy": "SciPy", "skimage": "scikit-image"}

# Time limit for measuring a picture. Every picture is measured at least once.
LONGEST_MS = 100.0

_versions = {}


def need(*modules):
    """Returns the named modules. If one is missing, reports it as JSON and ends the script."""
    found = []
    for module in modules:
        library = module.split(".")[0]
        try:
            found.append(importlib.import_module(module))
            version = getattr(importlib.import_module(library), "__version__", "")
        except ImportError:
            print(json.dumps({"missing": PACKAGES[library]}))
            sys.exit(0)
        _versions[NAMES.get(library, library)] = version
        if module == "cv2":
            found[-1].setNumThreads(1)
    return found


def versions():
    """Returns the versions of the modules needed so far."""
    return dict(_versions)


def run(prepare, work, describe=None):
    """Times work(prepare(picture, ranges)) for each picture of the list named on the command line.

    `describe` turns the result of `work` into additional fields of the picture's line.
    """
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} PICTURES.json (see the README beside it)")
    import cv2
    import numpy

    with open(sys.argv[1], encoding="utf-8") as file:
        listed = json.load(file)
    for index, entry in enumerate(listed["pictures"]):
        picture = cv2.imread(entry["path"], cv2.IMREAD_COLOR)
        if picture is None:
            sys.exit(f"cannot read the picture {entry['path']}")
        ranges = [tuple(numpy.array(b, numpy.uint8) for b in bounds) for bounds in entry["ranges"]]
        prepared = prepare(picture, ranges)
        # Not counted: caches, buffers, and initialization that libraries defer to their first call.
        result = work(prepared)
        times_ms = []
        for _ in range(listed["rounds"]):
            start = time.perf_counter_ns()
            result = work(prepared)
            times_ms.append((time.perf_counter_ns() - start) / 1e6)
            if sum(times_ms) > LONGEST_MS:
                break
        line = {
            "picture": index,
            "median_ms": statistics.median(times_ms),
            "rounds": len(times_ms),
            "versions": _versions,
        }
        line.update(describe(result) if describe else {})
        print(json.dumps(line), flush=True)
