//! What the extractor says about one image.

use crate::notice::Notice;

/// The most crossings reported.
pub(crate) const MOST_CROSSINGS: usize = 32;

/// How much of a rope is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// Seen from end to end.
    Ok,
    /// Seen, but a part of it is covered: in the middle ([`Curve::hidden`] says where), or at an end
    /// that was seen before.
    Partial,
    /// Not seen in this image: the points are its last known shape, [`Curve::age_ns`] old.
    Lost,
    /// Seen, but it may be no rope: [`Scene::notice`] says what it looks like. Of the automatic mask only.
    Doubtful,
}

impl Status {
    /// Its name in text and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Partial => "partial",
            Self::Lost => "lost",
            Self::Doubtful => "doubtful",
        }
    }
}

/// The centerline of one rope.
///
/// Positions are in pixels: x to the right, y down, (0, 0) the centre of the top-left pixel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Curve {
    /// The rope's number, kept from frame to frame.
    pub track: u32,
    /// How much of the rope is seen.
    pub status: Status,
    /// Whether the rope has no ends. The last point is then one step before the first.
    pub closed: bool,
    /// Whether the first and the last point lie where the rope leaves the image.
    pub border: [bool; 2],
    /// N points at equal steps of arc length, [x, y] in pixels; an open rope's first and last are
    /// its two tips. Only hidden ones may lie outside of the image.
    pub points: Vec<[f32; 2]>,
    /// The rope's width at each point, in pixels.
    pub widths_px: Vec<f32>,
    /// Whether each point is covered by something or lies outside of the image, and so is not seen but taken from where the
    /// rope must run between the parts that are.
    pub hidden: Vec<bool>,
    /// The median of `widths_px`.
    pub width_px: f32,
    /// Arc length from tip to tip (once around, when closed), in pixels.
    pub length_px: f32,
    /// How sure it is that the curve is a rope, whole and in order, 0 to 1: of those at 0.9, nine of ten are. A lost one has
    /// that of when it was seen, a followed one that of the image it was last extracted from.
    pub confidence: f32,
    /// How long ago the rope was last seen, in nanoseconds: 0 unless it is lost.
    pub age_ns: u64,
}

impl Default for Curve {
    /// A curve without points, to be filled.
    fn default() -> Self {
        Self {
            track: 0,
            status: Status::Ok,
            closed: false,
            border: [false; 2],
            points: Vec::new(),
            widths_px: Vec::new(),
            hidden: Vec::new(),
            width_px: 0.0,
            length_px: 0.0,
            confidence: 0.0,
            age_ns: 0,
        }
    }
}

/// A place where a rope passes over a rope, another or itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Crossing {
    /// Where, in pixels.
    pub at: [f32; 2],
    /// Index in [`Scene::curves`] of the upper rope.
    pub over: usize,
    /// Index in [`Scene::curves`] of the lower rope.
    pub under: usize,
    /// Where on the upper rope, as normalized arc length from 0 to 1.
    pub over_rho: f32,
    /// Where on the lower rope, as normalized arc length from 0 to 1.
    pub under_rho: f32,
    /// How sure the order is, from 0 (a toss of a coin) to 1 (certain): 2p − 1 for a probability p
    /// of being right.
    pub confidence: f32,
}

/// The ropes seen in one image, borrowed from the extractor until the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene<'a> {
    /// The ropes seen, the longest first, then the lost ones.
    pub curves: &'a [Curve],
    /// Where they cross, at most 32.
    pub crossings: &'a [Crossing],
    /// The most important probable fault of these curves: one may not be a rope, is unsure, or there were too many. Without a curve in
    /// sight, the fault of the table for the automatic mask.
    pub notice: Option<Notice>,
    /// Whether the ropes were followed from the last image, by reading this one only around them; otherwise it was
    /// looked at whole.
    pub followed: bool,
}
