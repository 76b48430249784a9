"""Curves as SVG, for notebooks."""

from __future__ import annotations

from html import escape
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from lariat._native import Absent, Lost, Stale

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lariat._native import Curve, Fit, Frame, Rope, Scene, Shape

    Points = NDArray[Any]

# One per rope, distinguishable for color-blind readers (Okabe and Ito 2008).
COLORS = ["#E69F00", "#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#D55E00"]
# Longer side of a drawing on the page, px.
SIDE = 420.0


def scene(seen: Scene) -> str:
    """The ropes of an image, their crossings, and the notice."""
    width, height = seen.size
    drawing = [centerline(curve) for curve in seen.curves]
    for crossing in seen.crossings:
        x, y = crossing.at
        drawing.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="none" stroke="#888" {THIN}/>')
    doubt = f"<br>{escape(str(seen.notice))}" if seen.notice else ""
    return svg(drawing, 0.0, 0.0, width, height) + f"<div>{escape(repr(seen))}{doubt}</div>"


def curve(seen: Curve) -> str:
    """The centerline of one rope."""
    return svg([centerline(seen)], *around(seen.points)) + f"<div>{escape(repr(seen))}</div>"


def fit(fitted: Fit) -> str:
    """A curve with its control points."""
    line = fitted.point_at(np.linspace(0.0, 1.0, 200))
    # The coefficients of a series are not positions.
    points = fitted.control_points[:0] if fitted.closed else fitted.control_points
    return (
        svg([polygon(points), path(line, COLORS[0])], *around(np.vstack([line, points])))
        + f"<div>{escape(repr(fitted))}</div>"
    )


def shape(seen: Shape) -> str:
    """A rope's curve with its control points."""
    return curve_of(seen) + f"<div>{escape(repr(seen))}</div>"


def rope(seen: Rope) -> str:
    """A rope of a frame; only its control points if it has no curve."""
    try:
        drawing = curve_of(seen.shape)
    except ValueError:
        points = seen.control_points
        drawing = svg([polygon(points)], *around(points))
    return drawing + f"<div>{escape(repr(seen))}</div>"


def frame(seen: Frame) -> str:
    """All ropes of a frame as in its image; lost ones are dashed."""
    drawing, outlines = [], []
    for known in seen.ropes(max_age=inf):
        if isinstance(known, Absent):
            continue
        lost = isinstance(known, (Lost, Stale))
        was = known.as_it_was if isinstance(known, (Lost, Stale)) else known.rope
        try:
            line = was.shape.points(200)
        except ValueError:
            continue
        line = np.vstack([line, line[:1]]) if was.closed else line
        drawing.append(path(line, COLORS[was.track.number % len(COLORS)], dashed=lost))
        outlines.append(line)
    width, height = seen.size
    if seen.unit == "px" and width > 0:
        corners = (0.0, 0.0, float(width), float(height))
    else:
        corners = around(np.vstack(outlines) if outlines else np.zeros((0, 2)))
    return svg(drawing, *corners) + f"<div>{escape(repr(seen))}</div>"


def curve_of(seen: Shape) -> str:
    """A curve with its control points, which are omitted if it is closed."""
    line = seen.points(200)
    points = seen.control_points[:0] if seen.closed else seen.control_points
    return svg([polygon(points), path(line, COLORS[0])], *around(np.vstack([line, points])))


THIN = 'vector-effect="non-scaling-stroke" stroke-width="1"'


def centerline(seen: Curve) -> str:
    """A rope's points, dashed if it is lost, with a dot at its first end."""
    color = COLORS[seen.track % len(COLORS)]
    points = np.vstack([seen.points, seen.points[:1]]) if seen.closed else seen.points
    return path(points, color, dashed=seen.status == "lost")


def path(points: Points, color: str, *, dashed: bool = False) -> str:
    """A line through points, with a dot at its start."""
    if len(points) == 0 or not np.all(np.isfinite(points)):
        return ""
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    dashes = ' stroke-dasharray="6 4"' if dashed else ""
    x, y = points[0]
    return (
        f'<polyline points="{corners}" fill="none" stroke="{color}" stroke-width="2.5"{dashes} '
        'stroke-linejoin="round" vector-effect="non-scaling-stroke"/>'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{color}"/>'
    )


def polygon(points: Points) -> str:
    """Control points, joined by lines."""
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    rings = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="none" stroke="#888" {THIN}/>' for x, y in points)
    return f'<polyline points="{corners}" fill="none" stroke="#888" {THIN}/>{rings}'


def around(points: Points) -> tuple[float, float, float, float]:
    """x, y, width and height of a box around points."""
    finite = points[np.isfinite(points).all(axis=1)] if len(points) else points
    if len(finite) == 0:
        return 0.0, 0.0, 1.0, 1.0
    low, high = finite.min(axis=0), finite.max(axis=0)
    margin = 0.05 * float((high - low).max()) + 8.0
    x, y = (float(c) for c in low - margin)
    width, height = (float(c) for c in high - low + 2.0 * margin)
    return x, y, width, height


def svg(parts: list[str], x: float, y: float, width: float, height: float) -> str:
    """The parts in one SVG image."""
    scale = SIDE / max(width, height, 1.0)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{x:.1f} {y:.1f} {width:.1f} {height:.1f}" '
        f'width="{scale * width:.0f}" height="{scale * height:.0f}" style="border:1px solid #8884">{"".join(parts)}</svg>'
    )
