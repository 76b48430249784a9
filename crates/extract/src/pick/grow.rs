//! The rope at some points, as connected regions of similar color, one for each of many tolerances.
//!
//! Similarity is measured on smoothed colors. Chroma is smoothed over more pixels than light,
//! because a camera's chroma is coarser and noisier, and edges are visible in the light. A rope has
//! an edge all around, so its region hardly grows over a range of tolerances. The masks show which
//! of the regions is the rope (`choose`).

use crate::image::{Image, color};
use crate::mask::background::Background;
use crate::vec2::Vec2;

/// Tolerances tried, in levels: from noise to any edge that a camera shows, in steps of a fifth.
const TOLERANCES: [f32; 15] = [
    6.0, 7.3, 8.8, 10.7, 13.0, 15.8, 19.2, 23.4, 28.4, 34.6, 42.1, 51.2, 62.3, 75.8, 92.2,
];
/// Weight of a difference in light relative to one in chroma: equal, or less for ropes in light and
/// shade.
const LIGHT: [f32; 2] = [1.0, 0.35];
/// Maximum share of the image for a rope.
const MOST: f32 = 0.25;
/// A region that has grown by less than this factor is the same one.
const SAME: f32 = 1.05;
/// Maximum distance of a plain table's pixels from a smooth surface (median, in levels). On a table
/// that is not plain, a point's color cannot tell whether it is on the table.
const PLAIN: f32 = 8.0;
/// On a plain table, a point is table if it is within this many levels of the surface, or within
/// this many median residuals. These are the floors of the automatic mask.
const TABLE_LEVELS: f32 = 14.0;
const TABLE_RESIDUALS: f32 = 6.0;

/// Smoothed colors: light, blue minus light, and red minus light.
pub(super) fn smoothed(image: &Image) -> Vec<[f32; 3]> {
    let (width, height) = (image.width(), image.height());
    let mut colors: Vec<[f32; 3]> = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let [r, g, b] = color::rgb(image, x, y).map(f32::from);
            let light = 0.299 * r + 0.587 * g + 0.114 * b;
            colors.push([light, b - light, r - light]);
        }
    }
    // Across, then down: weights 1, 4, 6, 4, 1 for chroma, and 1, 6, 1 for light.
    for (step, count, stride, rows) in [(1, width, width, height), (width, height, 1, width)] {
        let mut line = vec![[0.0f32; 3]; count];
        for row in 0..rows {
            for (k, color) in line.iter_mut().enumerate() {
                *color = colors[row * stride + k * step];
            }
            for k in 0..count {
                let at = |d: isize| line[k.saturating_add_signed(d).min(count - 1)];
                let [aa, a, c, b, bb] = [at(-2), at(-1), at(0), at(1), at(2)];
                let chroma = |i: usize| (aa[i] + bb[i] + 4.0 * (a[i] + b[i]) + 6.0 * c[i]) / 16.0;
                let light = (a[0] + b[0] + 6.0 * c[0]) / 8.0;
                colors[row * stride + k * step] = [light, chroma(1), chroma(2)];
            }
        }
    }
    colors
}

/// The regions that grow from the points, which are all in the image, over the tolerances.
pub(super) fn regions(colors: &[[f32; 3]], width: usize, points: &[[usize; 2]]) -> Vec<Vec<bool>> {
    let seeds: Vec<[f32; 3]> = points.iter().map(|&[x, y]| colors[y * width + x]).collect();
    let mut regions = Vec::new();
    for light in LIGHT {
        let square = |color: &[f32; 3], seed: &[f32; 3]| {
            let [y, b, r] = [0, 1, 2].map(|c| color[c] - seed[c]);
            (light * y) * (light * y) + b * b + r * r
        };
        let far = |color: &[f32; 3]| {
            let squares = seeds.iter().map(|seed| square(color, seed));
            libm::sqrtf(squares.fold(f32::INFINITY, f32::min))
        };
        // Distance of each pixel's color from the nearest seed's, computed once for all tolerances.
        let far: Vec<f32> = colors.iter().map(far).collect();
        let mut last = 0.0f32;
        for tolerance in TOLERANCES {
            let region = flood(&far, width, points, tolerance);
            let area = region.iter().filter(|set| **set).count() as f32;
            if area > MOST * far.len() as f32 {
                break;
            }
            if area > SAME * last {
                last = area;
                regions.push(region);
            }
        }
    }
    regions
}

/// Returns whether the table is plain and the pixel has its color.
pub(super) fn is_table(image: &Image, at: Vec2) -> bool {
    Table::of(image).is_at(image, at)
}

/// Moves a user's point that shows the table onto an object within `reach_px`, if there is one.
pub(super) fn snapped(image: &Image, at: Vec2, reach_px: f32) -> Vec2 {
    let table = Table::of(image);
    if !table.is_at(image, at) {
        return at;
    }
    let last = [image.width() - 1, image.height() - 1].map(|c| c as f32);
    let reach = reach_px as i32;
    let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [dx, dy]));
    let near = around.filter_map(|offset| {
        let [dx, dy] = offset.map(|c| c as f32);
        let place = [at[0] + dx, at[1] + dy];
        let is_inside = (0..2).all(|axis| (0.0..=last[axis]).contains(&place[axis]));
        let away_px = libm::hypotf(dx, dy);
        (is_inside && away_px <= reach_px && !table.is_at(image, place)).then_some((away_px, place))
    });
    let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((away_px, edge)) = nearest else {
        return at;
    };
    // The first pixel is a mixture of rope and table. The one behind it shows the rope alone.
    let behind = [0, 1].map(|axis| {
        let step = (edge[axis] - at[axis]) / away_px.max(1.0);
        (edge[axis] + 2.0 * step).clamp(0.0, last[axis])
    });
    if table.is_at(image, behind) {
        edge
    } else {
        behind
    }
}

/// The color of the table at each place.
struct Table(Background);

impl Table {
    fn of(image: &Image) -> Self {
        let mut background = Background::default();
        background.estimate(image);
        Self(background)
    }

    /// Returns whether the table is plain and the pixel has its color.
    fn is_at(&self, image: &Image, at: Vec2) -> bool {
        let [x, y] = pixel(image, at);
        let own = color::native(image, x, y).map(f32::from);
        let apart = color::distance(own, self.0.at(x, y), color::is_yuv(image.format()));
        let limit = (TABLE_RESIDUALS * self.0.noise).max(TABLE_LEVELS);
        self.0.noise < PLAIN && apart < limit
    }
}

/// The pixel at a point.
pub(super) fn pixel(image: &Image, at: Vec2) -> [usize; 2] {
    let last = [image.width() - 1, image.height() - 1];
    [0, 1].map(|c| (at[c].round().max(0.0) as usize).min(last[c]))
}

/// The pixels within `tolerance` that are connected to the points or their neighbors. A point
/// itself may be a speck.
fn flood(far: &[f32], width: usize, points: &[[usize; 2]], tolerance: f32) -> Vec<bool> {
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
    for &[x, y] in points {
        for ny in around(y, 1, height - 1) {
            for nx in around(x, 1, width - 1) {
                visit(nx, ny, &mut region, &mut waiting);
            }
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
