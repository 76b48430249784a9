"""A control loop's reader, implemented in Rust, with waiting for asyncio."""

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

    A reader may be opened before the chain runs, and survives its restarts. Until the next
    image arrives, the latest result gets older. Iteration waits for the next image, at most
    ``timeout``. After that it gives the same frame again, which is not new, so a loop is never
    blocked without notice. Ctrl-C ends a wait, and other threads run during it. ``async for`` waits
    in the same way.

    Up to 23 loops share a rig, in addition to sink; a slow, stopped or killed one disturbs neither
    the chain nor the others. A reader is used by one thread at a time; several threads open one
    each. Frames, ropes and their arrays can be kept without limit and used in any thread.

    Args:
        rig: Name of the rig, as given to the chain (``--rig NAME``).
        timeout: Maximum wait for the next image, s.
        accept_coarse: Makes a rope ``Fresh`` even if its curve does not follow it. Use it in loops
            that only compare descriptors and do not need the curve to be on the rope. By default
            such a rope is ``Unsure``.
        min_confidence: Minimum confidence, 0 to 1, of a rope that is ``Fresh`` or ``Partial``; a
            rope below it is ``Unsure``. Below 0.5 a curve is more likely wrong than right; 0
            accepts any confidence.
        space: Also reads ropes in space (``rope.in_space``), from a chain with a depth camera.

    Raises:
        ValueError: the name is invalid, or the confidence is outside 0 to 1.
        OSError: there is no shared memory, the chain is of another release or another user, or the
            rig has 24 readers already.
    """

    async def wait_async(self, timeout: float | None = None) -> Frame:
        """The same as ``wait``, for asyncio: other tasks run meanwhile."""
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
    """Sleeps until the descriptor is readable or the timeout expires."""
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
