//! What extract saw: centerlines, and where they cross.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use super::hidden::{bit, mask};
use crate::{MAX_CROSSINGS, MAX_CURVES, MAX_POINTS, Status, Trace};

/// One rope's centerline: points at equal steps of arc length, in pixels of the full image (x right, y down, the
/// centre of the top-left pixel is (0, 0)).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "transport",
    derive(ZeroCopySend),
    type_name("lariat.Curve.v2")
)]
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
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "transport",
    derive(ZeroCopySend),
    type_name("lariat.Crossing.v1")
)]
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
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "transport",
    derive(ZeroCopySend),
    type_name("lariat.Centerlines.v2")
)]
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    #[test]
    fn the_layout_is_what_readers_in_other_languages_were_told() {
        assert_eq!(size_of::<Curve>(), 72 + 256 * 8 + 256 * 4);
        assert_eq!(offset_of!(Curve, age_ns), 32);
        assert_eq!(offset_of!(Curve, hidden), 40);
        assert_eq!(offset_of!(Curve, points), 72);
        assert_eq!(offset_of!(Curve, widths_px), 72 + 256 * 8);
        assert_eq!(size_of::<Crossing>(), 32);
        assert_eq!(offset_of!(Centerlines, curves), 96);
        assert_eq!(offset_of!(Centerlines, crossings), 96 + 8 * 3144);
        assert_eq!(size_of::<Centerlines>(), 96 + 8 * 3144 + 32 * 32);
    }
}
