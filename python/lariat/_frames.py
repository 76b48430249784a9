"""Reader of a rig's frames, for a mask network or a display; implemented in Rust."""

from __future__ import annotations

from lariat import _native


class Frames(_native.Frames):
    """Reads the frames of a rig: the newest one, or every one of a ``--lossless`` chain, which
    waits for it.

    ::

        for frame in lariat.Frames():
            show(frame.array)

    Iteration waits for the next image without limit. Ctrl-C ends a wait, and other threads run
    during it. Each frame's array is a copy that you can keep. The reader may be opened before the
    chain runs, and outlives the chain. Four readers share a rig's frames, including the chain's own
    extract and a recorder.

    Args:
        rig: Name of the rig, as given to the chain (``--rig NAME``).
        lossless: True if the chain is started with ``--lossless``. The default follows the running
            chain.

    Raises:
        ValueError: the name is invalid.
        OSError: there is no shared memory, the chain is of another release or another user, or the
            rig has four readers already.
    """
