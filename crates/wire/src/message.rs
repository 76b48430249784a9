//! The messages that travel between the processes.
//!
//! Each is `#[repr(C)]`, of a fixed size, without pointers and without padding, and made of plain integers and
//! floats only, so that *every* bit pattern is a valid value: a writer may fill a used slot of shared memory in
//! place and leave the rest of it as it was, and a reader in C or Python needs no more than the offsets.
//! `count` fields say how much of an array is meant; what lies behind is stale.
//!
//! The type names end in a version. Change a field, raise the version.

use iceoryx2::prelude::ZeroCopySend;

use crate::codes::{Basis, PixelFormat, Status};

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
        i < MAX_POINTS && self.hidden[i / 32] >> (i % 32) & 1 == 1
    }

    /// Says of each point, in order, whether it is covered.
    pub fn set_hidden(&mut self, hidden: impl IntoIterator<Item = bool>) {
        self.hidden = [0; MAX_POINTS / 32];
        for (i, is_hidden) in hidden.into_iter().take(MAX_POINTS).enumerate() {
            self.hidden[i / 32] |= u32::from(is_hidden) << (i % 32);
        }
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

/// One rope's shape as a few control points.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.Descriptor.v3")]
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
    /// Root mean square distance of the points from the curve at their ρ, in pixels.
    pub rms_px: f64,
    /// Largest such distance.
    pub max_px: f64,
    /// Variance of one coordinate's residual: the sum of squares over its degrees of freedom, 2 (N − count) for
    /// plain least squares, in px².
    pub residual_variance: f64,
    /// Condition number (2-norm) of the regression.
    pub condition: f64,
    /// Arc length of the centerline, in pixels.
    pub length_px: f64,
    /// Median width of the rope, in pixels.
    pub width_px: f64,
    /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
    pub age_ns: u64,
    /// How many of the points were covered by something, and so not seen.
    pub hidden: u32,
    /// 1 if the control points are filtered in time, and have velocities.
    pub filtered: u32,
    /// The control points, `[x, y]` in pixels.
    pub control_points: [[f64; 2]; MAX_CONTROL_POINTS],
    /// Their weights: rational bases only, 1 elsewhere.
    pub weights: [f64; MAX_CONTROL_POINTS],
    /// Variance of either coordinate of each control point, in px².
    pub variances_px2: [f64; MAX_CONTROL_POINTS],
    /// Velocity of each control point, in px/s; 0 where they are not filtered.
    pub velocities_px_s: [[f64; 2]; MAX_CONTROL_POINTS],
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
        rms_px: 0.0,
        max_px: 0.0,
        residual_variance: 0.0,
        condition: 0.0,
        length_px: 0.0,
        width_px: 0.0,
        age_ns: 0,
        hidden: 0,
        filtered: 0,
        control_points: [[0.0; 2]; MAX_CONTROL_POINTS],
        weights: [1.0; MAX_CONTROL_POINTS],
        variances_px2: [0.0; MAX_CONTROL_POINTS],
        velocities_px_s: [[0.0; 2]; MAX_CONTROL_POINTS],
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

    /// The functions that the control points weigh; `None` for a number this version does not know.
    pub const fn basis(&self) -> Option<Basis> {
        Basis::from_code(self.basis)
    }
}

/// What a control loop reads: the shape of every rope in one frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[type_name("lariat.Descriptors.v3")]
pub struct Descriptors {
    /// The frame's whole way.
    pub trace: Trace,
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// How many curves are meant.
    pub count: u32,
    /// Always 0.
    pub reserved: u32,
    /// The curves.
    pub curves: [Descriptor; MAX_CURVES],
}

impl Descriptors {
    /// The curves that are meant.
    pub fn curves(&self) -> &[Descriptor] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// A message without curves.
    pub const EMPTY: Self = Self {
        trace: Trace::EMPTY,
        width: 0,
        height: 0,
        count: 0,
        reserved: 0,
        curves: [Descriptor::EMPTY; MAX_CURVES],
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
        assert_eq!(offset_of!(Descriptor, rms_px), 32);
        assert_eq!(offset_of!(Descriptor, age_ns), 80);
        assert_eq!(offset_of!(Descriptor, hidden), 88);
        assert_eq!(offset_of!(Descriptor, control_points), 96);
        assert_eq!(offset_of!(Descriptor, weights), 96 + 32 * 16);
        assert_eq!(offset_of!(Descriptor, variances_px2), 96 + 32 * 24);
        assert_eq!(offset_of!(Descriptor, velocities_px_s), 96 + 32 * 32);
        assert_eq!(offset_of!(Descriptor, knots), 96 + 32 * 48);
        assert_eq!(size_of::<Descriptor>(), 96 + 32 * 56);
        assert_eq!(offset_of!(Descriptors, curves), 96);
        assert_eq!(size_of::<Descriptors>(), 96 + 8 * 1888);
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
