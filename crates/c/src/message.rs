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

// Generated from the messages' declarations: LARIAT_WRITE_LAYOUTS=1 cargo test -p lariat-message

/// Fully visible (lariat_descriptor.status).
pub const LARIAT_STATUS_OK: u32 = 1;
/// Partly covered.
pub const LARIAT_STATUS_PARTIAL: u32 = 2;
/// Not visible; the curve is the last known shape.
pub const LARIAT_STATUS_LOST: u32 = 3;
/// Fully visible, but possibly not a rope: a shadow, a pen, an edge.
pub const LARIAT_STATUS_DOUBTFUL: u32 = 4;

/// Bernstein polynomials of this `degree` (lariat_descriptor.basis).
pub const LARIAT_BASIS_BEZIER: u32 = 1;
/// Clamped B-spline of this `degree`; the message has its inner knots.
pub const LARIAT_BASIS_BSPLINE: u32 = 2;
/// Rational Bernstein functions of this `degree`.
pub const LARIAT_BASIS_RATIONAL: u32 = 3;
/// Fourier series of `degree` harmonics, for closed shapes. Control points are coefficients `a₀, a₁, b₁, a₂, b₂, …` of `1, cos 2π·rho, sin 2π·rho, cos 4π·rho, …`.
pub const LARIAT_BASIS_FOURIER: u32 = 4;
/// Centerline points at equal arc length, joined by straight lines.
pub const LARIAT_BASIS_POINTS: u32 = 5;
/// The mean of all points, as one control point.
pub const LARIAT_BASIS_MASS: u32 = 6;

/// Not checked by the writer (lariat_descriptor.fit).
pub const LARIAT_FIT_NOT_JUDGED: u32 = 0;
/// The curve is within the chain's tolerance of its points.
pub const LARIAT_FIT_GOOD: u32 = 1;
/// The curve deviates, for example with too few control points; the points are correct.
pub const LARIAT_FIT_COARSE: u32 = 2;

/// Pixels of the original image (lariat_descriptors.unit).
pub const LARIAT_UNIT_PX: u32 = 1;
/// Millimeters on a plane.
pub const LARIAT_UNIT_MM: u32 = 2;
/// Pixels of the same camera without lens distortion.
pub const LARIAT_UNIT_IDEAL_PX: u32 = 3;

/// Measured (lariat_descriptor3.place).
pub const LARIAT_PLACE_KNOWN: u32 = 1;
/// Not visible in the color image; last known position.
pub const LARIAT_PLACE_BEFORE: u32 = 2;
/// Too few depths: out of the other camera's range or view.
pub const LARIAT_PLACE_UNMEASURED: u32 = 3;
/// Thinner than three pixels of the depth image.
pub const LARIAT_PLACE_THIN: u32 = 4;
/// No depth image, or no second image near enough in time.
pub const LARIAT_PLACE_NO_PARTNER: u32 = 5;
/// Invalid depth image, second image or calibration; the chain reports why.
pub const LARIAT_PLACE_UNREADABLE: u32 = 6;

/// Counters and times of one frame on its way through the chain. ARCHITECTURE.md explains how they show losses.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_trace {
    /// Frame number of the source, from 1.
    pub sequence: u64,
    /// Frames sent by capture, including this one.
    pub captured: u64,
    /// Frames sent by extract, including this one.
    pub extracted: u64,
    /// Frames sent by fit, including this one.
    pub fitted: u64,
    /// Messages of this channel that a local bridge has written, including this one; 0 without a bridge, and for images.
    pub bridged: u64,
    /// Exposure time: the driver's timestamp, or the due time of a file's frame.
    pub exposed_ns: u64,
    /// End of capture, before sending.
    pub captured_ns: u64,
    /// Start of extract.
    pub extract_started_ns: u64,
    /// End of extract, before sending.
    pub extracted_ns: u64,
    /// Start of fit.
    pub fit_started_ns: u64,
    /// End of fit, before sending.
    pub fitted_ns: u64,
    /// Settings version of the sender: number of changes since the chain's start.
    pub settings: u32,
    /// Restarts of capture, extract and fit modulo 256, one byte each, capture in the lowest.
    pub restarts: u32,
}

/// One rope's shape as a few control points, in the message's unit.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_descriptor {
    /// Rope number, constant across frames.
    pub track: u32,
    /// A LARIAT_STATUS_…
    pub status: u32,
    /// A LARIAT_BASIS_…
    pub basis: u32,
    /// Polynomial degree (cubic: 3); harmonics of a Fourier series.
    pub degree: u32,
    /// Number of valid control points.
    pub count: u32,
    /// Number of fitted centerline points, N.
    pub samples: u32,
    /// 1 if closed.
    pub closed: u32,
    /// Ends that leave the image: bit 0 first, bit 1 last.
    pub border: u32,
    /// RMS distance of points from the curve at their rho.
    pub rms: f64,
    /// Maximum distance.
    pub max: f64,
    /// Residual variance per coordinate, unit squared: sum of squares over degrees of freedom, 2 (N - count) for plain least squares.
    pub residual_variance: f64,
    /// Condition number (2-norm) of the regression.
    pub condition: f64,
    /// Arc length of the centerline.
    pub length: f64,
    /// Median width of the rope.
    pub width: f64,
    /// Time from the last sighting to this image; 0 unless lost.
    pub age_ns: u64,
    /// Number of points covered or outside the image.
    pub hidden: u32,
    /// 1 if filtered over time, with velocities.
    pub filtered: u32,
    /// A LARIAT_FIT_…
    pub fit: u32,
    /// Calibrated probability of a whole, correctly ordered rope.
    pub confidence: f32,
    /// Control points, `[x, y]`.
    pub control_points: [[f64; 2]; LARIAT_MAX_CONTROL_POINTS],
    /// Weights of a rational basis; 1 elsewhere.
    pub weights: [f64; LARIAT_MAX_CONTROL_POINTS],
    /// Covariance of each control point, `[xx, xy, yy]`, unit squared.
    pub covariances: [[f64; 3]; LARIAT_MAX_CONTROL_POINTS],
    /// Velocity of each control point, units/s; 0 if unfiltered.
    pub velocities: [[f64; 2]; LARIAT_MAX_CONTROL_POINTS],
    /// The `count - degree - 1` inner knots of a B-spline, ascending, between `degree + 1` zeros and as many ones.
    pub knots: [f64; LARIAT_MAX_CONTROL_POINTS],
}

/// The points that a rope's curve was fitted to, at equal steps of arc length, in the message's unit, unfiltered.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_centerline {
    /// Number of valid points; 0 if the writer gives none.
    pub count: u32,
    /// 1 if closed: the first point follows the last.
    pub closed: u32,
    /// Points covered or outside the image: bit `i % 32` of word `i / 32`.
    pub hidden: [u32; LARIAT_HIDDEN_WORDS],
    /// Points, `[x, y]`.
    pub points: [[f32; 2]; LARIAT_MAX_POINTS],
    /// Width of the rope at each point.
    pub widths: [f32; LARIAT_MAX_POINTS],
}

/// The chain's message for one frame.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_descriptors {
    /// Complete trace of the frame.
    pub trace: lariat_trace,
    /// Image width in pixels; 0 while the camera gives no image.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Number of valid curves; 0 means no rope.
    pub count: u32,
    /// A LARIAT_UNIT_…: unit of the curves.
    pub unit: u32,
    /// Curves.
    pub ropes: [lariat_descriptor; LARIAT_MAX_ROPES],
    /// Points of each curve, in the same order.
    pub centerlines: [lariat_centerline; LARIAT_MAX_ROPES],
}

/// One rope's shape in space as a few control points, in millimetres. It has one unless `place` says why not.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_descriptor3 {
    /// Rope number, as in the image.
    pub track: u32,
    /// A LARIAT_STATUS_…, from the color image.
    pub status: u32,
    /// A LARIAT_PLACE_…
    pub place: u32,
    /// A LARIAT_BASIS_…
    pub basis: u32,
    /// Polynomial degree (cubic: 3); harmonics of a Fourier series.
    pub degree: u32,
    /// Number of valid control points; 0 without a shape.
    pub count: u32,
    /// Number of fitted centerline points, N.
    pub samples: u32,
    /// 1 if closed.
    pub closed: u32,
    /// Ends that leave the color image: bit 0 first, bit 1 last.
    pub border: u32,
    /// Number of measured centerline points; the others are interpolated.
    pub measured: u32,
    /// 1 if filtered over time, with velocities.
    pub filtered: u32,
    /// A LARIAT_FIT_…
    pub fit: u32,
    /// Calibrated probability of a whole, correctly ordered rope.
    pub confidence: f32,
    /// Always 0.
    pub reserved: u32,
    /// Time from the last sighting to this image; 0 unless lost.
    pub age_ns: u64,
    /// RMS distance of points from the curve at their rho, mm.
    pub rms: f64,
    /// Maximum distance, mm.
    pub max: f64,
    /// Arc length of the centerline, mm.
    pub length: f64,
    /// Median width of the rope, mm.
    pub width: f64,
    /// Control points, `[x, y, z]`, mm.
    pub control_points: [[f64; 3]; LARIAT_MAX_CONTROL_POINTS],
    /// Weights of a rational basis; 1 elsewhere.
    pub weights: [f64; LARIAT_MAX_CONTROL_POINTS],
    /// Covariance of each control point, `[xx, xy, xz, yy, yz, zz]`, mm².
    pub covariances: [[f64; 6]; LARIAT_MAX_CONTROL_POINTS],
    /// Velocity of each control point, mm/s; 0 if unfiltered.
    pub velocities: [[f64; 3]; LARIAT_MAX_CONTROL_POINTS],
    /// The `count - degree - 1` inner knots of a B-spline, ascending, between `degree + 1` zeros and as many ones.
    pub knots: [f64; LARIAT_MAX_CONTROL_POINTS],
    /// Fitted centerline points, `[x, y, z]`, mm, at equal steps of arc length in space.
    pub points: [[f32; 3]; LARIAT_MAX_POINTS],
    /// Standard deviation of each point along the line of sight, mm.
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
