"""lariat finds ropes, cables and hoses in images, and gives a control loop their shape.

Images and points, without a running chain::

    scene = lariat.trace(image)              # ropes in a NumPy array: centerlines, widths, crossings
    fit = lariat.fit(scene.curves[0])        # a curve through one: control points, covariance

In a control loop, alongside a running chain (``lariat run``)::

    with lariat.Reader() as reader:
        for frame in reader:                 # waits for the next image, 0.1 s at most
            match frame.only_rope(max_age=0.05):
                case lariat.Fresh(rope):
                    robot.steer(rope.shape.point_at(0.5))
                case seen:                   # Partial, Unsure, Lost, Stale, Absent
                    robot.hold(why=str(seen))

With your own camera (``lariat run --source external``), or a network that finds the ropes
(``mask = "external"``)::

    lariat.Writer("frames").write(image, "bgr8")
    for frame in lariat.Frames(): masks.write(network(frame.array), frame)   # masks = lariat.Writer("masks")

Positions are in pixels, x right, y down, with (0, 0) at the center of the top left pixel. ``rho``
is the normalized arc length: 0 at a rope's first end, 1 at its last.
"""

from lariat._frames import Frames
from lariat._functions import fit, trace
from lariat._layout import MESSAGE
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
from lariat._native import (
    Absent,
    Centerline,
    Crossing,
    Curve,
    Fit,
    Fitter,
    Frame,
    Fresh,
    Image,
    Lost,
    Notice,
    Partial,
    Rope,
    Scene,
    Shape,
    SpaceShape,
    Stale,
    Trace,
    Tracer,
    Track,
    Unsure,
    __version__,
    pick,
    take_short_slices,
)
from lariat._reader import Reader
from lariat._seen import NotSeen, Seen
from lariat._writer import DepthSlot, DepthWriter, FrameSlot, FrameWriter, MaskSlot, MaskWriter, Writer

__all__ = [
    "Absent",
    "BasisName",
    "Centerline",
    "Crossing",
    "Curve",
    "DepthSlot",
    "DepthWriter",
    "Fit",
    "FitName",
    "Fitter",
    "Frame",
    "FrameSlot",
    "FrameWriter",
    "Frames",
    "Fresh",
    "HsvRange",
    "Image",
    "KnotsName",
    "Lost",
    "MESSAGE",
    "MaskImage",
    "MaskName",
    "MaskSlot",
    "MaskWriter",
    "MethodName",
    "NotSeen",
    "Notice",
    "Partial",
    "Picture",
    "PixelFormat",
    "Reader",
    "RhoName",
    "Rope",
    "Scene",
    "Seen",
    "Shape",
    "SolverName",
    "SpaceShape",
    "Stale",
    "StatusName",
    "Trace",
    "Tracer",
    "Track",
    "UnitName",
    "Unsure",
    "Writer",
    "__version__",
    "fit",
    "pick",
    "take_short_slices",
    "trace",
]
