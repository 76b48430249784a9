//! The messages that travel between the processes.
//!
//! Each is `#[repr(C)]`, of a fixed size, without pointers and without padding, and made of plain integers and
//! floats only, so that *every* bit pattern is a valid value: a writer may fill a used slot of shared memory in
//! place and leave the rest of it as it was, and a reader in C or Python needs no more than the offsets.
//! `count` fields say how much of an array is meant; what lies behind is stale.
//!
//! The type names end in a version. Change a field, raise the version.

use iceoryx2::prelude::ZeroCopySend;

use crate::codes::{Basis, FitQuality, PixelFormat, Status, Unit};

/// Most curves in one frame.
pub const MAX_CURVES: usize = 8;
/// Most points of one centerline.
pub const MAX_POINTS: usize = 256;
/// Most control points of one descriptor.
pub const MAX_CONTROL_POINTS: usize = 32;
/// Most crossings reported for one frame.
pub const MAX_CROSSINGS: usize = 32;

/// The way of one frame through the chain. Every message carries it; every stage adds its own lines.
///
/// The counters make every loss a difference: of two consecutive messages, what `sequence` advanced more than
/// `captured` was lost at the source, what `captured` advanced more than `extracted` between capture and extract, and
/// so on. All times are nanoseconds of `CLOCK_MONOTONIC`, 0 before they are known.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("lariat.Trace.v1")]
pub struct Trace {
    /// The source's own frame number, from 1.
    pub sequence: u64,
    /// How many frames capture has sent, this one included.
    pub captured: u64,
    /// How many frames extract has sent, this one included.
    pub extracted: u64,
    /// How many frames fit has sent, this one included.
    pub fitted: u64,
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
}

impl Trace {
    /// A way not begun.
    pub const EMPTY: Self = Self {
        sequence: 0,
        captured: 0,
        extracted: 0,
        fitted: 0,
        exposed_ns: 0,
        captured_ns: 0,
        extract_started_ns: 0,
        extracted_ns: 0,
        fit_started_ns: 0,
        fitted_ns: 0,
    };
}

/// What stands beside the bytes of a frame.
///
/// It fills two cache lines and begins on one, and so do the bytes that follow it. (The transport's own way to align
/// the bytes would align each of them, and take 64 times the memory.)
#[repr(C)]
#[repr(align(64))]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("lariat.FrameHeader.v1")]
pub struct FrameHeader {
    /// The frame's way so far.
    pub trace: Trace,
    /// Pixels in a row; 0 if there is [no image](Self::is_blank).
    pub width: u32,
    /// Rows; 0 likewise.
    pub height: u32,
    /// Bytes from one row's start to the next.
    pub stride: u32,
    /// A [`PixelFormat`]'s number.
    pub pixel_format: u32,
    /// A [`SourceKind`](crate::SourceKind)'s number.
    pub source: u32,
    /// Always 0.
    pub reserved: [u32; 7],
}

impl FrameHeader {
    /// How the bytes make pixels; `None` for a number this version does not know.
    pub const fn format(&self) -> Option<PixelFormat> {
        PixelFormat::from_code(self.pixel_format)
    }

    /// Whether there is no image: the source has none to give, though it is time for one. A reader has nothing to look at
    /// then, and sends on what it knows without.
    pub const fn is_blank(&self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// What stands beside a mask of this frame: `Gray8` of its size, rows one after the other, with its trace.
    pub const fn of_mask(&self) -> Self {
        Self {
            stride: self.width,
            pixel_format: PixelFormat::Gray8 as u32,
            ..*self
        }
    }

    /// Bytes of the whole image as the header describes it; `None` if the format is unknown or a row does not fit its stride.
    pub fn image_bytes(&self) -> Option<usize> {
        let format = self.format()?;
        (format.row_bytes(self.width) <= self.stride as usize)
            .then(|| format.image_bytes(self.stride, self.height))
    }
}

/// One rope's centerline: points at equal steps of arc length, in pixels of the full image (x right, y down, the
/// centre of the top-left pixel is (0, 0)).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.Curve.v2")]
pub struct Curve {
    /// The rope's number; it keeps it from frame to frame.
    pub track: u32,
    /// A [`Status`]'s number.
    pub status: u32,
    /// 1 if the rope is closed: the last point is followed by the first.
    pub closed: u32,
    /// Which ends leave the image: bit 0 the first, bit 1 the last.
    pub border: u32,
    /// How many points are meant.
    pub count: u32,
    /// Median width of the rope in the image.
    pub width_px: f32,
    /// Arc length of the centerline.
    pub length_px: f32,
    /// Always 0.
    pub reserved: u32,
    /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
    pub age_ns: u64,
    /// Which points are covered by something, and so not seen: bit i % 32 of word i / 32 is point i.
    pub hidden: [u32; MAX_POINTS / 32],
    /// The points, `[x, y]`.
    pub points: [[f32; 2]; MAX_POINTS],
    /// The width at each point.
    pub widths_px: [f32; MAX_POINTS],
}

impl Curve {
    /// A curve without points.
    pub const EMPTY: Self = Self {
        track: 0,
        status: Status::Ok as u32,
        closed: 0,
        border: 0,
        count: 0,
        width_px: 0.0,
        length_px: 0.0,
        reserved: 0,
        age_ns: 0,
        hidden: [0; MAX_POINTS / 32],
        points: [[0.0; 2]; MAX_POINTS],
        widths_px: [0.0; MAX_POINTS],
    };

    /// The points that are meant.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points[..(self.count as usize).min(MAX_POINTS)]
    }

    /// The widths at those points.
    pub fn widths_px(&self) -> &[f32] {
        &self.widths_px[..(self.count as usize).min(MAX_POINTS)]
    }

    /// Whether point `i` is covered by something, and so not seen.
    pub const fn is_hidden(&self, i: usize) -> bool {
        bit(&self.hidden, i)
    }

    /// Says of each point, in order, whether it is covered.
    pub fn set_hidden(&mut self, hidden: impl IntoIterator<Item = bool>) {
        self.hidden = mask(hidden);
    }

    /// What is known of the rope; `None` for a number this version does not know.
    pub const fn status(&self) -> Option<Status> {
        Status::from_code(self.status)
    }
}

/// Where a strand lies over a strand.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.Crossing.v1")]
pub struct Crossing {
    /// Where, `[x, y]` in pixels.
    pub at: [f32; 2],
    /// The upper strand's rope, an index into [`Centerlines::curves`].
    pub over: u32,
    /// The lower strand's rope, likewise.
    pub under: u32,
    /// Where along the upper rope, as normalized arc length.
    pub over_rho: f32,
    /// Where along the lower rope, likewise.
    pub under_rho: f32,
    /// How sure it is which strand is the upper one: 0 (not known) to 1.
    pub confidence: f32,
    /// Always 0.
    pub reserved: u32,
}

impl Crossing {
    /// A crossing of nothing.
    pub const EMPTY: Self = Self {
        at: [0.0; 2],
        over: 0,
        under: 0,
        over_rho: 0.0,
        under_rho: 0.0,
        confidence: 0.0,
        reserved: 0,
    };
}

/// What extract saw in one frame. No rope is an answer too: `count` is 0.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.Centerlines.v2")]
pub struct Centerlines {
    /// The frame's way so far.
    pub trace: Trace,
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// How many curves are meant.
    pub count: u32,
    /// How many crossings are meant.
    pub crossing_count: u32,
    /// The curves.
    pub curves: [Curve; MAX_CURVES],
    /// The crossings.
    pub crossings: [Crossing; MAX_CROSSINGS],
}

impl Centerlines {
    /// The curves that are meant.
    pub fn curves(&self) -> &[Curve] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// The crossings that are meant.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings[..(self.crossing_count as usize).min(MAX_CROSSINGS)]
    }

    /// A message without curves.
    pub const EMPTY: Self = Self {
        trace: Trace::EMPTY,
        width: 0,
        height: 0,
        count: 0,
        crossing_count: 0,
        curves: [Curve::EMPTY; MAX_CURVES],
        crossings: [Crossing::EMPTY; MAX_CROSSINGS],
    };
}

/// One rope's shape as a few control points, in the message's unit ([`Descriptors::unit`]).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.Descriptor.v5")]
pub struct Descriptor {
    /// The rope's number; it keeps it from frame to frame.
    pub track: u32,
    /// A [`Status`]'s number.
    pub status: u32,
    /// A [`Basis`]'s number.
    pub basis: u32,
    /// Degree of the curve; of a Fourier series the number of its harmonics.
    pub order: u32,
    /// How many control points are meant.
    pub count: u32,
    /// How many points of the centerline were fitted: N.
    pub samples: u32,
    /// 1 if the rope is closed.
    pub closed: u32,
    /// Which ends leave the image: bit 0 the first, bit 1 the last.
    pub border: u32,
    /// Root mean square distance of the points from the curve at their ρ, in the message's unit.
    pub rms: f64,
    /// Largest such distance.
    pub max: f64,
    /// Variance of one coordinate's residual: the sum of squares over its degrees of freedom, 2 (N − count) for
    /// plain least squares, in the unit's square.
    pub residual_variance: f64,
    /// Condition number (2-norm) of the regression.
    pub condition: f64,
    /// Arc length of the centerline, in the message's unit.
    pub length: f64,
    /// Median width of the rope, likewise.
    pub width: f64,
    /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
    pub age_ns: u64,
    /// How many of the points were covered by something, and so not seen.
    pub hidden: u32,
    /// 1 if the control points are filtered in time, and have velocities.
    pub filtered: u32,
    /// A [`FitQuality`]'s number: whether the curve lies on its points.
    pub fit: u32,
    /// Always 0.
    pub reserved: u32,
    /// The control points, `[x, y]` in the message's unit.
    pub control_points: [[f64; 2]; MAX_CONTROL_POINTS],
    /// Their weights: rational bases only, 1 elsewhere.
    pub weights: [f64; MAX_CONTROL_POINTS],
    /// Covariance of the coordinates of each control point, `[xx, xy, yy]`, in the unit's square.
    pub covariances: [[f64; 3]; MAX_CONTROL_POINTS],
    /// Velocity of each control point, in units a second; 0 where they are not filtered.
    pub velocities: [[f64; 2]; MAX_CONTROL_POINTS],
    /// The inner knots of a B-spline, `count − order − 1` of them, ascending within 0 and 1; outside stand
    /// `order + 1` times 0 and as many times 1.
    pub knots: [f64; MAX_CONTROL_POINTS],
}

impl Descriptor {
    /// A descriptor without control points.
    pub const EMPTY: Self = Self {
        track: 0,
        status: Status::Ok as u32,
        basis: Basis::Bezier as u32,
        order: 0,
        count: 0,
        samples: 0,
        closed: 0,
        border: 0,
        rms: 0.0,
        max: 0.0,
        residual_variance: 0.0,
        condition: 0.0,
        length: 0.0,
        width: 0.0,
        age_ns: 0,
        hidden: 0,
        filtered: 0,
        fit: FitQuality::NotJudged as u32,
        reserved: 0,
        control_points: [[0.0; 2]; MAX_CONTROL_POINTS],
        weights: [1.0; MAX_CONTROL_POINTS],
        covariances: [[0.0; 3]; MAX_CONTROL_POINTS],
        velocities: [[0.0; 2]; MAX_CONTROL_POINTS],
        knots: [0.0; MAX_CONTROL_POINTS],
    };

    /// The control points that are meant.
    pub fn control_points(&self) -> &[[f64; 2]] {
        &self.control_points[..(self.count as usize).min(MAX_CONTROL_POINTS)]
    }

    /// What is known of the rope; `None` for a number this version does not know.
    pub const fn status(&self) -> Option<Status> {
        Status::from_code(self.status)
    }

    /// Whether the curve lies on its points; `None` for a number this version does not know.
    pub const fn fit(&self) -> Option<FitQuality> {
        FitQuality::from_code(self.fit)
    }

    /// The functions that the control points weigh; `None` for a number this version does not know.
    pub const fn basis(&self) -> Option<Basis> {
        Basis::from_code(self.basis)
    }
}

/// The points that a descriptor was fitted to: the rope's centerline, at equal steps of arc length, in the message's unit.
/// They are as the image has them, unfiltered, however well the curve lies on them.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.CenterlinePoints.v1")]
pub struct CenterlinePoints {
    /// How many points are meant; 0 if the writer has none to give.
    pub count: u32,
    /// 1 if the rope is closed: the last point is followed by the first.
    pub closed: u32,
    /// Which points are covered by something, and so not seen: bit i % 32 of word i / 32 is point i.
    pub hidden: [u32; MAX_POINTS / 32],
    /// The points, `[x, y]`.
    pub points: [[f32; 2]; MAX_POINTS],
    /// The rope's width at each point.
    pub widths: [f32; MAX_POINTS],
}

impl CenterlinePoints {
    /// No points.
    pub const EMPTY: Self = Self {
        count: 0,
        closed: 0,
        hidden: [0; MAX_POINTS / 32],
        points: [[0.0; 2]; MAX_POINTS],
        widths: [0.0; MAX_POINTS],
    };

    /// The points that are meant.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points[..(self.count as usize).min(MAX_POINTS)]
    }

    /// The widths at those points.
    pub fn widths(&self) -> &[f32] {
        &self.widths[..(self.count as usize).min(MAX_POINTS)]
    }

    /// Whether point `i` is covered by something, and so not seen.
    pub const fn is_hidden(&self, i: usize) -> bool {
        bit(&self.hidden, i)
    }

    /// Says of each point, in order, whether it is covered.
    pub fn set_hidden(&mut self, hidden: impl IntoIterator<Item = bool>) {
        self.hidden = mask(hidden);
    }
}

/// Bit `i` of a mask of points.
const fn bit(mask: &[u32; MAX_POINTS / 32], i: usize) -> bool {
    i < MAX_POINTS && mask[i / 32] >> (i % 32) & 1 == 1
}

/// A mask of points with these bits, in order.
fn mask(bits: impl IntoIterator<Item = bool>) -> [u32; MAX_POINTS / 32] {
    let mut mask = [0; MAX_POINTS / 32];
    for (i, is_set) in bits.into_iter().take(MAX_POINTS).enumerate() {
        mask[i / 32] |= u32::from(is_set) << (i % 32);
    }
    mask
}

/// What a control loop reads: the shape of every rope in one frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.Descriptors.v5")]
pub struct Descriptors {
    /// The frame's whole way.
    pub trace: Trace,
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// How many curves are meant.
    pub count: u32,
    /// A [`Unit`]'s number: what the curves are measured in.
    pub unit: u32,
    /// The curves.
    pub curves: [Descriptor; MAX_CURVES],
    /// The points of each: entry `i` is of `curves[i]`.
    pub centerlines: [CenterlinePoints; MAX_CURVES],
}

impl Descriptors {
    /// What the curves are measured in; `None` for a number this version does not know.
    pub const fn unit(&self) -> Option<Unit> {
        Unit::from_code(self.unit)
    }

    /// The curves that are meant.
    pub fn curves(&self) -> &[Descriptor] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// The points of those curves.
    pub fn centerlines(&self) -> &[CenterlinePoints] {
        &self.centerlines[..(self.count as usize).min(MAX_CURVES)]
    }

    /// A message without curves.
    pub const EMPTY: Self = Self {
        trace: Trace::EMPTY,
        width: 0,
        height: 0,
        count: 0,
        unit: Unit::Pixel as u32,
        curves: [Descriptor::EMPTY; MAX_CURVES],
        centerlines: [CenterlinePoints::EMPTY; MAX_CURVES],
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SourceKind;
    use std::mem::{offset_of, size_of};

    #[test]
    fn the_layout_is_what_readers_in_other_languages_were_told() {
        assert_eq!(size_of::<Trace>(), 80);
        assert_eq!(size_of::<FrameHeader>(), 128);
        assert_eq!(align_of::<FrameHeader>(), 64);
        assert_eq!(offset_of!(FrameHeader, width), 80);
        assert_eq!(offset_of!(FrameHeader, pixel_format), 92);
        assert_eq!(size_of::<Curve>(), 72 + 256 * 8 + 256 * 4);
        assert_eq!(offset_of!(Curve, age_ns), 32);
        assert_eq!(offset_of!(Curve, hidden), 40);
        assert_eq!(offset_of!(Curve, points), 72);
        assert_eq!(offset_of!(Curve, widths_px), 72 + 256 * 8);
        assert_eq!(size_of::<Crossing>(), 32);
        assert_eq!(offset_of!(Centerlines, curves), 96);
        assert_eq!(offset_of!(Centerlines, crossings), 96 + 8 * 3144);
        assert_eq!(size_of::<Centerlines>(), 96 + 8 * 3144 + 32 * 32);
        assert_eq!(offset_of!(Descriptor, rms), 32);
        assert_eq!(offset_of!(Descriptor, age_ns), 80);
        assert_eq!(offset_of!(Descriptor, hidden), 88);
        assert_eq!(offset_of!(Descriptor, fit), 96);
        assert_eq!(offset_of!(Descriptor, control_points), 104);
        assert_eq!(offset_of!(Descriptor, weights), 104 + 32 * 16);
        assert_eq!(offset_of!(Descriptor, covariances), 104 + 32 * 24);
        assert_eq!(offset_of!(Descriptor, velocities), 104 + 32 * 48);
        assert_eq!(offset_of!(Descriptor, knots), 104 + 32 * 64);
        assert_eq!(size_of::<Descriptor>(), 104 + 32 * 72);
        assert_eq!(offset_of!(CenterlinePoints, closed), 4);
        assert_eq!(offset_of!(CenterlinePoints, hidden), 8);
        assert_eq!(offset_of!(CenterlinePoints, points), 40);
        assert_eq!(offset_of!(CenterlinePoints, widths), 40 + 256 * 8);
        assert_eq!(size_of::<CenterlinePoints>(), 40 + 256 * 12);
        assert_eq!(offset_of!(Descriptors, unit), 92);
        assert_eq!(offset_of!(Descriptors, curves), 96);
        assert_eq!(offset_of!(Descriptors, centerlines), 96 + 8 * 2408);
        assert_eq!(size_of::<Descriptors>(), 96 + 8 * (2408 + 3112));
    }

    #[test]
    fn every_point_has_a_bit_of_its_own_that_says_whether_it_is_hidden() {
        let mut curve = Curve::EMPTY;
        curve.hidden = [u32::MAX; 8];
        curve.set_hidden((0..MAX_POINTS).map(|i| i % 37 == 5));
        assert!((0..MAX_POINTS).all(|i| curve.is_hidden(i) == (i % 37 == 5)));
        assert!(!curve.is_hidden(MAX_POINTS));
    }

    #[test]
    fn a_header_that_lies_about_its_rows_has_no_size() {
        let header = FrameHeader {
            trace: Trace::EMPTY,
            width: 640,
            height: 480,
            stride: 1920,
            pixel_format: PixelFormat::Rgb8 as u32,
            source: SourceKind::Files as u32,
            reserved: [0; 7],
        };
        assert_eq!(header.image_bytes(), Some(640 * 480 * 3));
        assert_eq!(
            FrameHeader {
                stride: 1919,
                ..header
            }
            .image_bytes(),
            None
        );
        assert_eq!(
            FrameHeader {
                pixel_format: 99,
                ..header
            }
            .image_bytes(),
            None
        );
    }
}
