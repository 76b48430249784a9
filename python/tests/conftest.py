"""Pictures with ropes in them, drawn by the tests."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Image = NDArray[np.uint8]


def rope_through(points: NDArray[Any], *, size: tuple[int, int] = (320, 240), width: float = 9.0) -> Image:
    """A dark blue rope along a polyline, on a light table, as RGB."""
    columns, rows = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    pixels = np.stack([columns, rows], axis=-1).astype(float)
    nearest = np.full(pixels.shape[:2], np.inf)
    for a, b in zip(points[:-1], points[1:]):
        along = np.clip(((pixels - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(pixels - a - along[..., None] * (b - a), axis=-1))
    share = np.clip(width / 2.0 + 0.5 - nearest, 0.0, 1.0)[..., None]
    image = (1.0 - share) * np.array([210.0, 205.0, 200.0]) + share * np.array([30.0, 40.0, 120.0])
    return np.ascontiguousarray(np.rint(image).astype(np.uint8))


def wave(count: int = 60) -> NDArray[Any]:
    """A wave from left to right."""
    t = np.linspace(0.0, 1.0, count)
    return np.stack([40.0 + 240.0 * t, 120.0 + 50.0 * np.sin(5.0 * t)], axis=-1)


@pytest.fixture(scope="session")
def image() -> Image:
    return rope_through(wave())
