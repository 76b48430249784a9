"""lariat sees ropes, cables and hoses, and gives a control loop their shape.

Pictures and points, without anything else running::

    scene = lariat.trace(image)              # ropes in a NumPy array: centerlines, widths, crossings
    fit = lariat.fit(scene.curves[0])        # a Bezier curve through one: control points, covariance

Positions are in pixels: x to the right, y down, (0, 0) the middle of the top left pixel. ``rho`` is the normalized arc
length: 0 at a rope's first end, 1 at its last.
"""

from lariat._functions import fit, trace
from lariat._names import (
    BasisName,
    HsvRange,
    KnotsName,
    MaskImage,
    MaskName,
    MethodName,
    Picture,
    PixelFormat,
    RhoName,
    SolverName,
    StatusName,
    UnitName,
)
from lariat._native import (
    Crossing,
    Curve,
    Fit,
    Fitter,
    Notice,
    Scene,
    Tracer,
    pick,
)

__all__ = [
    "BasisName",
    "Crossing",
    "Curve",
    "Fit",
    "Fitter",
    "HsvRange",
    "KnotsName",
    "MaskImage",
    "MaskName",
    "MethodName",
    "Notice",
    "Picture",
    "PixelFormat",
    "RhoName",
    "Scene",
    "SolverName",
    "StatusName",
    "Tracer",
    "UnitName",
    "fit",
    "pick",
    "trace",
]
