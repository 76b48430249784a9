"""One picture, one list of points: what needs no memory from one call to the next."""

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
    """The ropes in a picture.

    For the frames of a film take a :class:`Tracer`: it knows each rope again, and is many times faster.

    Args:
        image: ``uint8`` of shape (height, width) for gray, (height, width, 3) for RGB. Rows may lie apart, as those of
            a part of a larger picture do; only an array whose pixels are not side by side is copied.
        mask: What is rope. ``"auto"`` takes what differs from the table; ``"network"`` asks a small neural network, for ropes on
            any ground; a colour range or several, as :func:`pick` proposes them; or a picture of the same size, ``bool``, or
            ``uint8``, the higher the likelier rope. Numbers of instances, and ropes darker than the rest, are understood, with a
            warning.
        network: A file of weights trained on pictures of your own, for ``mask="network"``.
        method: How the mask becomes a centerline.
        points: Points of each centerline, at equal steps of arc length: 2 to 256.
        ropes: The most ropes reported, the surest and longest.
        start: A rope's first point is the end nearest to this position, in px. If not given, to the top left.
        at: The ropes that are meant, each by a position on it, in px. If not given, all are reported.
        roi: The part of the image that is read: x, y, width, height in px.
        pixel_format: ``"bgr"`` for what OpenCV reads; if not given, ``"gray"`` or ``"rgb"`` by the shape.

    Raises:
        ValueError: a setting or a shape that cannot be, with what can.
        TypeError: an image that is no array of ``uint8``.
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
    """The curve nearest to points in the least-squares sense (F. Chen, arXiv 2312.16502).

    Without a setting it is the curve of the fewest control points that lies on the points, as ``lariat fit`` and the chain
    choose it: a cubic Bezier curve or a cubic B-spline. It lies on them if 95 % of them are within an eighth of the rope's
    width, and 2 px at most, and all of them within half a width.

    For centerline after centerline of as many points take a :class:`Fitter`, which computes its algebra once.

    Args:
        points: Rows of x and y along the curve, 2 to 256, evenly spaced by arc length unless that is measured; or a
            :class:`Curve` of a scene.
        control_points: How many, 2 to 32 (a closed curve has as many coefficients, or one fewer). Without a basis they are a
            Bezier curve's, the paper's; a basis without them has 9. ``"auto"`` takes as few as lie on the points.
        basis: The family of open curves; ``"auto"`` chooses it, too.
        weights: How much each point counts: 0 for one that is not seen.
        closed: Whether the last point is followed by the first: then the curve is a truncated Fourier series. If not
            given, what a ``Curve`` says, and no.
        width: The rope's, in the points' unit. If not given, what a ``Curve`` says; without one, 95 % of the points are to be
            within 2 px and all within 8.
        max_control_points: The most that ``control_points="auto"`` chooses.
        degree: Degree of a B-spline's pieces.
        knots: Where a B-spline's pieces meet: evenly, or where the points are.
        solver: All three give the same control points; they differ in cost and in the number of control points
            that they can be trusted with.
        ridge: How strongly second differences of the control points are held down: tames many of them.
        pin_ends: Whether the curve begins and ends exactly at the first and the last point.
        rho: ``"measured"`` for points that are not evenly spaced.
        robust: Give points far off the curve less weight.

    Raises:
        ValueError: settings or points that cannot be, with the nearest that can.
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
