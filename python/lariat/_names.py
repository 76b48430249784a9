"""Types of arguments, for type hints: arrays and the names of settings."""

from __future__ import annotations

from typing import Literal, TypeAlias, TypedDict, Union

import numpy as np
from numpy.typing import NDArray

Picture: TypeAlias = Union[NDArray[np.uint8], NDArray[np.uint16]]
MaskImage: TypeAlias = Union[NDArray[np.uint8], NDArray[np.bool_]]
PixelFormat: TypeAlias = Literal[
    "gray",
    "rgb",
    "bgr",
    "yuyv",
    "uyvy",
    "nv12",
    "bgra",
    "gray16",
    "bayer_rggb8",
    "bayer_bggr8",
    "bayer_grbg8",
    "bayer_gbrg8",
]
MaskName: TypeAlias = Literal["auto", "network", "external"]
MethodName: TypeAlias = Literal["skeleton", "kmeans", "som", "gmm", "fcm"]
StatusName: TypeAlias = Literal["ok", "partial", "lost", "doubtful"]
FitName: TypeAlias = Literal["not judged", "good", "coarse"]
BasisName: TypeAlias = Literal["bezier", "bspline", "rational", "fourier", "points", "mass"]
KnotsName: TypeAlias = Literal["uniform", "averaged"]
SolverName: TypeAlias = Literal["pinv", "cholesky", "qr"]
RhoName: TypeAlias = Literal["even", "measured"]
UnitName: TypeAlias = Literal["px", "mm", "ideal px"]


class HsvRange(TypedDict, total=False):
    """A range of colors. Missing bounds are unrestricted."""

    hue_deg: tuple[float, float]
    """0 to 360 (twice OpenCV's); (350, 10) includes red."""
    saturation: tuple[float, float]
    """0 to 1 (OpenCV's divided by 255)."""
    value: tuple[float, float]
    """0 to 1 (OpenCV's divided by 255)."""
