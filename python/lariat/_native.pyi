"""Interface of the Rust half. See the documentation of each class."""

import os
from collections.abc import Sequence
from types import TracebackType
from typing import Any, ClassVar, Literal, NoReturn, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, disjoint_base

from lariat._names import (
    BasisName,
    FitName,
    HsvRange,
    KnotsName,
    MaskImage,
    MaskName,
    MethodName,
    Picture,
    PixelFormat,
    RhoName,
    SolverName,
    StatusName,
    UnitName,
)
from lariat._seen import Seen

__version__: str

__all__ = [
    "Absent",
    "Centerline",
    "Crossing",
    "Curve",
    "Fit",
    "Fitter",
    "Frame",
    "Frames",
    "Fresh",
    "Image",
    "Lost",
    "Notice",
    "Partial",
    "Reader",
    "Rope",
    "Scene",
    "Shape",
    "Slot",
    "SpaceShape",
    "Stale",
    "Trace",
    "Tracer",
    "Track",
    "Unsure",
    "Writer",
    "__version__",
    "pick",
    "take_short_slices",
]

def pick(
    image: Picture,
    at: tuple[float, float] | Sequence[tuple[float, float]] | None = None,
    *,
    pixel_format: PixelFormat | None = None,
) -> tuple[list[HsvRange], float]:
    """Proposes color ranges of the ropes in an image, for the setting `mask`. They cover all ropes
    that differ from the table, or only the ropes at one or several positions `at`, with one range
    for each color. Also returns how well the ranges separate rope from table. Below about 0.7,
    their mask has holes or includes parts of the table. Warns if tracing with that mask gives a
    doubtful result.
    """
def take_short_slices() -> None:
    """Requests short time slices for the calling thread, for a control loop without realtime priority.
    When a message wakes the thread, it need not wait until another program's slice ends. This needs
    no privilege. It requires Linux 6.12 and does nothing on older kernels. Threads that this thread
    starts later inherit the short slices.
    """
@final
class Tracer:
    """Traces images of one moving scene, and remembers it from one image to the next. Ropes keep their
    numbers and directions and are tracked, which costs a fraction of a full extraction.
    """
    def __new__(
        cls,
        *,
        mask: MaskName | HsvRange | Sequence[HsvRange] | None = None,
        mask_level: int | None = None,
        network: str | os.PathLike[str] | None = None,
        method: MethodName = "skeleton",
        points: int = 120,
        ropes: int = 24,
        min_confidence: float = 0.5,
        start: tuple[float, float] | None = None,
        at: Sequence[tuple[float, float]] = ...,
        keep_lost_s: float = 1.0,
        roi: tuple[int, int, int, int] | None = None,
    ) -> Self: ...
    def trace(
        self,
        image: Picture,
        *,
        mask: MaskImage | None = None,
        pixel_format: PixelFormat | None = None,
        at_ns: int | None = None,
    ) -> Scene:
        """Finds the ropes in the next image."""
    def reset(self) -> None:
        """Forgets the past, so that the next image is a new scene."""

@final
class Scene:
    """The ropes in one image."""
    @property
    def curves(self) -> list[Curve]:
        """The visible ropes, the longest first, then the lost ones."""
    @property
    def crossings(self) -> list[Crossing]:
        """Their crossings, at most 32."""
    @property
    def notice(self) -> Notice | None:
        """The most important probable fault of the result, if any."""
    @property
    def followed(self) -> bool:
        """True if the ropes were tracked from the previous image, so that only the area around them
        was read.
        """
    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image, px."""
    def _repr_html_(self) -> str: ...

@final
class Curve:
    """The centerline of one rope. Positions are in pixels, x right, y down, with (0, 0) at the center
    of the top left pixel.
    """
    @property
    def track(self) -> int:
        """Rope number, constant from image to image of a `Tracer`."""
    @property
    def status(self) -> StatusName:
        """Visibility of the rope: `"ok"`, `"partial"` or `"lost"`; `"doubtful"` if it may not be a
        rope.
        """
    @property
    def confidence(self) -> float:
        """Calibrated probability, 0 to 1, that this is a whole rope with its points in order."""
    @property
    def closed(self) -> bool:
        """True if the rope is closed. The last point is then one step before the first."""
    @property
    def leaves_image(self) -> tuple[bool, bool]:
        """True for each end, first and last, at which the rope leaves the image."""
    @property
    def points(self) -> NDArray[np.float32]:
        """Points at equal steps of arc length, an array of `float32` of shape (points, 2), px."""
    @property
    def widths_px(self) -> NDArray[np.float32]:
        """Width of the rope at each point, px."""
    @property
    def hidden(self) -> NDArray[np.bool_]:
        """True for each point that is covered or outside the image; its position is then interpolated."""
    @property
    def width_px(self) -> float:
        """Median of the widths, px."""
    @property
    def length_px(self) -> float:
        """Arc length from end to end (once around if closed), px."""
    @property
    def age(self) -> float:
        """Time since the rope was last visible, s; 0 unless it is lost."""
    @property
    def crossing_sequence(self) -> str:
        """The rope's crossings with itself, over (O) and under (U), from its first point on.
        `"O1 U2 O3 U1 O2 U3"` is an overhand knot.
        """
    @property
    def pulls_straight(self) -> bool | None:
        """True if the rope becomes straight when its ends are pulled apart; `None` if neither answer
        has a probability of 0.9.
        """
    def _repr_html_(self) -> str: ...

@final
class Crossing:
    """A crossing of a rope over another rope or itself."""
    @property
    def at(self) -> tuple[float, float]:
        """Position, [x, y] in px."""
    @property
    def over(self) -> int:
        """Index of the upper rope in the scene's curves."""
    @property
    def under(self) -> int:
        """Index of the lower rope in the scene's curves."""
    @property
    def over_rho(self) -> float:
        """Position on the upper rope as normalized arc length, 0 to 1."""
    @property
    def under_rho(self) -> float:
        """Position on the lower rope as normalized arc length, 0 to 1."""
    @property
    def confidence(self) -> float:
        """Confidence in which rope is on top, from 0 (a coin toss) to 1."""

@final
class Notice:
    """A reason why the automatic mask may be wrong for an image, and how to fix it; `str()` gives the
    text.
    """
    @property
    def name(self) -> str:
        """A short name for programs, such as `"checkered-table"`."""

@final
class Fitter:
    """Fits curves of one family to centerlines with a fixed number of points. Everything that does not
    depend on the points is computed once.
    """
    def __new__(
        cls,
        points: int = 120,
        control_points: int | Literal["auto"] | None = None,
        basis: BasisName | Literal["auto"] = "auto",
        *,
        closed: bool = False,
        max_control_points: int = 17,
        degree: int = 3,
        knots: KnotsName = "uniform",
        solver: SolverName = "pinv",
        ridge: float = 0.0,
        pin_ends: bool = False,
        rho: RhoName = "even",
        weighted: bool = False,
        robust: bool = False,
    ) -> Self: ...
    def fit(
        self,
        points: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        width: float | None = None,
        hidden: NDArray[np.bool_] | None = None,
    ) -> Fit:
        """Fits a curve to `points` by least squares. `width` is the rope's width, and `hidden` is True
        for each unobserved point. Both matter if the number of control points is chosen
        automatically. The curve is then within an eighth of the width, at most 2 px, of 95 % of the
        observed points. It is within half a width of all of them.
        """
    @property
    def matrix(self) -> NDArray[np.float64]:
        """The constant matrix P with s = P c: the Jacobian of the control points with respect to the
        points, of shape (control points, points). It is the same for x and y.
        """
    @property
    def points(self) -> int:
        """Number of points of a centerline."""
    @property
    def basis(self) -> BasisName:
        """The family of curves, such as `"bezier"`."""
    def forget(self) -> None:
        """Forgets the state for the next fit (the weights of a rational curve). Call it before the
        centerline of another rope.
        """

@final
class Fit:
    """A curve fitted to points, in their unit: f(rho), with rho from 0 at the first point to 1 at the
    last.
    """
    @property
    def basis(self) -> BasisName:
        """The family of curves: `"bezier"`, `"bspline"`, `"rational"`, `"fourier"`, `"points"` or
        `"mass"`.
        """
    @property
    def degree(self) -> int:
        """Polynomial degree of the curve (3 for a cubic B-spline); number of harmonics for a Fourier
        series.
        """
    @property
    def closed(self) -> bool:
        """True if the curve is closed."""
    @property
    def control_points(self) -> NDArray[np.float64]:
        """The control points, of shape (control points, 2)."""
    @property
    def weights(self) -> NDArray[np.float64] | None:
        """Weights of the control points; `None` unless the curve is rational."""
    @property
    def knots(self) -> NDArray[np.float64] | None:
        """The clamped knots; `None` unless the curve is a B-spline."""
    @property
    def rms(self) -> float:
        """Root mean square distance of the points from the curve at their rho."""
    @property
    def max(self) -> float:
        """Maximum distance of a point from the curve at its rho."""
    @property
    def residual_variance(self) -> float:
        """Variance of one coordinate's residual; 0 if there are only as many points as control points."""
    @property
    def condition(self) -> float:
        """Condition number of the regression: the largest amplification of a relative error from
        points to control points.
        """
    @property
    def noise_gain(self) -> float:
        """Standard deviation of the least certain control point's coordinate, for unit noise in the
        points.
        """
    def covariance(self) -> NDArray[np.float64]:
        """Joint covariance of all control points, for the vector x0, y0, x1, y1, …: the residual
        variance times `(BᵀB)⁻¹ ⊗ I₂`.
        """
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1. For n values of rho, an array of shape (n, 2)."""
    def derivative_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The derivative with respect to rho: f′(rho)."""
    def tangent_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The unit tangent; NaN if the curve is a point."""
    @overload
    def curvature_at(self, rho: float) -> float:
        """The curvature, one over the radius; NaN where the derivative vanishes."""
    @overload
    def curvature_at(self, rho: ArrayLike) -> float | NDArray[np.float64]:
        """The curvature, one over the radius; NaN where the derivative vanishes."""
    def jacobian_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The Jacobian of the point at rho with respect to the control points, the same for x and y."""
    def length(self) -> float:
        """Length of the curve."""
    def nearest(self, point: tuple[float, float]) -> tuple[float, float]:
        """The nearest point of the curve to `point`: its rho, and the distance."""
    def _repr_html_(self) -> str: ...

@disjoint_base
class Reader:
    """Reads the shapes of a rig's ropes, for a control loop."""
    def __new__(
        cls,
        rig: str = "default",
        *,
        timeout: float = 0.1,
        accept_coarse: bool = False,
        min_confidence: float = 0.5,
        space: bool = False,
    ) -> Self: ...
    def latest(self) -> Frame:
        """Returns the current state without waiting."""
    def wait(self, timeout: float | None = None) -> Frame:
        """Waits for an image that this reader has not returned yet, at most `timeout` seconds. After
        the timeout, the frame is not new.
        """
    @property
    def age(self) -> float | None:
        """Age of the image of the newest frame read, s; `None` before the first frame."""
    @property
    def rig(self) -> str:
        """Name of the rig."""
    @property
    def timeout(self) -> float:
        """Default timeout of a wait for the next image, s."""
    def fileno(self) -> int:
        """A file descriptor that becomes readable when an image arrives, for your own `select`: see
        `before_poll`.
        """
    def before_poll(self) -> float | None:
        """Prepares for your own `select`. Call it before each one and sleep no longer than the
        returned seconds; `None` is unlimited. After the sleep, however it ended, `latest` returns
        the new state.
        """
    def expect_motion(self, acceleration: float = 1000.0, lasts_s: float = 0.1) -> None:
        """Sets the motion model of ropes for `Rope.predict`: the standard deviation of a point's
        acceleration, units/s², and its correlation time, s. Use the chain's own values.
        """
    def close(self) -> None:
        """Leaves the rig. Frames that were read before stay valid."""
    @property
    def closed(self) -> bool:
        """True if closed."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None: ...
    def __iter__(self) -> Self: ...
    def __next__(self) -> Frame: ...

@final
class Frame:
    """The newest frame at the time of a request."""
    @property
    def is_new(self) -> bool:
        """True if the frame arrived after the previous request. Otherwise it is the same image, now
        older.
        """
    @property
    def age(self) -> float | None:
        """Age of the image when the frame was requested, s; `None` before the first image."""
    @property
    def run(self) -> int:
        """Run of the chain, counted by this reader from 1; 0 before the first message."""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image, px; (0, 0) while the camera gives no image, and before the
        first message.
        """
    @property
    def unit(self) -> UnitName | None:
        """Unit of the ropes: `"px"`, `"mm"` on the plane, or `"ideal px"` of an image without
        distortion.
        """
    @property
    def trace(self) -> Trace | None:
        """Counters and times of the frame; `None` before the first message."""
    @property
    def message(self) -> Any:
        """The whole message as a NumPy record (`lariat.MESSAGE`), with the names and layout of
        docs/messages.md, for example for recording. It does not contain its age. `count` fields
        give the number of valid array entries. `None` before the first message.
        """
    def only_rope(self, max_age: float) -> Seen:
        """The rope of an image that has exactly one. If there are several, choose one of `ropes` and
        request its track. In an image older than `max_age` seconds, the rope is `Stale`.
        """
    def rope(self, track: Track, max_age: float) -> Seen:
        """The rope of this track, and no other."""
    def ropes(self, max_age: float) -> list[Seen]:
        """Every rope of the image, including lost ones."""
    def _repr_html_(self) -> str: ...

@final
class Trace:
    """Counters and times of a frame on its way through the chain. The times are nanoseconds of
    `time.monotonic_ns()`, 0 before they are known.
    """
    @property
    def sequence(self) -> int:
        """Frame number of the source, from 1."""
    @property
    def captured(self) -> int:
        """Frames sent by capture, this one included."""
    @property
    def extracted(self) -> int:
        """Frames sent by extract, this one included."""
    @property
    def fitted(self) -> int:
        """Frames sent by fit, this one included."""
    @property
    def bridged(self) -> int:
        """Messages written by a bridge on this machine; 0 without a bridge."""
    @property
    def exposed_ns(self) -> int:
        """Exposure time; for files, when the frame was due."""
    @property
    def captured_ns(self) -> int:
        """When capture had the frame ready to send."""
    @property
    def extract_started_ns(self) -> int:
        """When extract began."""
    @property
    def extracted_ns(self) -> int:
        """When extract had its result ready to send."""
    @property
    def fit_started_ns(self) -> int:
        """When fit began."""
    @property
    def fitted_ns(self) -> int:
        """When fit had its result ready to send."""
    @property
    def settings(self) -> int:
        """Settings version of the sender: 0 at the chain's start, one more per change."""
    @property
    def restarts(self) -> tuple[int, int, int]:
        """Restarts of capture, extract and fit, modulo 256."""

@final
class Fresh:
    """The whole rope, in an image no older than requested."""
    __match_args__: ClassVar[tuple[Literal["rope"]]]
    @property
    def rope(self) -> Rope:
        """The rope."""
    def or_raise(self, *, partial: bool = False) -> Rope:
        """Returns the rope."""

@final
class Partial:
    """The rope, partly covered. The covered part is interpolated from the parts on both sides and from
    its earlier position.
    """
    __match_args__: ClassVar[tuple[Literal["rope"]]]
    @property
    def rope(self) -> Rope:
        """The partly covered rope."""
    def or_raise(self, *, partial: bool = False) -> Rope:
        """Returns the rope if `partial` is True; otherwise raises `NotSeen`."""

@final
class Unsure:
    """A rope or something similar, with the reason why it must not be used for steering as it is."""
    __match_args__: ClassVar[tuple[Literal["rope"], Literal["why"]]]
    @property
    def rope(self) -> Rope:
        """The rope."""
    @property
    def why(self) -> Literal["coarse", "no-rope", "low-confidence"]:
        """`"coarse"`: the curve does not follow the rope, but its `centerline` does. `"no-rope"`: it
        may be a shadow, a pen or an edge. `"low-confidence"`: its `confidence` is less than the
        reader's `min_confidence`.
        """
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Lost:
    """The image is fresh but does not show the rope, or the camera gives no image."""
    @property
    def age(self) -> float:
        """Time since the rope was observed with its last known shape, s."""
    @property
    def as_it_was(self) -> Rope:
        """The last known rope. Use it to search, to draw, or to predict its position, but not to
        steer.
        """
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Stale:
    """The image is older than requested: the chain hangs, is too slow, or has ended."""
    @property
    def age(self) -> float:
        """Time since the rope was observed with its last known shape, s."""
    @property
    def as_it_was(self) -> Rope:
        """The last known rope. Use it to draw, or to predict its position, but not to steer."""
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Absent:
    """No shape is known, not even an old one."""
    __match_args__: ClassVar[tuple[Literal["why"]]]
    @property
    def why(
        self,
    ) -> Literal[
        "nothing-yet", "nothing-lately", "no-image", "no-rope", "several", "other-run", "unreadable"
    ]:
        """The reason: `"nothing-yet"`, `"nothing-lately"`, `"no-image"`, `"no-rope"`, `"several"`,
        `"other-run"` or `"unreadable"`. `str()` of the object gives it as a sentence.
        """
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Track:
    """Identity of a rope: its number and the run of the chain that assigned it."""
    @property
    def number(self) -> int:
        """Number of the rope in messages, files and images."""
    @property
    def run(self) -> int:
        """Run of the chain, counted by its reader from 1."""

@final
class Rope:
    """A rope at the time of its image."""
    @property
    def track(self) -> Track:
        """Identity of the rope. `Frame.rope` finds the same rope by it."""
    @property
    def age(self) -> float:
        """Age of the shape when the frame was requested, s: the time since its image was taken or, for
        a lost rope, since the last image that showed it.
        """
    @property
    def exposed_ns(self) -> int:
        """Exposure time of its image in nanoseconds of `time.monotonic_ns()`."""
    @property
    def unit(self) -> UnitName | None:
        """Unit of its coordinates, as `Frame.unit`."""
    @property
    def centerline(self) -> Centerline | None:
        """The points that its curve was fitted to, with their widths: the observed points, whether or
        not the curve follows them. `None` if the sender gives no points; `lariat run` always does.
        """
    @property
    def fit(self) -> FitName | None:
        """Fit of the curve to those points: `"good"`, `"coarse"`, or `"not judged"` by the sender."""
    @property
    def confidence(self) -> float:
        """Calibrated probability, 0 to 1, that this is a rope and its centerline is whole and in
        order.
        """
    @property
    def shape(self) -> Shape:
        """Its curve, with points, directions and covariance."""
    @property
    def in_space(self) -> SpaceShape:
        """Its curve in space, for a reader opened with `space=True`. If its position is unknown,
        raises `ValueError` with the reason.
        """
    def predict(self, t_ns: int) -> Shape:
        """Predicts the rope at the time `t_ns` of `time.monotonic_ns()` from its velocities, with its
        covariance.
        """
    @property
    def control_points(self) -> NDArray[np.float64]:
        """Its control points, of shape (control points, 2), or its feature points or center."""
    @property
    def covariances(self) -> NDArray[np.float64]:
        """Covariance of each control point's coordinates, rows of xx, xy, yy."""
    @property
    def velocities(self) -> NDArray[np.float64] | None:
        """Velocity of each control point, units per second; `None` unless the chain filters them
        (`--filter`).
        """
    @property
    def weights(self) -> NDArray[np.float64]:
        """Weights of the control points; 1 unless the curve is rational."""
    @property
    def knots(self) -> NDArray[np.float64]:
        """The inner knots of a B-spline, ascending between 0 and 1; empty for other curves."""
    @property
    def basis(self) -> BasisName | None:
        """The family of curves: `"bezier"`, `"bspline"`, `"rational"`, `"fourier"`, `"points"` or
        `"mass"`.
        """
    @property
    def degree(self) -> int:
        """Polynomial degree of the curve (3 for a cubic B-spline); number of harmonics for a Fourier
        series.
        """
    @property
    def samples(self) -> int:
        """Number of fitted centerline points."""
    @property
    def closed(self) -> bool:
        """True if the rope is closed."""
    @property
    def leaves_image(self) -> tuple[bool, bool]:
        """True for each end, first and last, that leaves the image."""
    @property
    def hidden(self) -> float:
        """Share of its points that are covered or outside the image, and so interpolated: 0 to 1."""
    @property
    def length(self) -> float:
        """Arc length of the centerline."""
    @property
    def width(self) -> float:
        """Median width of the rope."""
    @property
    def rms(self) -> float:
        """Root mean square distance of the points from the curve at their rho."""
    @property
    def max(self) -> float:
        """Maximum distance of a point from the curve at its rho."""
    @property
    def residual_variance(self) -> float:
        """Variance of one coordinate's residual."""
    @property
    def condition(self) -> float:
        """Condition number of the regression."""
    def _repr_html_(self) -> str: ...

@final
class Centerline:
    """The points of a rope at equal steps of arc length, joined by straight lines, in the frame's
    unit. They are the unfiltered observed points, whether or not the curve follows them. rho is 0
    at the first point and 1 at the last; on a closed rope, 1 is the first point again.
    """
    @property
    def points(self) -> NDArray[np.float32]:
        """The points, of shape (n, 2)."""
    @property
    def widths(self) -> NDArray[np.float32]:
        """Width of the rope at each point."""
    @property
    def hidden(self) -> NDArray[np.bool_]:
        """True for each point that is covered or outside the image; its position is then interpolated."""
    @property
    def closed(self) -> bool:
        """True if the first point follows the last."""
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1, on the straight line between its two neighbors. For n values of
        rho, an array of shape (n, 2).
        """
    def nearest(self, point: tuple[float, float]) -> tuple[float, NDArray[np.float64], float]:
        """The nearest point to `point`: its rho, the point itself, and the distance."""
    def __len__(self) -> int: ...

@final
class SpaceShape:
    """The curve f(rho) in space, mm, from a depth camera, with rho from 0 at the rope's first end to 1
    at its last.
    """
    @property
    def control_points(self) -> NDArray[np.float64]:
        """The control points, of shape (control points, 3), mm."""
    @property
    def covariances(self) -> NDArray[np.float64]:
        """Covariance of each control point's coordinates, rows of xx, xy, xz, yy, yz, zz, mm²."""
    @property
    def velocities(self) -> NDArray[np.float64] | None:
        """Velocity of each control point, mm/s; `None` unless the chain filters them (`--filter`)."""
    @property
    def centerline(self) -> NDArray[np.float32]:
        """The fitted centerline points, of shape (points, 3), mm."""
    @property
    def sigmas(self) -> NDArray[np.float32]:
        """Standard deviation of each of those points along the camera's line of sight, mm."""
    @property
    def measured(self) -> int:
        """Number of points measured in the depth image; the others are interpolated."""
    @property
    def place(self) -> str | None:
        """`"known"`, or `"before"` for the last known position of a lost rope."""
    @property
    def fit(self) -> FitName | None:
        """Fit of the curve to its points: `"good"`, `"coarse"`, or `"not judged"`."""
    @property
    def length(self) -> float:
        """Arc length of the centerline, mm."""
    @property
    def width(self) -> float:
        """Median width of the rope, mm."""
    @property
    def closed(self) -> bool:
        """True if the curve is closed."""
    def points(self, count: int = 120) -> NDArray[np.float64]:
        """`count` points at equal steps of rho: from end to end, or once around a closed curve."""
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1. For n values of rho, an array of shape (n, 3)."""
    def derivative_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The derivative with respect to rho: f′(rho)."""
    def tangent_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The unit tangent; NaN if the curve is a point."""
    def nearest(
        self, point: tuple[float, float, float]
    ) -> tuple[float, NDArray[np.float64], float]:
        """The nearest point of the curve to `point`: its rho, the point itself, and the distance."""

@final
class Shape:
    """The curve f(rho) in the frame's unit, with rho from 0 at the rope's first end to 1 at its last."""
    @property
    def control_points(self) -> NDArray[np.float64]:
        """The control points, of shape (control points, 2); for a closed rope, the coefficients of its
        Fourier series.
        """
    @property
    def closed(self) -> bool:
        """True if the curve is closed."""
    def points(self, count: int = 120) -> NDArray[np.float64]:
        """`count` points at equal steps of rho: from end to end, or once around a closed curve."""
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1. For n values of rho, an array of shape (n, 2)."""
    def nearest(self, point: tuple[float, float]) -> tuple[float, NDArray[np.float64], float]:
        """The nearest point of the curve to `point`: its rho, the point itself, and the distance."""
    def derivative_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The derivative with respect to rho: f′(rho)."""
    def tangent_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The unit tangent; NaN if the curve is a point."""
    def normal_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The unit normal, to the right of the direction of travel in the image; NaN if the curve is a
        point.
        """
    @overload
    def curvature_at(self, rho: float) -> float:
        """The signed curvature, one over the radius, positive if the curve turns towards its normal.
        NaN where the derivative vanishes.
        """
    @overload
    def curvature_at(self, rho: ArrayLike) -> float | NDArray[np.float64]:
        """The signed curvature, one over the radius, positive if the curve turns towards its normal.
        NaN where the derivative vanishes.
        """
    def jacobian_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The Jacobian of the point at rho with respect to the control points, the same for x and y.
        For n values of rho, an array of shape (n, control points).
        """
    def covariance(self) -> NDArray[np.float64]:
        """The joint covariance of all control points, for the vector x0, y0, x1, y1, …, in the unit
        squared.
        """
    @property
    def covariance_is_exact(self) -> bool:
        """True if `covariance` is exact up to rounding, as for plain least squares with or without a
        filter. Otherwise (ridge, pinned ends, weights, a plane) each control point's own covariance
        is exact, and the correlations are those of the plain fit.
        """
    def covariance_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The covariance of the point at rho, of shape (2, 2). For n values of rho, (n, 2, 2)."""
    def _repr_html_(self) -> str: ...

@disjoint_base
class Frames:
    """Reads the frames of a rig, for a network that computes masks from them."""
    def __new__(cls, rig: str = "default", *, lossless: bool | None = None) -> Self: ...
    def wait(self, timeout: float | None = None) -> Image | None:
        """Waits for the next image, at most `timeout` seconds; `None` if none arrived."""
    @property
    def rig(self) -> str:
        """Name of the rig."""
    def close(self) -> None:
        """Leaves the rig. Images that were read before stay valid."""
    @property
    def closed(self) -> bool:
        """True if closed."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None: ...
    def __iter__(self) -> Self: ...
    def __next__(self) -> Image: ...

@final
class Image:
    """A frame: its pixels, counters and times."""
    @property
    def array(self) -> NDArray[Any]:
        """Its pixels: (height, width) for gray, (height, width, channels) for colors. The array is a
        copy.
        """
    @property
    def pixel_format(self) -> str | None:
        """Name of its pixel format: `rgb8`, `bgr8`, `gray8`, `yuyv`, `uyvy`, `nv12`, …"""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
    @property
    def trace(self) -> Trace:
        """Counters and times of the frame up to capture, such as its number and exposure time."""

@disjoint_base
class Writer:
    """Writes a rig's frames or masks."""
    def __new__(cls, channel: str, rig: str = "default", *, lossless: bool | None = None) -> Self: ...
    def loan_frame(self, height: int, width: int, pixel_format: str) -> Slot:
        """Borrows the slot of a frame."""
    def loan_mask(self, frame: Image) -> Slot:
        """Borrows the slot of a frame's mask."""
    def loan_depth(self, frame: Image, height: int, width: int) -> Slot:
        """Borrows the slot of a frame's depth image."""
    def send_blank(self) -> None:
        """Sends a frame without an image."""
    @property
    def lossless(self) -> bool:
        """True if it waits for slow readers."""
    @property
    def rig(self) -> str:
        """Name of the rig."""
    def close(self) -> None:
        """Leaves the rig, so that another writer can open it. Sent frames are delivered."""
    @property
    def closed(self) -> bool:
        """True if closed."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None: ...

@final
class Slot:
    """A borrowed slot of shared memory."""
    def array(self) -> NDArray[Any]:
        """Returns an array that is the slot itself."""
    def send_frame(self, exposed_ns: int | None = None, sequence: int | None = None) -> None:
        """Sends the slot as a frame."""
    def send_mask(self) -> None:
        """Sends the slot as a mask."""
    def send_depth(self) -> None:
        """Sends the slot as a depth image."""
