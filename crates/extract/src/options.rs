//! What a user may say about the ropes, and the check that it makes sense.

mod method;

use std::num::NonZeroU8;
use std::time::Duration;

use thiserror::Error;

pub use method::{Method, UnknownMethod};

/// What counts as rope, by colour. Bounds are inclusive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HsvRange {
    /// Hue in degrees, 0 to 360. A range whose first bound is the larger one wraps through 0 (red).
    pub hue_deg: [f32; 2],
    /// Saturation, 0 to 1.
    pub saturation: [f32; 2],
    /// Value (the largest of red, green and blue), 0 to 1.
    pub value: [f32; 2],
}

/// How the rope's pixels are told from the table's.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Mask {
    /// The background is found by itself; what differs from it by more than its noise is rope. Where the background is not
    /// plain, a network is asked.
    #[default]
    Auto,
    /// A pixel inside any of the ranges is rope: several ranges for several colours of rope.
    Hsv(Vec<HsvRange>),
    /// A network says where ropes are, whatever they lie on.
    Network,
    /// Somebody else says which pixels are rope, image by image:
    /// [`Extractor::extract_masked`](crate::Extractor::extract_masked). An image without a mask has no rope.
    External,
}

/// The settings of an extractor. Each field has a method of its name that sets it:
/// `Options::default().points(60)`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// How the rope's pixels are told from the table's.
    pub mask: Mask,
    /// From which level on a pixel of a mask that was made elsewhere is rope; `None`: chosen by the mask's own
    /// histogram, low for soft masks, so that a rope is not broken where a network is unsure of it.
    pub mask_level: Option<NonZeroU8>,
    /// How they become a centerline.
    pub method: Method,
    /// N, the points of each centerline, 2 to 256.
    pub points: usize,
    /// The most curves reported (the surest and longest: those of the largest confidence × length), 1 to 64.
    pub ropes: usize,
    /// The [confidence](crate::Curve::confidence) below which a curve is told of
    /// ([`Notice::Unsure`](crate::Notice::Unsure)), 0 to 1. It is reported all the same.
    pub min_confidence: f32,
    /// On the first frame, the end nearest to this position (in pixels) is the first point;
    /// `None`: the end nearest to the top left.
    pub start: Option<[f32; 2]>,
    /// Positions on the ropes that are meant, in pixels: only those are reported that were found there first. Empty: all.
    pub at: Vec<[f32; 2]>,
    /// For how long a rope that is out of sight is still reported, as `Status::Lost`.
    pub keep_lost: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            mask: Mask::Auto,
            mask_level: None,
            method: Method::Skeleton,
            points: 120,
            ropes: 24,
            min_confidence: 0.5,
            start: None,
            at: Vec::new(),
            keep_lost: Duration::from_secs(1),
        }
    }
}

macro_rules! setters {
    ($($field:ident: $type:ty,)*) => {
        impl Options {$(
            #[doc = concat!("Sets [`", stringify!($field), "`](Self#structfield.", stringify!($field), ").")]
            #[must_use]
            pub fn $field(mut self, $field: $type) -> Self {
                self.$field = $field;
                self
            }
        )*}
    };
}
setters! {
    mask: Mask,
    mask_level: Option<NonZeroU8>,
    method: Method,
    points: usize,
    ropes: usize,
    min_confidence: f32,
    start: Option<[f32; 2]>,
    at: Vec<[f32; 2]>,
    keep_lost: Duration,
}

/// Why [`Options`] cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OptionsError {
    /// The number of points is out of range.
    #[error("{0} points a centerline: choose 2 to 256")]
    Points(usize),
    /// The number of ropes is out of range.
    #[error("at most {0} ropes: choose 1 to 64")]
    Ropes(usize),
    /// The confidence is out of range.
    #[error("a confidence of {0}: choose 0 to 1")]
    Confidence(f32),
    /// A network was given that is never asked.
    #[error(
        "a network is given, which colour ranges and masks from elsewhere have no use for: leave it out, or take \
         the mask \"auto\" or \"network\""
    )]
    IdleNetwork,
    /// No colour range was given.
    #[error("the mask is by HSV but has no range: give at least one, or use the automatic mask")]
    NoRange,
    /// A bound is outside its scale or is not a number.
    #[error(
        "range {index}: {channel} [{}, {}] must lie within 0 to {limit}", .bounds[0], .bounds[1]
    )]
    Bound {
        /// Which range, from 0.
        index: usize,
        /// `hue_deg`, `saturation` or `value`.
        channel: &'static str,
        /// The bounds as given.
        bounds: [f32; 2],
        /// The largest value of the scale.
        limit: f32,
    },
    /// The bounds stand in the wrong order.
    #[error(
        "range {index}: {channel} [{}, {}] is turned around: put the smaller bound first \
         (only a hue may wrap)", .bounds[0], .bounds[1]
    )]
    Reversed {
        /// Which range, from 0.
        index: usize,
        /// `saturation` or `value`.
        channel: &'static str,
        /// The bounds as given.
        bounds: [f32; 2],
    },
    /// The start position is not a number.
    #[error("the start position [{}, {}] must be two finite numbers of pixels", .0[0], .0[1])]
    Start([f32; 2]),
    /// A position on a rope is not a number.
    #[error("the position [{}, {}] on a rope must be two finite numbers of pixels", .0[0], .0[1])]
    At([f32; 2]),
}

impl Options {
    /// Checks every field.
    pub(crate) fn check(&self) -> Result<(), OptionsError> {
        if !(2..=256).contains(&self.points) {
            return Err(OptionsError::Points(self.points));
        }
        if !(1..=64).contains(&self.ropes) {
            return Err(OptionsError::Ropes(self.ropes));
        }
        if !(0.0..=1.0).contains(&self.min_confidence) {
            return Err(OptionsError::Confidence(self.min_confidence));
        }
        if let Some(start) = self.start
            && !(start[0].is_finite() && start[1].is_finite())
        {
            return Err(OptionsError::Start(start));
        }
        let is_place = |at: &&[f32; 2]| at[0].is_finite() && at[1].is_finite();
        if let Some(&at) = self.at.iter().find(|at| !is_place(at)) {
            return Err(OptionsError::At(at));
        }
        match &self.mask {
            Mask::Auto | Mask::Network | Mask::External => Ok(()),
            Mask::Hsv(ranges) if ranges.is_empty() => Err(OptionsError::NoRange),
            Mask::Hsv(ranges) => ranges.iter().enumerate().try_for_each(check_range),
        }
    }
}

fn check_range((index, range): (usize, &HsvRange)) -> Result<(), OptionsError> {
    let channels = [
        ("hue_deg", range.hue_deg, 360.0, true),
        ("saturation", range.saturation, 1.0, false),
        ("value", range.value, 1.0, false),
    ];
    for (channel, bounds, limit, wraps) in channels {
        if !bounds.iter().all(|b| (0.0..=limit).contains(b)) {
            return Err(OptionsError::Bound {
                index,
                channel,
                bounds,
                limit,
            });
        }
        if !wraps && bounds[0] > bounds[1] {
            return Err(OptionsError::Reversed {
                index,
                channel,
                bounds,
            });
        }
    }
    Ok(())
}
