//! The extractor's result for one image.

use crate::notice::Notice;

/// Maximum number of reported crossings.
pub(crate) const MOST_CROSSINGS: usize = 32;

/// Visibility of a rope.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// Seen from end to end.
    Ok,
    /// Visible, but partly covered: in the middle ([`Curve::hidden`] tells where), or at an end
    /// that was seen before.
    Partial,
    /// Not visible in this image. The points are its last known shape, [`Curve::age_ns`] old.
    Lost,
    /// Visible, but possibly not a rope: [`Scene::notice`] tells what it resembles. Only with the
    /// automatic mask.
    Doubtful,
}

impl Status {
    /// The status's name in text and JSON.
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
/// Positions are in pixels: x to the right, y down, (0, 0) at the center of the top-left pixel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Curve {
    /// The rope's number, which persists from frame to frame.
    pub track: u32,
    /// Visibility of the rope.
    pub status: Status,
    /// True for a loop without ends. The last point is then one step before the first.
    pub closed: bool,
    /// True for the first and the last point if the rope leaves the image there.
    pub border: [bool; 2],
    /// N points at equal steps of arc length, [x, y] in pixels. The first and last point of an open
    /// rope are its two tips. Only hidden points may be outside of the image.
    pub points: Vec<[f32; 2]>,
    /// The rope's width at each point, in pixels.
    pub widths_px: Vec<f32>,
    /// True for each point that is covered or outside of the image. Such a point is not seen, but
    /// inferred from the visible parts on both sides.
    pub hidden: Vec<bool>,
    /// The median of `widths_px`.
    pub width_px: f32,
    /// Arc length from tip to tip (once around, when closed), in pixels.
    pub length_px: f32,
    /// Probability that the curve is a rope, whole and in order, 0 to 1: of curves at 0.9, nine in
    /// ten are right. A lost curve keeps the value of the image where it was last seen. A followed
    /// curve keeps the value of its last full extraction.
    pub confidence: f32,
    /// Time since the rope was last seen, in nanoseconds; 0 unless it is lost.
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

/// A place where a rope passes over another rope or over itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Crossing {
    /// Position in pixels.
    pub at: [f32; 2],
    /// Index in [`Scene::curves`] of the upper rope.
    pub over: usize,
    /// Index in [`Scene::curves`] of the lower rope.
    pub under: usize,
    /// Position on the upper rope, as normalized arc length from 0 to 1.
    pub over_rho: f32,
    /// Position on the lower rope, as normalized arc length from 0 to 1.
    pub under_rho: f32,
    /// Confidence in the order, from 0 (a coin toss) to 1 (certain): 2p − 1, where p is the
    /// probability that it is right.
    pub confidence: f32,
}

/// The ropes in one image, borrowed from the extractor until the next image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene<'a> {
    /// The visible ropes, longest first, then the lost ones.
    pub curves: &'a [Curve],
    /// Crossings of the ropes, at most 32.
    pub crossings: &'a [Crossing],
    /// The most important probable fault: a curve that may not be a rope, an uncertain curve, or
    /// too many curves. If no curve is visible, it is the fault of the table for the automatic
    /// mask.
    pub notice: Option<Notice>,
    /// True if the ropes were followed from the previous image, reading this image only around
    /// them. False after a full extraction.
    pub followed: bool,
}
