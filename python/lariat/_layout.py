"""Layout of a message of descriptors, as in docs/messages.md, as NumPy types."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_TRACE = np.dtype(
    [
        ("sequence", "u8"),
        ("captured", "u8"),
        ("extracted", "u8"),
        ("fitted", "u8"),
        ("bridged", "u8"),
        ("exposed_ns", "u8"),
        ("captured_ns", "u8"),
        ("extract_started_ns", "u8"),
        ("extracted_ns", "u8"),
        ("fit_started_ns", "u8"),
        ("fitted_ns", "u8"),
        ("settings", "u4"),
        ("restarts", "u4"),
    ]
)

_DESCRIPTOR = np.dtype(
    [
        ("track", "u4"),
        ("status", "u4"),
        ("basis", "u4"),
        ("degree", "u4"),
        ("count", "u4"),
        ("samples", "u4"),
        ("closed", "u4"),
        ("border", "u4"),
        ("rms", "f8"),
        ("max", "f8"),
        ("residual_variance", "f8"),
        ("condition", "f8"),
        ("length", "f8"),
        ("width", "f8"),
        ("age_ns", "u8"),
        ("hidden", "u4"),
        ("filtered", "u4"),
        ("fit", "u4"),
        ("confidence", "f4"),
        ("control_points", "f8", (32, 2)),
        ("weights", "f8", (32,)),
        ("covariances", "f8", (32, 3)),
        ("velocities", "f8", (32, 2)),
        ("knots", "f8", (32,)),
    ]
)

_CENTERLINE = np.dtype(
    [
        ("count", "u4"),
        ("closed", "u4"),
        ("hidden", "u4", (8,)),
        ("points", "f4", (256, 2)),
        ("widths", "f4", (256,)),
    ]
)

MESSAGE = np.dtype(
    [
        ("trace", _TRACE),
        ("width", "u4"),
        ("height", "u4"),
        ("count", "u4"),
        ("unit", "u4"),
        ("curves", _DESCRIPTOR, (24,)),
        ("centerlines", _CENTERLINE, (24,)),
    ]
)
"""The type of ``Frame.message``: ``lariat.Descriptors.v9``."""


def record(message: NDArray[np.uint8]) -> Any:
    """A message from its bytes; ``None`` if there are none."""
    return message.view(MESSAGE)[0] if len(message) else None
