"""What the Rust half offers: see each class's own documentation."""

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
    """The colour ranges of the ropes in a picture, for the setting `mask`: of all that stand out from the table, or of the one
    at the position `at`, or at several of them: one for each of its colours. Also how well they tell rope from table: below
    some 0.7 a mask of them has holes, or takes table for rope. Warns where what is traced in that mask speaks against it.
    """
def take_short_slices() -> None:
    """Asks for short slices of a core for the calling thread, for a control loop that may not have realtime priority: when a
    message wakes it, it need not wait for the end of another program's slice. Any user may; it needs Linux 6.12, and changes
    nothing on older ones. Threads that it starts later have short ones too.
    """
@final
class Tracer:
    """Traces pictures as one moving scene, and keeps its memory from one to the next: ropes keep their number and direction,
    and are followed, which costs a fraction of a whole extraction.
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
        """The ropes in the next picture."""
    def reset(self) -> None:
        """Forgets the past: the next picture is a new scene."""

@final
class Scene:
    """The ropes in one picture."""
    @property
    def curves(self) -> list[Curve]:
        """The ropes seen, the longest first, then the lost ones."""
    @property
    def crossings(self) -> list[Crossing]:
        """Where they cross, at most 32."""
    @property
    def notice(self) -> Notice | None:
        """The most important probable fault of what was seen, if any."""
    @property
    def followed(self) -> bool:
        """Whether the ropes were followed from the last picture, by reading this one only around them."""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture, px."""
    def _repr_html_(self) -> str: ...

@final
class Curve:
    """The centerline of one rope: positions in pixels, x to the right, y down, (0, 0) the middle of the top left pixel."""
    @property
    def track(self) -> int:
        """The rope's number, kept from picture to picture of a `Tracer`."""
    @property
    def status(self) -> StatusName:
        """How much of the rope is seen: `"ok"`, `"partial"` or `"lost"`; `"doubtful"`: it may be no rope."""
    @property
    def confidence(self) -> float:
        """How sure it is that this is a rope, whole and in order, 0 to 1: of those at 0.9, nine of ten are."""
    @property
    def closed(self) -> bool:
        """Whether the rope has no ends. The last point is then one step before the first."""
    @property
    def leaves_image(self) -> tuple[bool, bool]:
        """Whether the first and the last point lie where the rope leaves the picture."""
    @property
    def points(self) -> NDArray[np.float32]:
        """Points at equal steps of arc length, an array of `float32` of shape (points, 2), px."""
    @property
    def widths_px(self) -> NDArray[np.float32]:
        """The rope's width at each point, px."""
    @property
    def hidden(self) -> NDArray[np.bool_]:
        """Whether each point is covered by something or outside of the image, and so not seen but bridged."""
    @property
    def width_px(self) -> float:
        """The median of the widths, px."""
    @property
    def length_px(self) -> float:
        """Arc length from tip to tip (once around, when closed), px."""
    @property
    def age(self) -> float:
        """How long ago the rope was last seen, s: 0 unless it is lost."""
    @property
    def crossing_sequence(self) -> str:
        """The rope's passes over and under itself from its first point on: `"O1 U2 O3 U1 O2 U3"` is an overhand knot."""
    @property
    def pulls_straight(self) -> bool | None:
        """Whether the rope comes out straight when its ends are drawn apart; `None` when no answer has a probability of 0.9."""
    def _repr_html_(self) -> str: ...

@final
class Crossing:
    """A place where a rope passes over a rope, another or itself."""
    @property
    def at(self) -> tuple[float, float]:
        """Where, [x, y] in px."""
    @property
    def over(self) -> int:
        """Index in the scene's curves of the upper rope."""
    @property
    def under(self) -> int:
        """Index in the scene's curves of the lower rope."""
    @property
    def over_rho(self) -> float:
        """Where on the upper rope, as normalized arc length from 0 to 1."""
    @property
    def under_rho(self) -> float:
        """Where on the lower rope, likewise."""
    @property
    def confidence(self) -> float:
        """How sure the order is, from 0 (a toss of a coin) to 1."""

@final
class Notice:
    """Why the automatic mask may be wrong about a picture, and what to do; `str()` of it is the sentence."""
    @property
    def name(self) -> str:
        """A short name for programs, such as `"checkered-table"`."""

@final
class Fitter:
    """Fits curves of one family to centerlines of one number of points: all that does not depend on the points is computed
    once.
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
        """The curve nearest to `points` in the least-squares sense. `width` is the rope's, and `hidden` says of each point whether
        nobody saw it. Both matter where control points are chosen. The curve is then within an eighth of the width, and 2 px at
        most, of 95 % of the points that were seen. It is within half a width of all of them.
        """
    @property
    def matrix(self) -> NDArray[np.float64]:
        """The constant matrix P with s = P c: the Jacobian of the control points by the points, of shape
        (control points, points). It is the same for x and y.
        """
    @property
    def points(self) -> int:
        """How many points a centerline has."""
    @property
    def basis(self) -> BasisName:
        """The family of curves, such as `"bezier"`."""
    def forget(self) -> None:
        """Forgets what the next fit would begin with (the weights of a rational curve): the next centerline is another rope's."""

@final
class Fit:
    """A curve fitted to points, in their unit: f(rho), rho from 0 at the first point to 1 at the last."""
    @property
    def basis(self) -> BasisName:
        """The family of curves: `"bezier"`, `"bspline"`, `"rational"`, `"fourier"`, `"points"` or `"mass"`."""
    @property
    def degree(self) -> int:
        """Degree of the curve's polynomials, 3 of a cubic B-spline whatever its control points; of a Fourier series its harmonics."""
    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
    @property
    def control_points(self) -> NDArray[np.float64]:
        """The descriptor, of shape (control points, 2)."""
    @property
    def weights(self) -> NDArray[np.float64] | None:
        """Weights of the control points: of a rational curve only."""
    @property
    def knots(self) -> NDArray[np.float64] | None:
        """The clamped knots: of a B-spline only."""
    @property
    def rms(self) -> float:
        """Root of the mean squared distance between a point and the curve at that point's rho."""
    @property
    def max(self) -> float:
        """The largest of these distances."""
    @property
    def residual_variance(self) -> float:
        """Variance of one coordinate's residual; 0 where there are only as many points as control points."""
    @property
    def condition(self) -> float:
        """Condition number of the regression: how much a relative error of the points can grow in the control points."""
    @property
    def noise_gain(self) -> float:
        """Standard deviation of the least certain control point's coordinate, for noise of 1 in the points'."""
    def covariance(self) -> NDArray[np.float64]:
        """The covariance of all control points together, of the vector x0, y0, x1, y1, …: the residual variance times
        `(BᵀB)⁻¹ ⊗ I₂`.
        """
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1; of n values of rho an array of shape (n, 2)."""
    def derivative_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The velocity by rho: f′(rho)."""
    def tangent_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The direction in which the curve goes, of length 1; NaN where it is a point."""
    @overload
    def curvature_at(self, rho: float) -> float:
        """One by the radius of the circle that the curve follows; NaN where it stands still."""
    @overload
    def curvature_at(self, rho: ArrayLike) -> float | NDArray[np.float64]:
        """One by the radius of the circle that the curve follows; NaN where it stands still."""
    def jacobian_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """How much the point at rho moves with each control point, the same for x and y."""
    def length(self) -> float:
        """The curve's length."""
    def nearest(self, point: tuple[float, float]) -> tuple[float, float]:
        """What of the curve is nearest to a point: its rho, and the distance."""
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
        """What is known now, without waiting."""
    def wait(self, timeout: float | None = None) -> Frame:
        """What is known as soon as an image comes that this reader has not looked at, or after `timeout` seconds: then the
        frame is not new.
        """
    @property
    def age(self) -> float | None:
        """How long ago the image of the newest frame that was looked at was taken, s; `None` before the first."""
    @property
    def rig(self) -> str:
        """The rig's name."""
    @property
    def timeout(self) -> float:
        """How long it waits for the next image if not told otherwise, s."""
    def fileno(self) -> int:
        """Becomes readable when an image came, for a `select` of one's own: see `before_poll`."""
    def before_poll(self) -> float | None:
        """Makes ready for a `select` of one's own: call it before each one, and sleep no longer than the seconds it says;
        `None` is as long as you like. After the sleep, however it ended, `latest` says what came.
        """
    def expect_motion(self, acceleration: float = 1000.0, lasts_s: float = 0.1) -> None:
        """How ropes are taken to move, for `Rope.predict`: the standard deviation of the acceleration of a point, units/s²,
        and how long an acceleration lasts, s. Give it what the chain was given.
        """
    def close(self) -> None:
        """Leaves the rig. What was read before stays good."""
    @property
    def closed(self) -> bool:
        """Whether it was closed."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None: ...
    def __iter__(self) -> Self: ...
    def __next__(self) -> Frame: ...

@final
class Frame:
    """The newest that came, looked at at one moment."""
    @property
    def is_new(self) -> bool:
        """Whether it came since the last look. If not, it is the same image, some time older."""
    @property
    def age(self) -> float | None:
        """How long ago the image was taken when the frame was asked for, s; `None` before the first."""
    @property
    def run(self) -> int:
        """Which run of the chain it is of, counted by this reader from 1; 0 before the first message."""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image, px; (0, 0) while the camera gives none, and before the first message."""
    @property
    def unit(self) -> UnitName | None:
        """What ropes are measured in: `"px"`, `"mm"` on the plane, `"ideal px"` of an image without distortion."""
    @property
    def trace(self) -> Trace | None:
        """The frame's way through the chain; `None` before the first message."""
    @property
    def message(self) -> Any:
        """All that the message says, by the names and in the layout of docs/messages.md, as one record of NumPy
        (`lariat.MESSAGE`): for writing it down. It says nothing of how old it is now; `count` fields say how much of an array
        is meant. `None` before the first message.
        """
    def only_rope(self, max_age: float) -> Seen:
        """The rope of an image that has one. With several it is none of them: then choose one among `ropes`, and ask for its
        track. An image older than `max_age` seconds makes it stale.
        """
    def rope(self, track: Track, max_age: float) -> Seen:
        """The rope of this track, and no other."""
    def ropes(self, max_age: float) -> list[Seen]:
        """Every rope of the image, and those that are lost."""
    def _repr_html_(self) -> str: ...

@final
class Trace:
    """The way of a frame through the chain: counts of what each stage sent, and times in nanoseconds of
    `time.monotonic_ns()`, 0 before they are known.
    """
    @property
    def sequence(self) -> int:
        """The source's own frame number, from 1."""
    @property
    def captured(self) -> int:
        """How many frames capture has sent, this one included."""
    @property
    def extracted(self) -> int:
        """How many extract has sent."""
    @property
    def fitted(self) -> int:
        """How many fit has sent."""
    @property
    def bridged(self) -> int:
        """How many a bridge has written on this machine; 0 if it came over none."""
    @property
    def exposed_ns(self) -> int:
        """When the image was taken: for files, the moment the frame was due."""
    @property
    def captured_ns(self) -> int:
        """When capture had it ready to send."""
    @property
    def extract_started_ns(self) -> int:
        """When extract had it in hand."""
    @property
    def extracted_ns(self) -> int:
        """When extract had its result ready to send."""
    @property
    def fit_started_ns(self) -> int:
        """When fit had it in hand."""
    @property
    def fitted_ns(self) -> int:
        """When fit had its result ready to send."""
    @property
    def settings(self) -> int:
        """By which settings the sender went: 0 by those that its chain began with, one more for each change since."""
    @property
    def restarts(self) -> tuple[int, int, int]:
        """Restarts of capture, extract and fit, modulo 256."""

@final
class Fresh:
    """The whole rope, in an image no older than was asked for."""
    __match_args__: ClassVar[tuple[Literal["rope"]]]
    @property
    def rope(self) -> Rope:
        """The rope."""
    def or_raise(self, *, partial: bool = False) -> Rope:
        """The rope."""

@final
class Partial:
    """The rope, but a part of it is covered by something: that part is bridged by what was seen on its two sides, and where
    it was before.
    """
    __match_args__: ClassVar[tuple[Literal["rope"]]]
    @property
    def rope(self) -> Rope:
        """The rope, a part of it bridged."""
    def or_raise(self, *, partial: bool = False) -> Rope:
        """The rope, if `partial` says that a part of it may be bridged; otherwise raises `NotSeen`."""

@final
class Unsure:
    """A rope, or what looks like one, and why it is not to be steered by as it is."""
    __match_args__: ClassVar[tuple[Literal["rope"], Literal["why"]]]
    @property
    def rope(self) -> Rope:
        """The rope."""
    @property
    def why(self) -> Literal["coarse", "no-rope", "low-confidence"]:
        """`"coarse"`: the curve does not lie on the rope, but its `centerline` does. `"no-rope"`: it may be a shadow, a pen or
        an edge. `"low-confidence"`: its `confidence` is less than the reader's `min_confidence`.
        """
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Lost:
    """The image is fresh, and the rope is not in it; or the camera gives no image."""
    @property
    def age(self) -> float:
        """How long ago the rope was seen with its last known shape, s."""
    @property
    def as_it_was(self) -> Rope:
        """The rope as it was: to look for it, to draw it, or to predict where it went. Not to steer by."""
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Stale:
    """The image is older than was asked for: the chain stands still, or is too slow, or has ended."""
    @property
    def age(self) -> float:
        """How long ago the rope was seen with its last known shape, s."""
    @property
    def as_it_was(self) -> Rope:
        """The rope as it was: to draw it, or to predict where it went. Not to steer by."""
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Absent:
    """There is no shape at all, not even an old one."""
    __match_args__: ClassVar[tuple[Literal["why"]]]
    @property
    def why(
        self,
    ) -> Literal[
        "nothing-yet", "nothing-lately", "no-image", "no-rope", "several", "other-run", "unreadable"
    ]:
        """`"nothing-yet"`, `"nothing-lately"`, `"no-image"`, `"no-rope"`, `"several"`, `"other-run"` or `"unreadable"`; `str()`
        of the object says it in a sentence.
        """
    def or_raise(self, *, partial: bool = False) -> NoReturn:
        """Raises `NotSeen`."""

@final
class Track:
    """Which rope: its number, and the run of the chain that gave it."""
    @property
    def number(self) -> int:
        """The rope's number, as messages, files and pictures have it."""
    @property
    def run(self) -> int:
        """Which run of the chain it is of, counted by its reader from 1."""

@final
class Rope:
    """A rope, as it was when its image was taken."""
    @property
    def track(self) -> Track:
        """Which rope it is: give it to `Frame.rope` to have the same one again."""
    @property
    def age(self) -> float:
        """How long ago the rope had this shape when the frame was asked for, s: since its image was taken, and, of a lost one,
        since the last image that it was seen in.
        """
    @property
    def exposed_ns(self) -> int:
        """When its image was taken, in nanoseconds of `time.monotonic_ns()`."""
    @property
    def unit(self) -> UnitName | None:
        """What it is measured in, as the frame's `unit`."""
    @property
    def centerline(self) -> Centerline | None:
        """The points that its curve was fitted to, with their widths: where the rope was seen, whether the curve lies on them
        or not. `None` if who sent it gives none; `lariat run` always does.
        """
    @property
    def fit(self) -> FitName | None:
        """Whether the curve lies on those points: `"good"`, `"coarse"`, or `"not judged"` by who sent it."""
    @property
    def confidence(self) -> float:
        """How sure it is that this is a rope, and its centerline whole and in order, 0 to 1: of those at 0.9, nine of ten are."""
    @property
    def shape(self) -> Shape:
        """Its curve: any point of it, its direction, its covariance."""
    @property
    def in_space(self) -> SpaceShape:
        """Its curve in space, of a reader that was opened with `space=True`. Raises `ValueError`, with the reason, where it is not
        known where the rope is.
        """
    def predict(self, t_ns: int) -> Shape:
        """Where it will be at the moment `t_ns` of `time.monotonic_ns()`, by its velocities, and how uncertain."""
    @property
    def control_points(self) -> NDArray[np.float64]:
        """Its control points, of shape (control points, 2); feature points and center too."""
    @property
    def covariances(self) -> NDArray[np.float64]:
        """Covariance of each control point's coordinates, rows of xx, xy, yy."""
    @property
    def velocities(self) -> NDArray[np.float64] | None:
        """Velocity of each control point, units a second; `None` unless the chain filters them (`--filter`)."""
    @property
    def weights(self) -> NDArray[np.float64]:
        """Weights of the control points: those of a rational curve, else 1."""
    @property
    def knots(self) -> NDArray[np.float64]:
        """The inner knots of a B-spline, ascending between 0 and 1; none of other curves."""
    @property
    def basis(self) -> BasisName | None:
        """The family of curves: `"bezier"`, `"bspline"`, `"rational"`, `"fourier"`, `"points"` or `"mass"`."""
    @property
    def degree(self) -> int:
        """Degree of the curve's polynomials, 3 of a cubic B-spline whatever its control points; of a Fourier series its harmonics."""
    @property
    def samples(self) -> int:
        """How many points of the centerline were fitted."""
    @property
    def closed(self) -> bool:
        """Whether the rope has no ends."""
    @property
    def leaves_image(self) -> tuple[bool, bool]:
        """Which of its ends leave the image, first and last."""
    @property
    def hidden(self) -> float:
        """Which share of it was covered by something, and so bridged: 0 to 1."""
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
        """The largest such distance."""
    @property
    def residual_variance(self) -> float:
        """Variance of one coordinate's residual."""
    @property
    def condition(self) -> float:
        """Condition number of the regression."""
    def _repr_html_(self) -> str: ...

@final
class Centerline:
    """The points of a rope at equal steps of arc length, joined by straight lines, in the frame's unit: where it was seen,
    unfiltered, whether its curve lies on them or not. rho is 0 at the first and 1 at the last; around a closed rope 1 is the
    first again.
    """
    @property
    def points(self) -> NDArray[np.float32]:
        """The points, of shape (n, 2)."""
    @property
    def widths(self) -> NDArray[np.float32]:
        """The rope's width at each."""
    @property
    def hidden(self) -> NDArray[np.bool_]:
        """Whether each is covered by something or outside of the image, and so not seen but bridged."""
    @property
    def closed(self) -> bool:
        """Whether the last point is followed by the first."""
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1, on the straight line between its two neighbours; of n values of rho an array of shape (n, 2)."""
    def nearest(self, point: tuple[float, float]) -> tuple[float, NDArray[np.float64], float]:
        """The nearest point to `point`: its rho, the point, and how far it is away."""
    def __len__(self) -> int: ...

@final
class SpaceShape:
    """The curve f(rho) in space, mm, rho from 0 at the rope's first end to 1 at its last: by what a depth camera shows."""
    @property
    def control_points(self) -> NDArray[np.float64]:
        """What it is made of, of shape (control points, 3), mm."""
    @property
    def covariances(self) -> NDArray[np.float64]:
        """Covariance of each control point's coordinates, rows of xx, xy, xz, yy, yz, zz, mm²."""
    @property
    def velocities(self) -> NDArray[np.float64] | None:
        """Velocity of each control point, mm/s; `None` unless the chain filters them (`--filter`)."""
    @property
    def centerline(self) -> NDArray[np.float32]:
        """The points of the centerline that were fitted, of shape (points, 3), mm."""
    @property
    def sigmas(self) -> NDArray[np.float32]:
        """The standard deviation of each of those along the line to the camera, mm."""
    @property
    def measured(self) -> int:
        """How many of them the depth image shows. The others are bridged."""
    @property
    def place(self) -> str | None:
        """`"known"`, or `"before"` of a rope that is lost from sight: where it was."""
    @property
    def fit(self) -> FitName | None:
        """Whether the curve lies on its points: `"good"`, `"coarse"`, or `"not judged"`."""
    @property
    def length(self) -> float:
        """Arc length of the centerline, mm."""
    @property
    def width(self) -> float:
        """Median width of the rope, mm."""
    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
    def points(self, count: int = 120) -> NDArray[np.float64]:
        """`count` points at even steps of rho: from its first end to its last, or once around a closed one."""
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1; of n values of rho an array of shape (n, 3)."""
    def derivative_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The velocity by rho: f′(rho)."""
    def tangent_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The direction in which the curve goes, of length 1; NaN where it is a point."""
    def nearest(
        self, point: tuple[float, float, float]
    ) -> tuple[float, NDArray[np.float64], float]:
        """The rho of the point of the curve that is nearest to `point`, that point, and how far it is away."""

@final
class Shape:
    """The curve f(rho), rho from 0 at the rope's first end to 1 at its last, in the frame's unit."""
    @property
    def control_points(self) -> NDArray[np.float64]:
        """What it is made of, of shape (control points, 2); of a closed rope the coefficients of its Fourier series."""
    @property
    def closed(self) -> bool:
        """Whether it ends where it begins."""
    def points(self, count: int = 120) -> NDArray[np.float64]:
        """`count` points at even steps of rho: from its first end to its last, or once around a closed one."""
    def point_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The point at rho, 0 to 1; of n values of rho an array of shape (n, 2)."""
    def nearest(self, point: tuple[float, float]) -> tuple[float, NDArray[np.float64], float]:
        """The point of the curve that is nearest to `point`: its rho, the point, and how far it is away."""
    def derivative_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The velocity by rho: f′(rho)."""
    def tangent_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The direction in which the curve goes, of length 1; NaN where it is a point."""
    def normal_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """The direction across the curve, to the right of its way in the image, of length 1; NaN where it is a point."""
    @overload
    def curvature_at(self, rho: float) -> float:
        """One by the radius of the circle that the curve follows, positive where it turns towards its normal; NaN where it
        stands still.
        """
    @overload
    def curvature_at(self, rho: ArrayLike) -> float | NDArray[np.float64]:
        """One by the radius of the circle that the curve follows, positive where it turns towards its normal; NaN where it
        stands still.
        """
    def jacobian_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """How much the point at rho moves with each control point, the same for x and y; of n values of rho of shape
        (n, control points).
        """
    def covariance(self) -> NDArray[np.float64]:
        """The covariance of all control points together, of the vector x0, y0, x1, y1, …, in the unit's square."""
    @property
    def covariance_is_exact(self) -> bool:
        """Whether `covariance` is that of plain least squares or of its filter, right to rounding. If not (ridge, pinned ends,
        weights, a plane), each control point's own is right, and how two of them hang together is that of the plain fit.
        """
    def covariance_at(self, rho: ArrayLike) -> NDArray[np.float64]:
        """How uncertain the point at rho is, of shape (2, 2); of n values of rho (n, 2, 2)."""
    def _repr_html_(self) -> str: ...

@disjoint_base
class Frames:
    """Reads the frames of a rig, for a network that makes masks of them."""
    def __new__(cls, rig: str = "default", *, lossless: bool | None = None) -> Self: ...
    def wait(self, timeout: float | None = None) -> Image | None:
        """The next image, waited for at most for `timeout` seconds; `None` if none came."""
    @property
    def rig(self) -> str:
        """The rig's name."""
    def close(self) -> None:
        """Leaves the rig. What was read before stays good."""
    @property
    def closed(self) -> bool:
        """Whether it was closed."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None: ...
    def __iter__(self) -> Self: ...
    def __next__(self) -> Image: ...

@final
class Image:
    """A frame: its pixels, and its way so far."""
    @property
    def array(self) -> NDArray[Any]:
        """Its pixels: (height, width) for gray, (height, width, channels) for colours. Its own copy."""
    @property
    def pixel_format(self) -> str | None:
        """The name of its pixel format: `rgb8`, `bgr8`, `gray8`, `yuyv`, `uyvy`, `nv12`, …"""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
    @property
    def trace(self) -> Trace:
        """Its way so far: when it was taken, its number."""

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
        """Whether it waits for slow readers."""
    @property
    def rig(self) -> str:
        """The rig's name."""
    def close(self) -> None:
        """Leaves the rig: another writer may come. What was sent is delivered."""
    @property
    def closed(self) -> bool:
        """Whether it was closed."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self, error: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None: ...

@final
class Slot:
    """A slot of shared memory on loan."""
    def array(self) -> NDArray[Any]:
        """An array that is the slot itself."""
    def send_frame(self, exposed_ns: int | None = None, sequence: int | None = None) -> None:
        """Sends it as a frame."""
    def send_mask(self) -> None:
        """Sends it as a mask."""
    def send_depth(self) -> None:
        """Sends it as a depth image."""
