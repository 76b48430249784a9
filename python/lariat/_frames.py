"""The frames of a rig, for a mask network or a display: Rust's."""

from __future__ import annotations

from lariat import _native


class Frames(_native.Frames):
    """Reads the frames of a rig: the newest, or each one of a ``--lossless`` chain, which waits for it.

    ::

        for frame in lariat.Frames():
            show(frame.array)

    Iterating it waits for the next image for as long as it takes; Ctrl-C ends a wait, and other threads run during it. Each
    frame's array is a copy, which can be kept. It may be opened before the chain runs, and outlives it. Four readers, the
    chain's own extract and a recorder among them, share a rig's frames.

    Args:
        rig: Which camera chain: what it was started with (``--rig NAME``).
        lossless: Whether the chain is started with ``--lossless``. If not said: as the chain is that runs.

    Raises:
        ValueError: no such name.
        OSError: no shared memory, a chain of another release or of another user, or four readers already.
    """
