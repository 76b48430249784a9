//! The ropes that are traced in a mask of picked colors.

use super::evidence::{self, Owner};
use crate::extractor::Extractor;
use crate::image::Image;
use crate::options::{HsvRange, Mask, Options};
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Maximum number of curves.
const MOST_CURVES: usize = 24;
/// Maximum ratio of two widths that are treated as equal.
const ALIKE: f32 = 1.67;

/// The curves in a mask, and the chosen one.
#[derive(Debug)]
pub(super) struct MaskCurves {
    pub(super) curves: Vec<Curve>,
    /// The chosen curve: the nearest to the first point, or the longest.
    pub(super) own: usize,
    /// The curve of each mask pixel, if extraction kept the pixel in the mask.
    pub(super) owners: Vec<Owner>,
    /// Maximum distance of the points from their nearest curves, in those curves' half-widths.
    pub(super) beside: f32,
    /// Pixels along curves, and pixels along curves of the chosen one's width.
    pub(super) along: f32,
    pub(super) alike: f32,
    /// Mean confidence along curves of the chosen one's width.
    pub(super) confidence: f32,
}

impl MaskCurves {
    pub(super) fn own(&self) -> &Curve {
        &self.curves[self.own]
    }

    /// Returns whether a curve is like the chosen one, and nearly as confident.
    pub(super) fn is_to_go_by(&self, curve: usize) -> bool {
        let curve = &self.curves[curve];
        self.is_alike(curve) && 2.0 * curve.confidence >= self.own().confidence
    }

    pub(super) fn is_alike(&self, curve: &Curve) -> bool {
        let times = curve.width_px / self.own().width_px;
        times.max(1.0 / times) <= ALIKE
    }
}

/// Traces the ropes in a mask of these ranges, or returns `None` without ropes.
pub(super) fn see(image: &Image, ranges: &[HsvRange], points: &[Vec2]) -> Option<MaskCurves> {
    see_in(image, Mask::Hsv(ranges.to_vec()), points)
}

/// Traces the ropes in a mask, or returns `None` without ropes.
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
    // The nearest curve to a point, and its distance.
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

/// Distance from a curve to a point, in half-widths.
fn half_widths(curve: &Curve, at: Vec2) -> f32 {
    let each = curve.points.iter().zip(&curve.widths_px);
    each.map(|(&point, &width)| vec2::distance(point, at) / (0.5 * width).max(1.0))
        .fold(f32::INFINITY, f32::min)
}
