//! What a mask of picked colours looks like when ropes are traced in it.

use super::evidence::{self, Owner};
use crate::extractor::Extractor;
use crate::image::Image;
use crate::options::{HsvRange, Mask, Options};
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// The most curves that are looked at.
const MOST_CURVES: usize = 24;
/// Ropes are of one width by so many times.
const ALIKE: f32 = 1.67;

/// The curves in a mask, and the one that was meant.
#[derive(Debug)]
pub(super) struct MaskCurves {
    pub(super) curves: Vec<Curve>,
    /// The curve that was meant: the nearest to the first point, or the longest.
    pub(super) own: usize,
    /// Each mask pixel's curve, where extraction left it in the mask.
    pub(super) owners: Vec<Owner>,
    /// How far the points are from the curves, in half-widths of the nearest: the largest of them.
    pub(super) beside: f32,
    /// Pixels that lie along curves, along curves of the own one's width, and along the own one.
    pub(super) along: f32,
    pub(super) alike: f32,
    /// The mean confidence along curves of the own one's width.
    pub(super) confidence: f32,
}

impl MaskCurves {
    pub(super) fn own(&self) -> &Curve {
        &self.curves[self.own]
    }

    /// Whether a curve is like the own one, and nearly as sure.
    pub(super) fn is_to_go_by(&self, curve: usize) -> bool {
        let curve = &self.curves[curve];
        self.is_alike(curve) && 2.0 * curve.confidence >= self.own().confidence
    }

    pub(super) fn is_alike(&self, curve: &Curve) -> bool {
        let times = curve.width_px / self.own().width_px;
        times.max(1.0 / times) <= ALIKE
    }
}

/// Traces the ropes in a mask of these ranges; `None` if there is none.
pub(super) fn see(image: &Image, ranges: &[HsvRange], points: &[Vec2]) -> Option<MaskCurves> {
    see_in(image, Mask::Hsv(ranges.to_vec()), points)
}

/// Traces the ropes in a mask; `None` if there is none.
pub(super) fn see_in(image: &Image, mask: Mask, points: &[Vec2]) -> Option<MaskCurves> {
    let options = Options {
        mask,
        ropes: MOST_CURVES,
        ..Options::default()
    };
    let mut extractor = Extractor::new(options).ok()?;
    let curves = extractor.extract(image).curves.to_vec();
    if curves.is_empty() {
        return None;
    }
    // The nearest curve to a point, and how far it is.
    let nearest = |at: Vec2| {
        let all = curves.iter().enumerate();
        all.map(|(k, curve)| (k, half_widths(curve, at)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or_default()
    };
    let mut seen = MaskCurves {
        own: points.first().map_or(0, |&at| nearest(at).0),
        beside: points.iter().map(|&at| nearest(at).1).fold(0.0, f32::max),
        owners: evidence::owners(&curves, extractor.mask()),
        along: 0.0,
        alike: 0.0,
        confidence: 0.0,
        curves,
    };
    let mut pixels = vec![0.0f32; seen.curves.len()];
    for (curve, _) in seen.owners.iter().flatten() {
        pixels[usize::from(*curve)] += 1.0;
    }
    for (curve, pixels) in seen.curves.iter().zip(pixels) {
        seen.along += pixels;
        if seen.is_alike(curve) {
            seen.alike += pixels;
            seen.confidence += pixels * curve.confidence;
        }
    }
    seen.confidence /= seen.alike.max(1.0);
    Some(seen)
}

/// How far a curve is from a point, in half-widths.
fn half_widths(curve: &Curve, at: Vec2) -> f32 {
    let each = curve.points.iter().zip(&curve.widths_px);
    each.map(|(&point, &width)| vec2::distance(point, at) / (0.5 * width).max(1.0))
        .fold(f32::INFINITY, f32::min)
}
