//! Chooses the colors of the rope at some points. It derives ranges from
//! many regions, and takes those whose mask is most likely a rope.
//!
//! A region of similar color that grows from a point tells little about whether it is the rope. On
//! a plain table most tolerances give the rope, in clutter only a few do. So a range is fitted to
//! each region, and its whole mask is examined. A mask is better if it contains more of the
//! picture, and if more of the mask is along ropes like the one at the point. The parts of the best
//! masks along those ropes are then evidence for new ranges. These therefore depend on the rope and
//! not on the point.

use super::evidence::{self, Evidence, Label};
use super::palette::Palette;
use super::seen::{MaskCurves, see};
use super::{class_near, grow, range};
use crate::image::Image;
use crate::options::{HsvRange, Mask};
use crate::vec2::Vec2;

/// Exponent of the purity: a tenth of a mask outside of ropes of the chosen rope's width costs as
/// much as four tenths of the mask's area.
const PURITY: f32 = 4.0;
/// Constant added to the confidence before its square root is taken. Masks by color have low
/// confidence at crossings.
const LEAST_CONFIDENCE: f32 = 0.1;
/// Maximum distance of a point from the middle of its curve, in half-widths.
pub(super) const ON: f32 = 1.5;
/// Maximum share of the picture for a mask of ropes, and its minimum number of pixels.
const MOST: f32 = 0.35;
const LEAST_PX: f32 = 20.0;
/// Minimum purity: the share of a mask along ropes of the chosen rope's width. A less pure mask is
/// a pattern, unless the rope at the points has at least the confidence `SURE`. In that case, other
/// objects have the rope's color.
const LEAST_PURITY: f32 = 0.6;
const SURE: f32 = 0.3;
/// Masks that overlap by at least this share are treated as one.
const SAME: f32 = 0.97;
/// Number of the best masks that are evidence for new ones, and number of rounds.
const BEST: usize = 3;
const ROUNDS: usize = 2;
/// Minimum gain in agreement for two ranges instead of one.
const TWO: f32 = 0.05;

/// Ranges, and the ropes in their mask.
#[derive(Debug)]
pub(super) struct Choice {
    pub(super) ranges: Vec<HsvRange>,
    pub(super) agreement: f32,
    pub(super) score: f32,
    pub(super) seen: MaskCurves,
}

/// The best ranges for the rope at the points, or `None` if no mask has a rope there.
pub(super) fn ranges(image: &Image, points: &[Vec2]) -> Option<Choice> {
    let palette = Palette::new(image);
    let mut chooser = Chooser {
        image,
        points,
        palette: &palette,
        tried: Vec::new(),
        choices: Vec::new(),
    };
    if let Some(evidence) = evidence::of_mask(image, Mask::Auto)
        && let Some(class) = class_near(&evidence, points[0])
    {
        chooser.fit(&evidence, class);
    }
    let on_rope = |at: &&Vec2| !grow::is_table(image, **at);
    let pixels: Vec<[usize; 2]> = (points.iter().filter(on_rope))
        .map(|&at| grow::pixel(image, at))
        .collect();
    if !pixels.is_empty() {
        for region in grow::regions(&grow::smoothed(image), image.width(), &pixels) {
            chooser.grown(region);
        }
    }
    for _ in 0..ROUNDS {
        chooser.again();
    }
    chooser.choices.into_iter().next()
}

struct Chooser<'a> {
    image: &'a Image<'a>,
    points: &'a [Vec2],
    palette: &'a Palette,
    /// The colors in each tried mask.
    tried: Vec<Vec<bool>>,
    /// The best choice first.
    choices: Vec<Choice>,
}

impl Chooser<'_> {
    /// Tries the ranges of a region, and those of all pixels with its colors. Parts of the rope
    /// beyond the region, behind another strand, are not table.
    fn grown(&mut self, mut region: Vec<bool>) {
        let width = self.image.width();
        let Some(ranges) = self.fit(&Evidence::of_region(&region, width), 0) else {
            return;
        };
        let held = self.palette.held(&ranges);
        for (set, &color) in region.iter_mut().zip(&self.palette.of) {
            *set |= held[color as usize];
        }
        self.fit(&Evidence::of_region(&region, width), 0);
    }

    /// Tries ranges fitted to the best masks along their ropes.
    fn again(&mut self) {
        let labels: Vec<Evidence> = (self.choices.iter().take(BEST))
            .map(|choice| self.along(&choice.ranges, &choice.seen))
            .collect();
        for evidence in labels {
            self.fit(&evidence, 0);
        }
    }

    /// Evidence in which the mask along curves like the chosen one is rope.
    fn along(&self, ranges: &[HsvRange], seen: &MaskCurves) -> Evidence {
        let held = self.palette.held(ranges);
        Evidence::of_owners(self.image.width(), &seen.owners, |i, curve| {
            seen.is_to_go_by(usize::from(curve)) && held[self.palette.of[i] as usize]
        })
    }

    /// Tries the range of a class, and one range for each of its two colors if these agree better.
    fn fit(&mut self, evidence: &Evidence, class: usize) -> Option<Vec<HsvRange>> {
        let is_rope = |label: &Label| matches!(label, Label::Rope(c) if usize::from(*c) == class);
        let counts = range::counts(self.palette, evidence, is_rope);
        let one = range::fit(self.palette, &counts)?;
        let mut best = vec![one.range];
        if one.agreement < 1.0 - TWO
            && let Some((two, agreement)) = range::fit_two(self.palette, &counts)
            && agreement > one.agreement + TWO
        {
            self.consider(&two, agreement);
            best = two;
        }
        self.consider(&[one.range], one.agreement);
        Some(best)
    }

    /// Examines the mask of these ranges, unless it is like another.
    fn consider(&mut self, ranges: &[HsvRange], agreement: f32) {
        let held = self.palette.held(ranges);
        let area = self.palette.pixels(|color| held[color]);
        if area < LEAST_PX || area > MOST * self.palette.of.len() as f32 {
            return;
        }
        let is_same = |other: &Vec<bool>| {
            let both = self.palette.pixels(|color| held[color] && other[color]);
            let either = self.palette.pixels(|color| held[color] || other[color]);
            both >= SAME * either
        };
        if self.tried.iter().any(is_same) {
            return;
        }
        self.tried.push(held);
        let Some(seen) = see(self.image, ranges, self.points) else {
            return;
        };
        if seen.beside > ON {
            return;
        }
        let purity = (seen.alike / area).min(1.0);
        if purity < LEAST_PURITY && seen.own().confidence < SURE {
            return;
        }
        let choice = Choice {
            ranges: ranges.to_vec(),
            agreement,
            score: area
                * libm::powf(purity, PURITY)
                * libm::sqrtf(seen.confidence * purity + LEAST_CONFIDENCE),
            seen,
        };
        let place = self
            .choices
            .partition_point(|other| other.score >= choice.score);
        self.choices.insert(place, choice);
    }
}
