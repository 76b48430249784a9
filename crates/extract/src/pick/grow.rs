//! The rope at a point, where no automatic mask helps: the connected region of like colour.
//!
//! How like is found by growing with a wider and wider tolerance. A rope has an edge all around, so its region hardly
//! grows over a span of tolerances, and then, when the tolerance passes the edge's height, all at once: the region
//! before the greatest leap is the rope.

use super::PickError;
use super::evidence::{Evidence, median_color};
use super::range;
use crate::image::{Image, color};
use crate::mask::background::Background;
use crate::mask::hsv;
use crate::vec2::Vec2;

/// Tolerances tried, in levels: from noise to any edge that a camera shows, by steps of a seventh.
const TOLERANCES: [f32; 20] = [
    8.0, 9.2, 10.5, 12.0, 13.7, 15.6, 17.8, 20.4, 23.3, 26.6, 30.4, 34.7, 39.7, 45.3, 51.8, 59.2,
    67.6, 77.3, 88.3, 100.9,
];
/// The largest share of the image that is a rope's.
const MOST: f32 = 0.25;
/// A table whose pixels lie farther than this from a smooth surface (in the median, in levels) is not plain, and no
/// point can be told to be on it by its colour.
const PLAIN: f32 = 8.0;
/// On a plain table a point within this many levels of the surface, or median residuals, is table: the floors of the
/// automatic mask.
const TABLE_LEVELS: f32 = 14.0;
const TABLE_RESIDUALS: f32 = 6.0;

/// The rope at `at`, a point in the image: the region, and all that has the region's colours elsewhere.
pub(super) fn rope(image: &Image, at: Vec2) -> Result<Evidence, PickError> {
    let mut region = region(image, at)?;
    let width = image.width();
    if let Some(fit) = range::fit(image, &Evidence::of_region(&region, width), 0) {
        // The rope goes on where the region does not reach, behind another strand: that is no table.
        for (i, set) in region.iter_mut().enumerate() {
            *set |= hsv::contains(&[fit.range], color::rgb(image, i % width, i / width));
        }
    }
    Ok(Evidence::of_region(&region, width))
}

fn area(region: &[bool]) -> usize {
    region.iter().filter(|set| **set).count()
}

/// The region that grows from `at`.
fn region(image: &Image, at: Vec2) -> Result<Vec<bool>, PickError> {
    let (width, height) = (image.width(), image.height());
    let (x, y) = (
        at[0].round().max(0.0) as usize,
        at[1].round().max(0.0) as usize,
    );
    let (x, y) = (x.min(width - 1), y.min(height - 1));
    let around = |c: usize, last: usize| c.saturating_sub(2)..=(c + 2).min(last);
    let pixels: Vec<[u8; 3]> = around(y, height - 1)
        .flat_map(|y| around(x, width - 1).map(move |x| color::rgb(image, x, y)))
        .collect();
    let seed = median_color(&pixels);
    if is_table(image, [x, y]) {
        return Err(PickError::Table { at });
    }
    // How far each pixel is from the seed's colour, once for all tolerances.
    let far: Vec<f32> = (0..width * height)
        .map(|i| {
            let rgb = color::rgb(image, i % width, i / width).map(f32::from);
            color::distance(rgb, seed, false)
        })
        .collect();
    let mut regions = TOLERANCES.map(|tolerance| flood(&far, width, [x, y], tolerance));
    let areas: Vec<usize> = regions.iter().map(|region| area(region)).collect();
    let leap = |i: &usize| areas[i + 1] as f32 / areas[*i].max(1) as f32;
    let before = (0..areas.len() - 1)
        .filter(|&i| areas[i] as f32 <= MOST * far.len() as f32)
        .max_by(|a, b| leap(a).total_cmp(&leap(b)));
    match before {
        Some(i) if areas[i] > 0 => Ok(std::mem::take(&mut regions[i])),
        _ => Err(PickError::NotARope { at }),
    }
}

/// Whether the table is plain and the pixel has its colour.
fn is_table(image: &Image, [x, y]: [usize; 2]) -> bool {
    let mut background = Background::default();
    background.estimate(image);
    let table = background.at(x, y);
    let own = color::native(image, x, y).map(f32::from);
    let limit = (TABLE_RESIDUALS * background.noise).max(TABLE_LEVELS);
    background.noise < PLAIN && color::distance(own, table, color::is_yuv(image.format())) < limit
}

/// The pixels within `tolerance` that are joined to the start through each other, or near it: the start itself may be
/// a speck.
fn flood(far: &[f32], width: usize, [x, y]: [usize; 2], tolerance: f32) -> Vec<bool> {
    let height = far.len() / width;
    let mut region = vec![false; far.len()];
    let mut waiting: Vec<(usize, usize)> = Vec::new();
    let visit = |x: usize, y: usize, region: &mut [bool], waiting: &mut Vec<_>| {
        let i = y * width + x;
        if !region[i] && far[i] <= tolerance {
            region[i] = true;
            waiting.push((x, y));
        }
    };
    let around =
        |c: usize, reach: usize, last: usize| c.saturating_sub(reach)..=(c + reach).min(last);
    for ny in around(y, 2, height - 1) {
        for nx in around(x, 2, width - 1) {
            visit(nx, ny, &mut region, &mut waiting);
        }
    }
    while let Some((x, y)) = waiting.pop() {
        for ny in around(y, 1, height - 1) {
            for nx in around(x, 1, width - 1) {
                visit(nx, ny, &mut region, &mut waiting);
            }
        }
    }
    region
}
