//! What extract saw: centerlines, and where they cross.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use super::hidden::{self, is_hidden};
use crate::{MAX_CROSSINGS, MAX_CURVES, MAX_POINTS, Status, Trace};

message! {
    /// One rope's centerline: points at equal steps of arc length, in pixels of the full image (x right, y down, the
    /// centre of the top-left pixel is (0, 0)).
    pub struct Curve = "lariat.Curve.v3" {
        /// The rope's number; it keeps it from frame to frame.
        track: u32 = 0 => number,
        /// A [`Status`]'s number.
        status: u32 = Status::Ok as u32 => code(Status),
        /// 1 if the rope is closed: the last point is followed by the first.
        closed: u32 = 0 => flag,
        /// Which ends leave the image: bit 0 the first, bit 1 the last.
        border: u32 = 0 => ends,
        /// How many points are meant.
        count: u32 = 0 => count(points),
        /// Median width of the rope in the image.
        width_px: f32 = 0.0 => number,
        /// Arc length of the centerline.
        length_px: f32 = 0.0 => number,
        /// How sure it is that the curve is a rope, whole and in order: of those at 0.9, nine of ten are. 0 to 1.
        confidence: f32 = 0.0 => number,
        /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
        age_ns: u64 = 0 => number,
        /// Which points are covered by something or outside of the image, and so not seen: bit i % 32 of word i / 32 is point i.
        hidden: [u32; MAX_POINTS / 32] = [0; MAX_POINTS / 32] => hidden(points),
        /// The points, `[x, y]`.
        points: [[f32; 2]; MAX_POINTS] = [[0.0; 2]; MAX_POINTS] => points(points),
        /// The width at each point.
        widths_px: [f32; MAX_POINTS] = [0.0; MAX_POINTS] => list(widths_px),
    }
}

impl Curve {
    /// The points that are meant.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points[..(self.count as usize).min(MAX_POINTS)]
    }

    /// The widths at those points.
    pub fn widths_px(&self) -> &[f32] {
        &self.widths_px[..(self.count as usize).min(MAX_POINTS)]
    }

    /// Whether point `i` is covered by something or outside of the image, and so not seen.
    pub const fn is_hidden(&self, i: usize) -> bool {
        is_hidden(&self.hidden, i)
    }

    /// Says of each point, in order, whether it is covered.
    pub fn set_hidden(&mut self, hidden: impl IntoIterator<Item = bool>) {
        self.hidden = hidden::hidden(hidden);
    }

    /// What is known of the rope; `None` for a number this version does not know.
    pub const fn status(&self) -> Option<Status> {
        Status::from_code(self.status)
    }
}

message! {
    /// Where a strand lies over a strand.
    pub struct Crossing = "lariat.Crossing.v1" {
        /// Where, `[x, y]` in pixels.
        at: [f32; 2] = [0.0; 2] => number,
        /// The upper strand's rope, an index into [`Centerlines::curves`].
        over: u32 = 0 => number,
        /// The lower strand's rope, likewise.
        under: u32 = 0 => number,
        /// Where along the upper rope, as normalized arc length.
        over_rho: f32 = 0.0 => number,
        /// Where along the lower rope, likewise.
        under_rho: f32 = 0.0 => number,
        /// How sure it is which strand is the upper one: 0 (not known) to 1.
        confidence: f32 = 0.0 => number,
        /// Always 0.
        reserved: u32 = 0 => reserved,
    }
}

message! {
    /// What extract saw in one frame. No rope is an answer too: `count` is 0.
    pub struct Centerlines = "lariat.Centerlines.v5" {
        /// The frame's way so far.
        trace: Trace = Trace::EMPTY => message,
        /// Width of the image in pixels.
        width: u32 = 0 => number,
        /// Height of the image in pixels.
        height: u32 = 0 => number,
        /// How many curves are meant.
        count: u32 = 0 => count(curves),
        /// How many crossings are meant.
        crossing_count: u32 = 0 => count(crossings),
        /// The curves.
        curves: [Curve; MAX_CURVES] = [Curve::EMPTY; MAX_CURVES] => messages(curves),
        /// The crossings.
        crossings: [Crossing; MAX_CROSSINGS] = [Crossing::EMPTY; MAX_CROSSINGS] => messages(crossings),
    }
}

impl Centerlines {
    /// The curves that are meant.
    pub fn curves(&self) -> &[Curve] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// Takes over what another message means; what it does not mean stays as it was.
    pub fn copy_meant(&mut self, from: &Self) {
        self.trace = from.trace;
        (self.width, self.height) = (from.width, from.height);
        (self.count, self.crossing_count) = (from.count, from.crossing_count);
        self.curves[..from.curves().len()].copy_from_slice(from.curves());
        self.crossings[..from.crossings().len()].copy_from_slice(from.crossings());
    }

    /// The crossings that are meant.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings[..(self.crossing_count as usize).min(MAX_CROSSINGS)]
    }
}
