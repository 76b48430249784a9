"""Frames of a camera of one's own, and a network's masks: arrays into shared memory, by one copy or none."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from lariat import _native
from lariat._native import Image

if TYPE_CHECKING:
    from typing_extensions import Self


class _Slot:
    """A slot of shared memory, inside its ``with``."""

    def __init__(self, slot: _native.Slot) -> None:
        self._slot: _native.Slot | None = slot
        self._array: NDArray[Any] | None = slot.array()

    @property
    def array(self) -> NDArray[Any]:
        """The slot itself: what is written into it is sent. It holds an earlier image. Good inside the ``with`` only."""
        if self._array is None:
            raise ValueError("this slot was sent, or given back: borrow another one")
        return self._array

    def __enter__(self) -> Self:
        return self

    def _send(self, slot: _native.Slot) -> None:
        raise NotImplementedError

    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None:
        slot, self._slot, self._array = self._slot, None, None
        if error is None and slot is not None:
            self._send(slot)


class FrameSlot(_Slot):
    """The slot of a frame, to be filled by whoever takes the picture::

        with frames.loan(480, 640, "rgb8") as slot:
            camera.read_into(slot.array)
            slot.exposed_ns = camera.time_ns()  # of time.monotonic_ns(); if not said, when the slot was borrowed

    It is sent at the end of the ``with``, unless that ends by an exception.
    """

    exposed_ns: int | None = None
    sequence: int | None = None

    def _send(self, slot: _native.Slot) -> None:
        slot.send_frame(self.exposed_ns, self.sequence)


class MaskSlot(_Slot):
    """The slot of a frame's mask: ``uint8``, the higher the likelier rope. It is sent at the end of the ``with``."""

    def _send(self, slot: _native.Slot) -> None:
        slot.send_mask()


class DepthSlot(_Slot):
    """The slot of a frame's depth image: ``uint16``, 0 where nothing is known. It is sent at the end of the ``with``."""

    def _send(self, slot: _native.Slot) -> None:
        slot.send_depth()


class FrameWriter(_native.Writer):
    """Writes the frames of a chain that was started with ``lariat run --source external``: of any camera, simulator, player.

    ::

        with lariat.Writer("frames") as frames:
            while True:
                frames.write(camera.read(), "bgr8")

    Frames are numbered, timed and counted as those of lariat's own cameras. The chain may be started before or after, and
    again; a rig has one writer at a time.
    """

    def __new__(cls, rig: str = "default", *, lossless: bool | None = None) -> Self:
        return super().__new__(cls, "frames", rig, lossless=lossless)

    def write(
        self,
        image: NDArray[Any],
        pixel_format: str | None = None,
        *,
        exposed_ns: int | None = None,
        sequence: int | None = None,
    ) -> None:
        """Sends an image: copies it once, into shared memory, and wakes the chain. Any strides will do.

        Args:
            image: (height, width) for gray, (height, width, 3) for colours, (height, width, 2) for YUYV and UYVY,
                (height · 3/2, width) for NV12; ``uint8``.
            pixel_format: ``"gray8"``, ``"rgb8"``, ``"bgr8"`` (OpenCV's), ``"yuyv"``, ``"uyvy"``, ``"nv12"`` or another of
                lariat's. If not said: gray by two axes, ``rgb8`` by three channels.
            exposed_ns: When it was taken, by ``time.monotonic_ns()``; if not said, now. Later than the one before.
            sequence: The camera's own number for it, higher than the one before: each that was left out counts as a frame
                lost at the source. If not said, the next one.

        Raises:
            TypeError, ValueError: no such image, time or number. It is then not sent, and not counted.
            OSError: no room in ``/dev/shm``, or the transport failed.
        """
        array, name = _checked(image, pixel_format)
        height = array.shape[0] * 2 // 3 if name == "nv12" else array.shape[0]
        slot = self.loan(height, array.shape[1], name, exposed_ns=exposed_ns, sequence=sequence)
        with slot:
            if slot.array.shape != array.shape or slot.array.dtype != array.dtype:
                raise ValueError(
                    f"an image of {array.shape[1]}×{height} in '{name}' is an array of {slot.array.dtype} of the shape "
                    f"{slot.array.shape}, and this one is of {array.dtype} and {array.shape}"
                )
            np.copyto(slot.array, array)

    def loan(
        self,
        height: int,
        width: int,
        pixel_format: str,
        *,
        exposed_ns: int | None = None,
        sequence: int | None = None,
    ) -> FrameSlot:
        """The slot of the next frame, to be filled in a ``with``: then nothing is copied. One at a time."""
        for name, side in [("height", height), ("width", width)]:
            if not 1 <= side <= 8192:
                raise ValueError(f"Invalid {name} {side}: use 1 to 8192 pixels")
        slot = FrameSlot(self.loan_frame(height, width, pixel_format))
        slot.exposed_ns, slot.sequence = exposed_ns, sequence
        return slot


class MaskWriter(_native.Writer):
    """Writes the masks of a chain that has ``mask = "external"``, one for each frame.

    ::

        with lariat.Frames() as frames, lariat.Writer("masks") as masks:
            for frame in frames:
                masks.write(network(frame.array), frame)
    """

    def __new__(cls, rig: str = "default", *, lossless: bool | None = None) -> Self:
        return super().__new__(cls, "masks", rig, lossless=lossless)

    def write(self, mask: NDArray[Any], frame: Image) -> None:
        """Sends a frame's mask: how likely each of its pixels is rope.

        Args:
            mask: Of the frame's size, (height, width): ``bool``; or probabilities, as floats from 0 to 1; or ``uint8``,
                the higher the likelier rope.
            frame: The frame that it was made of.

        Raises:
            TypeError, ValueError: no such mask. It is then not sent, and its frame counts as skipped.
        """
        array = _array(mask, "mask")
        width, height = frame.size
        if array.ndim == 3 and array.shape[2] == 1:
            array = array[:, :, 0]
        if array.shape != (height, width):
            raise ValueError(
                f"the mask has the shape {array.shape}, and its frame {(height, width)}: scale it to the frame's size "
                f"(cv2.resize(mask, {(width, height)}))"
            )
        with self.loan(frame) as slot:
            _fill(slot.array, array)

    def loan(self, frame: Image) -> MaskSlot:
        """The slot of the frame's mask, to be filled in a ``with``: then nothing is copied."""
        return MaskSlot(self.loan_mask(frame))


class DepthWriter(_native.Writer):
    """Writes the depth images of a chain that has a depth camera (``lariat run --depth FILE``), one for each frame.

    ::

        with lariat.Frames() as frames, lariat.Writer("depth") as depths:
            for frame in frames:
                depths.write(nearest_in_time(frame), frame)
    """

    def __new__(cls, rig: str = "default", *, lossless: bool | None = None) -> Self:
        return super().__new__(cls, "depth", rig, lossless=lossless)

    def write(self, depth: NDArray[Any], frame: Image) -> None:
        """Sends a frame's depth image.

        Args:
            depth: Of the depth camera's own size, (height, width): ``uint16``, in the unit that its calibration says (mm if it
                says none), 0 where nothing is known.
            frame: The frame beside which it was taken.

        Raises:
            TypeError, ValueError: no such image. It is then not sent, and its frame is described without.
        """
        array = _array(depth, "depth image")
        if array.ndim != 2 or array.dtype != np.uint16:
            raise ValueError(
                f"a depth image is an array of uint16 with two axes, and this one is of {array.dtype} and the shape "
                f"{array.shape}: of metres as floats, np.nan_to_num(1000 * depth).astype(np.uint16) is one in mm"
            )
        with self.loan(frame, *array.shape) as slot:
            np.copyto(slot.array, array)

    def loan(self, frame: Image, height: int, width: int) -> DepthSlot:
        """The slot of the frame's depth image, to be filled in a ``with``: then nothing is copied."""
        return DepthSlot(self.loan_depth(frame, height, width))


@overload
def Writer(channel: Literal["frames"], rig: str = "default", *, lossless: bool | None = None) -> FrameWriter: ...
@overload
def Writer(channel: Literal["masks"], rig: str = "default", *, lossless: bool | None = None) -> MaskWriter: ...
@overload
def Writer(channel: Literal["depth"], rig: str = "default", *, lossless: bool | None = None) -> DepthWriter: ...
def Writer(
    channel: str, rig: str = "default", *, lossless: bool | None = None
) -> FrameWriter | MaskWriter | DepthWriter:
    """Becomes the writer of a rig's ``"frames"``, ``"masks"`` or ``"depth"`` images, in a chain that leaves them to you.

    Args:
        channel: ``"frames"`` for ``lariat run --source external``, ``"masks"`` for ``mask = "external"``, ``"depth"`` for
            ``lariat run --depth FILE``.
        rig: Which camera chain: what it was started with (``--rig NAME``).
        lossless: Whether it waits for slow readers, so that nothing is left out (``lariat run --lossless``). If not said: as
            the chain does that runs; where none does yet, it does not wait.

    Raises:
        ValueError: no such name.
        OSError: the rig has a writer, no shared memory, a chain of another release or of another user.
    """
    writers: dict[str, type[FrameWriter | MaskWriter | DepthWriter]] = {
        "frames": FrameWriter,
        "masks": MaskWriter,
        "depth": DepthWriter,
    }
    if channel not in writers:
        raise ValueError(f"Invalid channel {channel!r}: use 'frames', 'masks' or 'depth'")
    return writers[channel](rig, lossless=lossless)


def _fill(slot: NDArray[np.uint8], mask: NDArray[Any]) -> None:
    """Writes a mask as bytes."""
    if mask.dtype == np.bool_:
        np.multiply(mask, np.uint8(255), out=slot)
    elif mask.dtype == np.uint8:
        if mask.max() == 1:
            raise ValueError(
                "the mask has no value above 1, and in uint8 surely rope is 255: give it as mask.astype(bool)"
            )
        np.copyto(slot, mask)
    elif np.issubdtype(mask.dtype, np.floating):
        low, high = mask.min(), mask.max()
        if not (low >= 0.0 and high <= 1.0):
            raise ValueError(
                f"the mask's values are from {low:g} to {high:g}, and a probability is from 0 to 1: put the network's "
                "output through a sigmoid"
            )
        np.rint(mask * mask.dtype.type(255.0), out=slot, casting="unsafe")
    else:
        raise TypeError(f"a mask is of bool, uint8 or floats, and this one is of {mask.dtype}: of labels, say mask == label")


def _array(image: object, what: str) -> NDArray[Any]:
    if isinstance(image, np.ndarray):
        return image
    raise TypeError(
        f"the {what} is of type {type(image).__name__}, and a NumPy array is needed: say numpy.asarray({what}), of a tensor "
        f"{what}.cpu().numpy()"
        if image is not None
        else f"the {what} is None: the camera gave no image"
    )


def _checked(image: object, pixel_format: str | None) -> tuple[NDArray[Any], str]:
    """The array as a format has it, and the format's name."""
    array = _array(image, "image")
    if array.dtype not in (np.uint8, np.uint16):
        raise TypeError(
            f"an image is an array of uint8, and this one is of {array.dtype}: scale it to 0 to 255 and say "
            ".astype(numpy.uint8)"
        )
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[:, :, 0]
    if array.ndim not in (2, 3) or 0 in array.shape:
        raise ValueError(f"an image has the shape (height, width) or (height, width, channels), and this one {array.shape}")
    if pixel_format is not None:
        return array, pixel_format.lower()
    usual = {(2, 1, 1): "gray8", (2, 1, 2): "gray16", (3, 3, 1): "rgb8"}
    channels = array.shape[2] if array.ndim == 3 else 1
    name = usual.get((array.ndim, channels, array.itemsize))
    if name is None:
        raise ValueError(f"what pixels an array of {array.dtype} of {channels} channels has is not known: say its pixel_format")
    return array, name
