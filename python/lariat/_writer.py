"""Writers for frames of your own camera and for a network's masks: arrays in shared memory, with
one copy or none."""

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
        """The slot itself: whatever is written into it is sent. It still holds an earlier image.
        Valid only inside the ``with``."""
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
    """The slot of a frame, to be filled by your camera code::

        with frames.loan(480, 640, "rgb8") as slot:
            camera.read_into(slot.array)
            slot.exposed_ns = camera.time_ns()  # of time.monotonic_ns(); default: when the slot was borrowed

    It is sent at the end of the ``with``, unless an exception ends it.
    """

    exposed_ns: int | None = None
    sequence: int | None = None

    def _send(self, slot: _native.Slot) -> None:
        slot.send_frame(self.exposed_ns, self.sequence)


class MaskSlot(_Slot):
    """The slot of a frame's mask: ``uint8``, higher where rope is more likely. It is sent at the
    end of the ``with``."""

    def _send(self, slot: _native.Slot) -> None:
        slot.send_mask()


class DepthSlot(_Slot):
    """The slot of a frame's depth image: ``uint16``, 0 where unknown. It is sent at the end of
    the ``with``."""

    def _send(self, slot: _native.Slot) -> None:
        slot.send_depth()


class FrameWriter(_native.Writer):
    """Writes the frames of a chain that was started with ``lariat run --source external``, from any
    camera, simulator or player.

    ::

        with lariat.Writer("frames") as frames:
            while True:
                frames.write(camera.read(), "bgr8")

    Frames are numbered, timed and counted like those of lariat's own cameras. The chain may be
    started before or after the writer, and restarted. A rig has one writer at a time.
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
        """Sends an image: copies it once, into shared memory, and wakes the chain. Accepts any
        strides.

        Args:
            image: ``uint8`` of shape (height, width) for gray, (height, width, 3) for colors,
                (height, width, 2) for YUYV and UYVY, or (height · 3/2, width) for NV12.
            pixel_format: ``"gray8"``, ``"rgb8"``, ``"bgr8"`` (OpenCV's), ``"yuyv"``, ``"uyvy"``,
                ``"nv12"`` or another one of lariat's. The default is gray for two axes, and
                ``rgb8`` for three channels.
            exposed_ns: Exposure time by ``time.monotonic_ns()``, later than that of the previous
                image. The default is now.
            sequence: The camera's own number of the image, higher than the previous one. Each
                number left out counts as a frame lost at the source. The default is the next
                number.

        Raises:
            TypeError, ValueError: the image, time or number is invalid. The image is then neither
                sent nor counted.
            OSError: ``/dev/shm`` lacks the space, or the transport failed.
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
        """Borrows the slot of the next frame, to be filled in a ``with`` without any copy. Only
        one slot can be borrowed at a time."""
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
        """Sends a frame's mask: the likelihood that each of its pixels is rope.

        Args:
            mask: An array of the frame's size, (height, width): ``bool``; probabilities as floats
                from 0 to 1; or ``uint8``, higher where rope is more likely.
            frame: The frame that the mask was computed from.

        Raises:
            TypeError, ValueError: the mask is invalid. It is then not sent, and its frame counts as
                skipped.
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
        """Borrows the slot of the frame's mask, to be filled in a ``with`` without any copy."""
        return MaskSlot(self.loan_mask(frame))


class DepthWriter(_native.Writer):
    """Writes the depth images of a chain with a depth camera (``lariat run --depth FILE``), one per
    frame.

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
            depth: ``uint16`` of the depth camera's own size, (height, width), in the unit of its
                calibration (mm if it names none); 0 where unknown.
            frame: The frame at whose time it was taken.

        Raises:
            TypeError, ValueError: the image is invalid. It is then not sent, and its frame is
                processed without depth.
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
        """Borrows the slot of the frame's depth image, to be filled in a ``with`` without any
        copy."""
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
    """Opens the writer of a rig's ``"frames"``, ``"masks"`` or ``"depth"`` images, for a chain that
    expects them.

    Args:
        channel: ``"frames"`` for ``lariat run --source external``, ``"masks"`` for
            ``mask = "external"``, ``"depth"`` for ``lariat run --depth FILE``.
        rig: Name of the rig, as given to the chain (``--rig NAME``).
        lossless: True if the writer waits for slow readers, so that nothing is left out
            (``lariat run --lossless``). The default follows the running chain; without one, the
            writer does not wait.

    Raises:
        ValueError: the name is invalid.
        OSError: the rig already has a writer, there is no shared memory, or the chain is of another
            release or another user.
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
    """The array in the shape of its format, and the format's name."""
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
