"""Functions for a single image or list of points, without state between calls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from lariat._native import Curve, Fit, Fitter, Scene, Tracer

if TYPE_CHECKING:
    import os

    from numpy.typing import ArrayLike

    from lariat._names import (
        BasisName,
        HsvRange,
        KnotsName,
        MaskImage,
        MethodName,
        Picture,
        PixelFormat,
        RhoName,
        SolverName,
    )


def trace(
    image: Picture,
    *,
    mask: Literal["auto", "network"] | MaskImage | HsvRange | Sequence[HsvRange] = "auto",
    network: str | os.PathLike[str] | None = None,
    method: MethodName = "skeleton",
    points: int = 120,
    ropes: int = 24,
    start: tuple[float, float] | None = None,
    at: Sequence[tuple[float, float]] = (),
    roi: tuple[int, int, int, int] | None = None,
    pixel_format: PixelFormat | None = None,
) -> Scene:
    """Finds the ropes in an image.

    For the frames of a film, use a :class:`Tracer`, which recognizes each rope again and is many
    times faster.

    Args:
        image: ``uint8`` of shape (height, width) for gray, (height, width, 3) for RGB. Rows may
            have gaps, as in a part of a larger image; an array is copied only if the pixels of a
            row are not contiguous.
        mask: The pixels that are rope. ``"auto"`` selects what differs from the table;
            ``"network"`` uses a small neural network, for ropes on any background. One or several
            color ranges, such as :func:`pick` proposes, select the pixels of these colors. An image
            of the same size is used as the mask itself: ``bool``, or ``uint8``, higher where rope is
            more likely. Instance numbers, and ropes darker than the rest, are accepted with a
            warning.
        network: A file of weights trained on your own images, for ``mask="network"``.
        method: Method that finds the centerline in the mask.
        points: Points of each centerline, at equal steps of arc length: 2 to 256.
        ropes: Maximum number of ropes reported: the most confident and longest.
        start: A rope's first point is the end nearest to this position, in px. The default is the
            top left corner.
        at: The ropes to report, each by a position on it, in px. The default is all.
        roi: The part of the image that is read: x, y, width, height in px.
        pixel_format: ``"bgr"`` for images read by OpenCV. The default is ``"gray"`` or ``"rgb"``,
            depending on the shape.

    Raises:
        ValueError: a setting or a shape is invalid; the message names valid ones.
        TypeError: the image is not an array of ``uint8``.
    """
    is_image = isinstance(mask, np.ndarray)
    tracer = Tracer(
        mask="external" if is_image else mask,  # type: ignore[arg-type]
        network=network,
        method=method,
        points=points,
        ropes=ropes,
        start=start,
        at=at,
        roi=roi,
    )
    return tracer.trace(
        image,
        mask=mask if is_image else None,  # type: ignore[arg-type]
        pixel_format=pixel_format,
    )


def fit(
    points: ArrayLike | Curve,
    control_points: int | Literal["auto"] | None = None,
    basis: BasisName | Literal["auto"] = "auto",
    *,
    weights: ArrayLike | None = None,
    closed: bool | None = None,
    width: float | None = None,
    max_control_points: int = 17,
    degree: int = 3,
    knots: KnotsName = "uniform",
    solver: SolverName = "pinv",
    ridge: float = 0.0,
    pin_ends: bool = False,
    rho: RhoName = "even",
    robust: bool = False,
) -> Fit:
    """Fits a curve to points by least squares (F. Chen, arXiv 2312.16502).

    By default it is the curve with the fewest control points that follows the points: a cubic Bezier
    curve or a cubic B-spline, as ``lariat fit`` and the chain choose it. A curve follows the points
    if 95 % of them are within an eighth of the rope's width, at most 2 px, and all of them within
    half a width.

    For many centerlines with the same number of points use a :class:`Fitter`, which computes its
    matrices once.

    Args:
        points: Rows of x and y along the curve, 2 to 256, evenly spaced by arc length unless
            ``rho`` is ``"measured"``; or a :class:`Curve` of a scene.
        control_points: Number of control points, 2 to 32 (a closed curve has as many coefficients,
            or one fewer). Without a basis they belong to a Bezier curve, as in the paper. The
            default with a basis is 9. ``"auto"`` uses the fewest that follow the points.
        basis: The family of open curves; ``"auto"`` chooses it, too.
        weights: Weight of each point: 0 for an unobserved one.
        closed: True if the first point follows the last: the curve is then a truncated Fourier
            series. The default is that of a ``Curve``, or False.
        width: Width of the rope, in the points' unit. The default is that of a ``Curve``; without
            one, 95 % of the points must be within 2 px and all within 8.
        max_control_points: Maximum number for ``control_points="auto"``.
        degree: Degree of a B-spline's pieces.
        knots: Placement of the knots, where a B-spline's pieces meet: at equal steps, or depending
            on the points.
        solver: All three give the same control points. They differ in cost and in the number of
            control points for which they are reliable.
        ridge: Penalty on second differences of the control points, for stability with many of them.
        pin_ends: Makes the curve begin and end exactly at the first and the last point.
        rho: ``"measured"`` for points that are not evenly spaced.
        robust: Gives less weight to points far from the curve.

    Raises:
        ValueError: settings or points are invalid; the message names the nearest valid ones.
    """
    hidden = None
    if isinstance(points, Curve):
        closed = points.closed if closed is None else closed
        width = points.width_px if width is None else width
        hidden = points.hidden
        points = points.points
    points = np.asarray(points, dtype=np.float64)
    fitter = Fitter(
        len(points) if points.ndim else 0,
        control_points,
        basis,
        closed=bool(closed),
        max_control_points=max_control_points,
        degree=degree,
        knots=knots,
        solver=solver,
        ridge=ridge,
        pin_ends=pin_ends,
        rho=rho,
        weighted=weights is not None,
        robust=robust,
    )
    return fitter.fit(points, weights, width=width, hidden=hidden)
