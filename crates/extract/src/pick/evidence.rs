//! Labels of pixels before a color is picked: rope of some class, table, or uncertain.

use crate::bitmap::bits::BitPlane;
use crate::extractor::Extractor;
use crate::image::{Image, color};
use crate::mask::hsv;
use crate::options::{Mask, Options};
use crate::scene::Curve;
use crate::statistics::median;
use crate::vec2;

/// Pixels this near to a rope are mixtures of rope and table, and evidence of neither.
const GUARD_PX: i32 = 2;
/// Minimum share of a mask along the curves found in it. With less, it is a pattern, not ropes.
const LEAST_ALONG: f32 = 0.7;
/// Part of a half-width in which a rope's own color is read.
const CORE: f32 = 0.6;
/// Part of a half-width beyond which a rope's pixels are mixtures with the table.
const EDGE: f32 = 0.8;
/// Ropes whose hues differ by less have one color, in degrees.
const SAME_HUE_DEG: f32 = 20.0;
/// Ropes without color whose values differ by less are of one class.
const SAME_VALUE: f32 = 0.25;
/// Minimum difference of a color's largest and smallest channel for it to have a hue, as a share of
/// full scale. Noise and the light's tint stay below it.
const LEAST_CHROMA: f32 = 0.12;

/// Label of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Label {
    /// Rope of this class.
    Rope(u8),
    Table,
    /// A mixture, or unclear.
    Unknown,
}

/// The curve nearest to a mask pixel, and the distance from its middle in half-widths; `None` if
/// the pixel is next to no curve.
pub(super) type Owner = Option<(u8, f32)>;

/// Labels of all pixels.
#[derive(Clone, Debug)]
pub(super) struct Evidence {
    width: usize,
    labels: Vec<Label>,
    pub(super) classes: usize,
}

impl Evidence {
    /// The label of each pixel, in row order.
    pub(super) fn labels(&self) -> &[Label] {
        &self.labels
    }

    pub(super) fn get(&self, x: i32, y: i32) -> Option<Label> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < self.width).then(|| self.labels.get(y * self.width + x).copied())?
    }

    /// One class for the pixels that are set. All others are table, except those next to them.
    pub(super) fn of_region(region: &[bool], width: usize) -> Self {
        let rope = |&set: &bool| if set { Label::Rope(0) } else { Label::Table };
        let mut evidence = Self {
            width,
            labels: region.iter().map(rope).collect(),
            classes: 1,
        };
        evidence.guard(|i| region[i]);
        evidence
    }

    /// One class for the pixels along rope curves, except for their rims. All others are table,
    /// except those next to them.
    pub(super) fn of_owners(
        width: usize,
        owners: &[Owner],
        is_rope: impl Fn(usize, u8) -> bool,
    ) -> Self {
        let label = |(i, owner): (usize, &Owner)| match *owner {
            Some((curve, _)) if !is_rope(i, curve) => Label::Table,
            Some((_, far)) if far > EDGE => Label::Unknown,
            Some(_) => Label::Rope(0),
            None => Label::Table,
        };
        let mut evidence = Self {
            width,
            labels: owners.iter().enumerate().map(label).collect(),
            classes: 1,
        };
        evidence.guard(|i| owners[i].is_some_and(|(curve, _)| is_rope(i, curve)));
        evidence
    }

    /// Marks table next to rope as unknown.
    fn guard(&mut self, is_rope: impl Fn(usize) -> bool) {
        let (width, height) = (self.width as i32, (self.labels.len() / self.width) as i32);
        for y in 0..height {
            for x in 0..width {
                if !is_rope((y * width + x) as usize) {
                    continue;
                }
                for ny in (y - GUARD_PX).max(0)..=(y + GUARD_PX).min(height - 1) {
                    for nx in (x - GUARD_PX).max(0)..=(x + GUARD_PX).min(width - 1) {
                        let label = &mut self.labels[(ny * width + nx) as usize];
                        if *label == Label::Table {
                            *label = Label::Unknown;
                        }
                    }
                }
            }
        }
    }
}

/// Evidence from a mask, if extraction finds ropes in it. Its pixels belong to the nearest curve,
/// and curves of one color are one class.
pub(super) fn of_mask(image: &Image, mask: Mask) -> Option<Evidence> {
    let options = Options {
        mask,
        ..Options::default()
    };
    let mut extractor = Extractor::new(options).ok()?;
    let curves = extractor.extract(image).curves.to_vec();
    let mask = extractor.mask();
    let (width, height) = (image.width(), image.height());
    let owner = owners(&curves, mask);
    let along = owner.iter().filter(|owner| owner.is_some()).count();
    if curves.is_empty() || (along as f32) < LEAST_ALONG * mask.count() as f32 {
        return None;
    }
    let classes = classes(image, &curves, &owner);
    let count = classes
        .iter()
        .max()
        .map_or(0, |&last| usize::from(last) + 1);
    let label = |i: usize| match owner[i] {
        Some((_, far)) if far > EDGE => Label::Unknown,
        Some((curve, _)) => Label::Rope(classes[usize::from(curve)]),
        None if mask.get((i % width) as i32, (i / width) as i32) => Label::Unknown,
        None => Label::Table,
    };
    let mut evidence = Evidence {
        width,
        labels: (0..width * height).map(label).collect(),
        classes: count,
    };
    evidence.guard(|i| mask.get((i % width) as i32, (i / width) as i32));
    Some(evidence)
}

/// The owner of each pixel of the mask.
pub(super) fn owners(curves: &[Curve], mask: &BitPlane) -> Vec<Owner> {
    let width = mask.width() as i32;
    let mut owner: Vec<Owner> = vec![None; mask.width() * mask.height()];
    for (index, curve) in (0u8..).zip(curves) {
        let half = 0.5 * curve.width_px;
        let reach = 1.5 * half + 1.0;
        for pair in curve.points.windows(2) {
            let steps = vec2::distance(pair[0], pair[1]).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let share = step as f32 / steps as f32;
                let at = vec2::along(pair[0], vec2::sub(pair[1], pair[0]), share);
                let span = |c: f32| (c - reach).ceil() as i32..=(c + reach).floor() as i32;
                for y in span(at[1]) {
                    for x in span(at[0]) {
                        let far = vec2::distance(at, [x as f32, y as f32]);
                        if far > reach || !mask.get(x, y) {
                            continue;
                        }
                        let far = far / half.max(0.5);
                        let pixel = &mut owner[(y * width + x) as usize];
                        if pixel.is_none_or(|(_, before)| far < before) {
                            *pixel = Some((index, far));
                        }
                    }
                }
            }
        }
    }
    owner
}

/// The class of each curve. Curves of similar color share one.
fn classes(image: &Image, curves: &[Curve], owner: &[Owner]) -> Vec<u8> {
    let mut known: Vec<[f32; 3]> = Vec::new();
    let mut classes = Vec::new();
    for index in 0..curves.len() {
        let is_core = |owner: &Owner| {
            owner.is_some_and(|(curve, far)| usize::from(curve) == index && far < CORE)
        };
        let pixels = owner.iter().enumerate().filter(|(_, owner)| is_core(owner));
        let own = pixels.map(|(i, _)| color::rgb(image, i % image.width(), i / image.width()));
        let median = median_color(&own.collect::<Vec<_>>());
        let same = known.iter().position(|&other| is_alike(median, other));
        classes.push(same.unwrap_or(known.len()) as u8);
        if same.is_none() {
            known.push(median);
        }
    }
    classes
}

/// Median of each channel; black for an empty slice.
pub(super) fn median_color(pixels: &[[u8; 3]]) -> [f32; 3] {
    std::array::from_fn(|channel| {
        let mut levels: Vec<f32> = pixels.iter().map(|p| f32::from(p[channel])).collect();
        median(&mut levels)
    })
}

fn is_alike(a: [f32; 3], b: [f32; 3]) -> bool {
    let [(hue_a, _, value_a), (hue_b, _, value_b)] = [a, b].map(|c| hsv::hsv(c.map(|c| c as u8)));
    match (has_hue(a), has_hue(b)) {
        (true, true) => {
            let apart = (hue_a - hue_b).abs();
            apart.min(360.0 - apart) < SAME_HUE_DEG
        }
        (false, false) => (value_a - value_b).abs() < SAME_VALUE,
        _ => false,
    }
}

/// Returns whether a color (levels of red, green and blue) has a hue.
pub(super) fn has_hue(color: [f32; 3]) -> bool {
    let largest = color.iter().copied().fold(0.0, f32::max);
    let smallest = color.iter().copied().fold(255.0, f32::min);
    largest - smallest >= LEAST_CHROMA * 255.0
}
