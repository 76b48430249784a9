//! The messages as C has them: the layout of `lariat_wire`'s, held to it field by field.

use std::mem::offset_of;

use lariat_wire as wire;

/// Most ropes in one frame.
pub const LARIAT_MAX_ROPES: usize = 24;
/// Most control points of one rope.
pub const LARIAT_MAX_CONTROL_POINTS: usize = 32;
/// Most points of one rope's centerline.
pub const LARIAT_MAX_POINTS: usize = 256;
/// Words of 32 bits that have a bit for each of them.
pub const LARIAT_HIDDEN_WORDS: usize = 8;

macro_rules! same_layout {
    ($ours:ty, $theirs:ty: $($our:ident = $their:ident),+) => {
        const _: () = {
            assert!(size_of::<$ours>() == size_of::<$theirs>());
            assert!(align_of::<$ours>() == align_of::<$theirs>());
            $(assert!(offset_of!($ours, $our) == offset_of!($theirs, $their));)+
        };
    };
}

const _: () = assert!(
    LARIAT_MAX_ROPES == wire::MAX_CURVES
        && LARIAT_MAX_CONTROL_POINTS == wire::MAX_CONTROL_POINTS
        && LARIAT_MAX_POINTS == wire::MAX_POINTS
);

// Made of the messages' declarations: LARIAT_WRITE_LAYOUTS=1 cargo test -p lariat-message

/// Seen whole (lariat_descriptor.status).
pub const LARIAT_STATUS_OK: u32 = 1;
/// A part of it is covered.
pub const LARIAT_STATUS_PARTIAL: u32 = 2;
/// Not seen now: the curve is the last known shape.
pub const LARIAT_STATUS_LOST: u32 = 3;
/// Seen whole, but it may be no rope: a shadow, a pen, an edge.
pub const LARIAT_STATUS_DOUBTFUL: u32 = 4;

/// Bernstein polynomials of this `degree` (lariat_descriptor.basis).
pub const LARIAT_BASIS_BEZIER: u32 = 1;
/// Clamped B-spline of this `degree`; its inner knots are in the message.
pub const LARIAT_BASIS_BSPLINE: u32 = 2;
/// Rational Bernstein functions of this `degree`.
pub const LARIAT_BASIS_RATIONAL: u32 = 3;
/// A truncated Fourier series of `degree` harmonics, for closed shapes: the control points are its coefficients `a₀, a₁, b₁, a₂, b₂, …` of `1, cos 2π·rho, sin 2π·rho, cos 4π·rho, …`.
pub const LARIAT_BASIS_FOURIER: u32 = 4;
/// Points of the centerline at even steps of arc length, joined by straight lines: no curve.
pub const LARIAT_BASIS_POINTS: u32 = 5;
/// The mean of all points, as one control point: no curve.
pub const LARIAT_BASIS_MASS: u32 = 6;

/// The writer did not look (lariat_descriptor.fit).
pub const LARIAT_FIT_NOT_JUDGED: u32 = 0;
/// The curve lies on its points, within the tolerance that the chain was started with.
pub const LARIAT_FIT_GOOD: u32 = 1;
/// It does not, as a curve with too few control points for the rope's bends. The points themselves are right.
pub const LARIAT_FIT_COARSE: u32 = 2;

/// Pixels of the image as it is (lariat_descriptors.unit).
pub const LARIAT_UNIT_PX: u32 = 1;
/// Millimetres on a plane.
pub const LARIAT_UNIT_MM: u32 = 2;
/// Pixels that the same camera would see without its lens's distortion.
pub const LARIAT_UNIT_IDEAL_PX: u32 = 3;

/// It is measured (lariat_descriptor3.place).
pub const LARIAT_PLACE_KNOWN: u32 = 1;
/// The colour image does not show it now: it is where it was.
pub const LARIAT_PLACE_BEFORE: u32 = 2;
/// Too little of it has a depth: it is out of the other camera's range, or not seen by it.
pub const LARIAT_PLACE_UNMEASURED: u32 = 3;
/// It is thinner than three pixels of the depth image.
pub const LARIAT_PLACE_THIN: u32 = 4;
/// Nothing came beside this frame: no depth image, or nothing from the second camera that is near enough in time.
pub const LARIAT_PLACE_NO_PARTNER: u32 = 5;
/// What came beside this frame, or a calibration, is not what it should be: the chain says what.
pub const LARIAT_PLACE_UNREADABLE: u32 = 6;

/// The way of one frame through the chain. What the counters of two messages say of losses stands in ARCHITECTURE.md.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_trace {
    /// The source's own frame number, from 1.
    pub sequence: u64,
    /// How many frames capture has sent, this one included.
    pub captured: u64,
    /// How many frames extract has sent, this one included.
    pub extracted: u64,
    /// How many frames fit has sent, this one included.
    pub fitted: u64,
    /// How many messages of this channel a bridge has written on this machine, this one included; 0 if it came over none, and for pictures.
    pub bridged: u64,
    /// When the image was taken: the driver's timestamp, or the moment a file's frame was due.
    pub exposed_ns: u64,
    /// When capture had the frame ready to send.
    pub captured_ns: u64,
    /// When extract began.
    pub extract_started_ns: u64,
    /// When extract had its result ready to send.
    pub extracted_ns: u64,
    /// When fit began.
    pub fit_started_ns: u64,
    /// When fit had its result ready to send.
    pub fitted_ns: u64,
    /// By which settings the stage that sent this message went: 0 by those that its chain began with, one more for each change since.
    pub settings: u32,
    /// Restarts of capture, extract and fit, modulo 256, one byte each from the lowest: `restarts`.
    pub restarts: u32,
}

/// One rope's shape as a few control points, in the message's unit.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_descriptor {
    /// The rope's number; it keeps it from frame to frame.
    pub track: u32,
    /// A LARIAT_STATUS_…
    pub status: u32,
    /// A LARIAT_BASIS_…
    pub basis: u32,
    /// Degree of the curve's polynomials, whatever their number: 3 of a cubic B-spline; of a Fourier series its harmonics.
    pub degree: u32,
    /// How many control points are meant; what lies behind them in the arrays is stale.
    pub count: u32,
    /// How many points of the centerline were fitted: N.
    pub samples: u32,
    /// 1 if the rope is closed.
    pub closed: u32,
    /// Which ends leave the image: bit 0 the first, bit 1 the last.
    pub border: u32,
    /// Root mean square distance of the points from the curve at their rho, in the message's unit.
    pub rms: f64,
    /// Largest such distance.
    pub max: f64,
    /// Variance of one coordinate's residual: the sum of squares over its degrees of freedom, 2 (N - count) for plain least squares, in the unit's square.
    pub residual_variance: f64,
    /// Condition number (2-norm) of the regression.
    pub condition: f64,
    /// Arc length of the centerline, in the message's unit.
    pub length: f64,
    /// Median width of the rope, likewise.
    pub width: f64,
    /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
    pub age_ns: u64,
    /// How many of the points were covered by something or outside of the image, and so not seen.
    pub hidden: u32,
    /// 1 if the control points are filtered in time, and have velocities.
    pub filtered: u32,
    /// A LARIAT_FIT_…: whether the curve lies on its points.
    pub fit: u32,
    /// How sure it is that the centerline is a rope's, whole and in order: of those at 0.9, nine of ten are. 0 to 1.
    pub confidence: f32,
    /// The control points, `[x, y]` in the message's unit.
    pub control_points: [[f64; 2]; LARIAT_MAX_CONTROL_POINTS],
    /// Their weights: rational bases only, 1 elsewhere.
    pub weights: [f64; LARIAT_MAX_CONTROL_POINTS],
    /// Covariance of the coordinates of each control point, `[xx, xy, yy]`, in the unit's square.
    pub covariances: [[f64; 3]; LARIAT_MAX_CONTROL_POINTS],
    /// Velocity of each control point, in units a second; 0 where they are not filtered.
    pub velocities: [[f64; 2]; LARIAT_MAX_CONTROL_POINTS],
    /// The inner knots of a B-spline, `count - degree - 1` of them, ascending within 0 and 1; outside stand `degree + 1` times 0 and as many times 1.
    pub knots: [f64; LARIAT_MAX_CONTROL_POINTS],
}

/// The points that a rope's curve was fitted to, at equal steps of arc length, in the message's unit, unfiltered.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_centerline {
    /// How many points are meant; 0 if the writer has none to give.
    pub count: u32,
    /// 1 if the rope is closed: the last point is followed by the first.
    pub closed: u32,
    /// Which points are covered by something or outside of the image, and so not seen: bit i % 32 of word i / 32 is point i.
    pub hidden: [u32; LARIAT_HIDDEN_WORDS],
    /// The points, `[x, y]`.
    pub points: [[f32; 2]; LARIAT_MAX_POINTS],
    /// The rope's width at each point.
    pub widths: [f32; LARIAT_MAX_POINTS],
}

/// What the chain says of one frame.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_descriptors {
    /// The frame's whole way.
    pub trace: lariat_trace,
    /// Width of the image in pixels; 0 while the camera gives none.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// How many curves are meant. 0 is an answer: there is no rope.
    pub count: u32,
    /// A LARIAT_UNIT_…: what the curves are measured in.
    pub unit: u32,
    /// The curves.
    pub ropes: [lariat_descriptor; LARIAT_MAX_ROPES],
    /// The points of each curve, in the same order.
    pub centerlines: [lariat_centerline; LARIAT_MAX_ROPES],
}

/// One rope's shape in space as a few control points, in millimetres. It has one unless `place` says why not.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_descriptor3 {
    /// The rope's number; it keeps it from frame to frame, and has it in the image, too.
    pub track: u32,
    /// A LARIAT_STATUS_…: what the colour image shows of it.
    pub status: u32,
    /// A LARIAT_PLACE_…: whether it is known where the rope is, or why not.
    pub place: u32,
    /// A LARIAT_BASIS_…
    pub basis: u32,
    /// Degree of the curve's polynomials, whatever their number: 3 of a cubic B-spline; of a Fourier series its harmonics.
    pub degree: u32,
    /// How many control points are meant; 0 where there is no shape.
    pub count: u32,
    /// How many points of the centerline were fitted: N.
    pub samples: u32,
    /// 1 if the rope is closed.
    pub closed: u32,
    /// Which ends leave the colour image: bit 0 the first, bit 1 the last.
    pub border: u32,
    /// How many of the centerline's points are measured. The others are bridged.
    pub measured: u32,
    /// 1 if the control points are filtered in time, and have velocities.
    pub filtered: u32,
    /// A LARIAT_FIT_…: whether the curve lies on its points.
    pub fit: u32,
    /// How sure it is that the centerline is a rope's, whole and in order: of those at 0.9, nine of ten are. 0 to 1.
    pub confidence: f32,
    /// Always 0.
    pub reserved: u32,
    /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
    pub age_ns: u64,
    /// Root mean square distance of the points from the curve at their rho, mm.
    pub rms: f64,
    /// Largest such distance, mm.
    pub max: f64,
    /// Arc length of the centerline, mm.
    pub length: f64,
    /// Median width of the rope, mm.
    pub width: f64,
    /// The control points, `[x, y, z]`, mm.
    pub control_points: [[f64; 3]; LARIAT_MAX_CONTROL_POINTS],
    /// Their weights: rational bases only, 1 elsewhere.
    pub weights: [f64; LARIAT_MAX_CONTROL_POINTS],
    /// Covariance of the coordinates of each control point, `[xx, xy, xz, yy, yz, zz]`, mm².
    pub covariances: [[f64; 6]; LARIAT_MAX_CONTROL_POINTS],
    /// Velocity of each control point, mm/s; 0 where they are not filtered.
    pub velocities: [[f64; 3]; LARIAT_MAX_CONTROL_POINTS],
    /// The inner knots of a B-spline, `count - degree - 1` of them, ascending within 0 and 1; outside stand `degree + 1` times 0 and as many times 1.
    pub knots: [f64; LARIAT_MAX_CONTROL_POINTS],
    /// The points of the centerline that were fitted, `[x, y, z]`, mm, at equal steps of arc length in space.
    pub points: [[f32; 3]; LARIAT_MAX_POINTS],
    /// The standard deviation of each along the line to the camera, mm.
    pub sigmas: [f32; LARIAT_MAX_POINTS],
}

same_layout!(lariat_trace, wire::Trace:
    sequence = sequence,
    captured = captured,
    extracted = extracted,
    fitted = fitted,
    bridged = bridged,
    exposed_ns = exposed_ns,
    captured_ns = captured_ns,
    extract_started_ns = extract_started_ns,
    extracted_ns = extracted_ns,
    fit_started_ns = fit_started_ns,
    fitted_ns = fitted_ns,
    settings = settings,
    restarts = restarts);
same_layout!(lariat_descriptor, wire::Descriptor:
    track = track,
    status = status,
    basis = basis,
    degree = degree,
    count = count,
    samples = samples,
    closed = closed,
    border = border,
    rms = rms,
    max = max,
    residual_variance = residual_variance,
    condition = condition,
    length = length,
    width = width,
    age_ns = age_ns,
    hidden = hidden,
    filtered = filtered,
    fit = fit,
    confidence = confidence,
    control_points = control_points,
    weights = weights,
    covariances = covariances,
    velocities = velocities,
    knots = knots);
same_layout!(lariat_centerline, wire::CenterlinePoints:
    count = count,
    closed = closed,
    hidden = hidden,
    points = points,
    widths = widths);
same_layout!(lariat_descriptors, wire::Descriptors:
    trace = trace,
    width = width,
    height = height,
    count = count,
    unit = unit,
    ropes = curves,
    centerlines = centerlines);
same_layout!(lariat_descriptor3, wire::Descriptor3:
    track = track,
    status = status,
    place = place,
    basis = basis,
    degree = degree,
    count = count,
    samples = samples,
    closed = closed,
    border = border,
    measured = measured,
    filtered = filtered,
    fit = fit,
    confidence = confidence,
    reserved = reserved,
    age_ns = age_ns,
    rms = rms,
    max = max,
    length = length,
    width = width,
    control_points = control_points,
    weights = weights,
    covariances = covariances,
    velocities = velocities,
    knots = knots,
    points = points,
    sigmas = sigmas);
