//! Output of extract for one frame: centerlines and their crossings.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use super::hidden::{self, is_hidden};
use crate::{MAX_CROSSINGS, MAX_CURVES, MAX_POINTS, Status, Trace};

message! {
    /// One rope's centerline: points at equal steps of arc length, in pixels of the full image. x
    /// points right and y down; the center of the top-left pixel is (0, 0).
    pub struct Curve = "lariat.Curve.v3" {
        /// Rope number, constant across frames.
        track: u32 = 0 => number,
        /// A [`Status`]'s number.
        status: u32 = Status::Ok as u32 => code(Status),
        /// 1 if closed: the first point follows the last.
        closed: u32 = 0 => flag,
        /// Ends that leave the image: bit 0 first, bit 1 last.
        border: u32 = 0 => ends,
        /// Number of valid points.
        count: u32 = 0 => count(points),
        /// Median width of the rope.
        width_px: f32 = 0.0 => number,
        /// Arc length of the centerline.
        length_px: f32 = 0.0 => number,
        /// Calibrated probability of a whole, correctly ordered rope.
        confidence: f32 = 0.0 => number,
        /// Time from the last sighting to this image; 0 unless lost.
        age_ns: u64 = 0 => number,
        /// Points covered or outside the image: bit `i % 32` of word `i / 32`.
        hidden: [u32; MAX_POINTS / 32] = [0; MAX_POINTS / 32] => hidden(points),
        /// Points, `[x, y]`.
        points: [[f32; 2]; MAX_POINTS] = [[0.0; 2]; MAX_POINTS] => points(points),
        /// Width at each point.
        widths_px: [f32; MAX_POINTS] = [0.0; MAX_POINTS] => list(widths_px),
    }
}

impl Curve {
    /// The valid points.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points[..(self.count as usize).min(MAX_POINTS)]
    }

    /// The widths at those points.
    pub fn widths_px(&self) -> &[f32] {
        &self.widths_px[..(self.count as usize).min(MAX_POINTS)]
    }

    /// Returns whether point `i` is covered or outside the image, and so not visible.
    pub const fn is_hidden(&self, i: usize) -> bool {
        is_hidden(&self.hidden, i)
    }

    /// Sets for each point, in order, whether it is covered or outside the image.
    pub fn set_hidden(&mut self, hidden: impl IntoIterator<Item = bool>) {
        self.hidden = hidden::hidden(hidden);
    }

    /// Visibility of the rope; `None` for a number this version does not know.
    pub const fn status(&self) -> Option<Status> {
        Status::from_code(self.status)
    }
}

message! {
    /// A point where one strand passes over another.
    pub struct Crossing = "lariat.Crossing.v1" {
        /// Position, `[x, y]` in pixels.
        at: [f32; 2] = [0.0; 2] => number,
        /// Rope of the upper strand: an index into [`Centerlines::curves`].
        over: u32 = 0 => number,
        /// Rope of the lower strand.
        under: u32 = 0 => number,
        /// Normalized arc length on the upper rope.
        over_rho: f32 = 0.0 => number,
        /// Normalized arc length on the lower rope.
        under_rho: f32 = 0.0 => number,
        /// Confidence in which strand is on top: 0 (unknown) to 1.
        confidence: f32 = 0.0 => number,
        /// Always 0.
        reserved: u32 = 0 => reserved,
    }
}

message! {
    /// Output of extract for one frame. A frame without a rope is sent too: its `count` is 0.
    pub struct Centerlines = "lariat.Centerlines.v5" {
        /// Trace up to this stage.
        trace: Trace = Trace::EMPTY => message,
        /// Image width in pixels.
        width: u32 = 0 => number,
        /// Image height in pixels.
        height: u32 = 0 => number,
        /// Number of valid curves.
        count: u32 = 0 => count(curves),
        /// Number of valid crossings.
        crossing_count: u32 = 0 => count(crossings),
        /// Curves.
        curves: [Curve; MAX_CURVES] = [Curve::EMPTY; MAX_CURVES] => messages(curves),
        /// Crossings.
        crossings: [Crossing; MAX_CROSSINGS] = [Crossing::EMPTY; MAX_CROSSINGS] => messages(crossings),
    }
}

impl Centerlines {
    /// The valid curves.
    pub fn curves(&self) -> &[Curve] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// Copies the valid part of another message; the rest stays as it was.
    pub fn copy_meant(&mut self, from: &Self) {
        self.trace = from.trace;
        (self.width, self.height) = (from.width, from.height);
        (self.count, self.crossing_count) = (from.count, from.crossing_count);
        self.curves[..from.curves().len()].copy_from_slice(from.curves());
        self.crossings[..from.crossings().len()].copy_from_slice(from.crossings());
    }

    /// The valid crossings.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings[..(self.crossing_count as usize).min(MAX_CROSSINGS)]
    }
}
