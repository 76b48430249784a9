"""A control loop's reader: Rust's, and how it waits in asyncio."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from lariat import _native
from lariat._native import Frame


class Reader(_native.Reader):
    """Reads the shapes of a rig's ropes, for a control loop.

    ::

        with lariat.Reader() as reader:
            for frame in reader:
                match frame.only_rope(max_age=0.05):
                    case lariat.Fresh(rope):
                        robot.steer(rope.shape.point_at(0.5))
                    case seen:  # Partial, Unsure, Lost, Stale, Absent
                        robot.hold(why=str(seen))

    It may be opened before the chain runs, and goes on when the chain is restarted: until an image comes, what it has
    gets older. Iterating it waits for the next image, at most for ``timeout``: then it gives the same frame as before,
    which is not new, so that a loop never stands still without knowing. Ctrl-C ends a wait, and other threads run
    during it. ``async for`` waits likewise.

    Up to 23 loops share a rig, beside sink; one that is slow, stopped or killed disturbs neither the chain nor the others. It is
    used by one thread at a time; each thread of several opens its own. What was read belongs to nobody: frames, ropes
    and their arrays can be kept for as long as you like, and go to any thread.

    Args:
        rig: Which camera chain: what it was started with (``--rig NAME``).
        timeout: How long to wait for the next image, s.
        accept_coarse: A curve that does not lie on the rope is ``Fresh`` all the same: for who compares descriptors, and needs no
            point of the curve to be on the rope. Otherwise such a rope is ``Unsure``.
        min_confidence: The least confidence, 0 to 1, of a rope that is ``Fresh`` or ``Partial``; a rope with less is ``Unsure``.
            Below 0.5 a curve is more likely wrong than right; 0 accepts any.
        space: Whether ropes are read in space, too (``rope.in_space``): of a chain with a depth camera.

    Raises:
        ValueError: no such name, or a confidence outside 0 to 1.
        OSError: no shared memory, a chain of another release or of another user, or 24 readers already.
    """

    async def wait_async(self, timeout: float | None = None) -> Frame:
        """As ``wait``, for asyncio: other tasks run meanwhile."""
        loop = asyncio.get_running_loop()
        deadline = loop.time() + (self.timeout if timeout is None else timeout)
        while True:
            frame = self.latest()
            left = deadline - loop.time()
            if frame.is_new or left <= 0.0:
                return frame
            longest = self.before_poll()
            await _readable(self.fileno(), left if longest is None else min(left, longest))

    async def __aiter__(self) -> AsyncIterator[Frame]:
        while True:
            yield await self.wait_async()


async def _readable(descriptor: int, timeout: float) -> None:
    """Sleeps until the descriptor is readable, or the time is over."""
    loop = asyncio.get_running_loop()
    awake = loop.create_future()

    def wake() -> None:
        if not awake.done():
            awake.set_result(None)

    loop.add_reader(descriptor, wake)
    timer = loop.call_later(timeout, wake)
    try:
        await awake
    finally:
        timer.cancel()
        loop.remove_reader(descriptor)
