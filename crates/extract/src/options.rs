//! The user's options for the ropes, and their validation.

mod method;

use std::num::NonZeroU8;
use std::time::Duration;

use thiserror::Error;

pub use method::{Method, UnknownMethod};

/// A color range that counts as rope. Bounds are inclusive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HsvRange {
    /// Hue in degrees, 0 to 360. If the first bound is the larger one, the range wraps through 0
    /// (red).
    pub hue_deg: [f32; 2],
    /// Saturation, 0 to 1.
    pub saturation: [f32; 2],
    /// Value (the largest of red, green and blue), 0 to 1.
    pub value: [f32; 2],
}

/// The source of the mask, which separates the rope's pixels from the table's.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Mask {
    /// Finds the background by itself. Pixels that differ from it by more than its noise are rope.
    /// On a background that is not plain, it uses a network.
    #[default]
    Auto,
    /// Treats pixels inside any of the ranges as rope. Give several ranges for ropes of several
    /// colors.
    Hsv(Vec<HsvRange>),
    /// Uses a network to find ropes on any background.
    Network,
    /// Takes a mask from another source for each image, through
    /// [`Extractor::extract_masked`](crate::Extractor::extract_masked). An image without a mask
    /// yields an empty scene.
    External,
}

/// The settings of an extractor. Each field has a method of the same name that sets it:
/// `Options::default().points(60)`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The source of the mask, which separates the rope's pixels from the table's.
    pub mask: Mask,
    /// Minimum level of a rope's pixel in an external mask. With `None`, the mask's own histogram
    /// decides. The level is low for soft masks, so that a rope is not broken where a network is
    /// unsure of it.
    pub mask_level: Option<NonZeroU8>,
    /// The method that turns the mask into a centerline.
    pub method: Method,
    /// N, the number of points of each centerline, 2 to 256.
    pub points: usize,
    /// Maximum number of reported curves, 1 to 64. The most confident and longest are kept: those
    /// with the largest confidence × length.
    pub ropes: usize,
    /// Minimum [confidence](crate::Curve::confidence), 0 to 1. Curves below it get the notice
    /// [`Notice::Unsure`](crate::Notice::Unsure). They are still reported.
    pub min_confidence: f32,
    /// In the first frame, the end nearest to this position (in pixels) becomes the first point.
    /// With `None`, it is the end nearest to the top left.
    pub start: Option<[f32; 2]>,
    /// Positions on the desired ropes, in pixels. Only ropes that were first found at one of them
    /// are reported. If empty, all ropes are.
    pub at: Vec<[f32; 2]>,
    /// Time for which a rope out of sight is still reported, as `Status::Lost`.
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

/// The reason why [`Options`] cannot be used.
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
    /// A network was given, but is never used.
    #[error(
        "a network is given, which colour ranges and masks from elsewhere have no use for: leave it out, or take \
         the mask \"auto\" or \"network\""
    )]
    IdleNetwork,
    /// No color range was given.
    #[error("the mask is by HSV but has no range: give at least one, or use the automatic mask")]
    NoRange,
    /// A bound is outside its scale or is not a number.
    #[error(
        "range {index}: {channel} [{}, {}] must lie within 0 to {limit}", .bounds[0], .bounds[1]
    )]
    Bound {
        /// Index of the range, from 0.
        index: usize,
        /// `hue_deg`, `saturation` or `value`.
        channel: &'static str,
        /// The bounds as given.
        bounds: [f32; 2],
        /// The largest value of the scale.
        limit: f32,
    },
    /// The bounds are in the wrong order.
    #[error(
        "range {index}: {channel} [{}, {}] is turned around: put the smaller bound first \
         (only a hue may wrap)", .bounds[0], .bounds[1]
    )]
    Reversed {
        /// Index of the range, from 0.
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
