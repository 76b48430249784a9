//! Ground under the ropes of a film, as seen by a camera that may move.

use super::Story;
use crate::RenderOptions;
use crate::rendered::portable::sin_turns;
use crate::rendered::table::{lit_table, to_byte};
use crate::scenes::{self, Class};

/// Range of a moving camera to either side, as a share of the picture's shorter side; and the
/// periods of the camera's motion.
const SWAY: f64 = 0.07;
const PERIODS_S: [f64; 2] = [4.7, 3.6];

/// Colors of ropes on the market. One of the [`CLEAREST`] colors that are rarest in the picture is
/// used.
const ROPES: [[u8; 3]; 8] = [
    [40, 90, 190],
    [200, 40, 40],
    [235, 120, 30],
    [40, 150, 70],
    [230, 200, 40],
    [235, 235, 230],
    [30, 30, 35],
    [200, 60, 150],
];
const CLEAREST: usize = 3;
/// Stride of the sampled pixels; and the inverse of the share of the samples that may resemble the
/// rope.
const EVERY: usize = 7;
const ALIKE: usize = 20;

/// A surface. Its size is that of everything that the camera sees during the film.
#[derive(Debug)]
pub(super) struct Ground {
    rgb: Vec<u8>,
    /// Number of pixels beyond the picture on every side.
    margin: usize,
    size: [usize; 2],
}

impl Ground {
    /// Makes the ground of a story. A cluttered ground also sets the rope's color.
    pub(super) fn of(story: Story, options: &mut RenderOptions) -> Self {
        let size = [options.width, options.height].map(|side| side as usize);
        let (margin, sides) = (margin(story, size), sides(story, size));
        let rgb = if story.is_cluttered() {
            let class = [Class::OnClutter, Class::OnTexture][options.seed as usize % 2];
            let (rgb, rope) = scenes::surface(class, options.seed / 2, sides);
            options.rope_rgb = rope;
            rgb.iter().map(|&level| to_byte(level.into())).collect()
        } else {
            let [width, height] = sides.map(|side| side as u32);
            lit_table(&RenderOptions {
                width,
                height,
                ..*options
            })
        };
        Self { rgb, margin, size }
    }

    /// Uses a picture of size [`sides`] as the ground of a story. The ropes get a color that is
    /// rare in it.
    pub(super) fn pictured(story: Story, options: &mut RenderOptions, mut rgb: Vec<u8>) -> Self {
        rgb.iter_mut()
            .for_each(|level| *level = to_byte(f32::from(*level)));
        let size = [options.width, options.height].map(|side| side as usize);
        let mut colors = ROPES;
        colors.sort_by_cached_key(|&color| std::cmp::Reverse(clearance(&rgb, color)));
        options.rope_rgb = colors[options.seed as usize % CLEAREST];
        Self {
            rgb,
            margin: margin(story, size),
            size,
        }
    }

    /// Fills `out` with the camera's view at this time. Returns the camera's displacement in
    /// pixels.
    pub(super) fn film(&self, time_s: f64, out: &mut Vec<u8>) -> [f64; 2] {
        if self.margin == 0 {
            out.clone_from(&self.rgb);
            return [0.0; 2];
        }
        let sway_px = (self.margin - 2) as f64;
        let moved_px = PERIODS_S.map(|period_s| sway_px * sin_turns(time_s / period_s));
        let from = moved_px.map(|px| px + self.margin as f64);
        let whole = from.map(|px| px as usize);
        let [fx, fy] = [0, 1].map(|axis| (from[axis] - whole[axis] as f64) as f32);
        let stride = 3 * (self.size[0] + 2 * self.margin);
        out.clear();
        for y in 0..self.size[1] {
            let start = (whole[1] + y) * stride + 3 * whole[0];
            let [upper, lower] = [start, start + stride].map(|at| &self.rgb[at..]);
            for i in 0..3 * self.size[0] {
                let mix =
                    |a: u8, b: u8, share: f32| f32::from(a) + share * (f32::from(b) - f32::from(a));
                let above = mix(upper[i], upper[i + 3], fx);
                let below = mix(lower[i], lower[i + 3], fx);
                out.push(to_byte(above + fy * (below - above)));
            }
        }
        moved_px
    }
}

/// Width and height of everything that a story's camera sees.
pub(super) fn sides(story: Story, size: [usize; 2]) -> [usize; 2] {
    size.map(|side| side + 2 * margin(story, size))
}

fn margin(story: Story, size: [usize; 2]) -> usize {
    if story.is_panned() {
        (SWAY * size[0].min(size[1]) as f64) as usize + 2
    } else {
        0
    }
}

/// Minimum distance of a color from the colors of a picture's pixels, except for a few outliers.
fn clearance(rgb: &[u8], color: [u8; 3]) -> u32 {
    let off = |pixel: &[u8]| -> u32 {
        (pixel.iter().zip(color))
            .map(|(&a, b)| u32::from(a.abs_diff(b)))
            .sum()
    };
    let mut offs: Vec<_> = rgb.chunks_exact(3).step_by(EVERY).map(off).collect();
    let few = offs.len() / ALIKE;
    *offs.select_nth_unstable(few).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moving::Film;

    #[test]
    fn a_rope_has_a_color_that_its_ground_has_little_of() {
        let mut options = RenderOptions {
            width: 160,
            height: 160,
            ..RenderOptions::default()
        };
        let [width, height] = sides(Story::Clutter, [160; 2]);
        for seed in 0..3 {
            options.seed = seed;
            let blue = ROPES[0].repeat(width * height);
            Ground::pictured(Story::Clutter, &mut options, blue);
            assert_ne!(options.rope_rgb, ROPES[0], "seed {seed}");
        }
    }

    /// Noise is not added beyond white where a picture is overexposed.
    #[test]
    fn what_is_white_in_a_picture_stays_white() {
        let size = [160, 160];
        let [width, height] = Film::ground_size(Story::Clutter, size);
        let white = vec![255; (3 * width * height) as usize];
        let mut rgb = Vec::new();
        Film::on(Story::Clutter, 1, size, white).next(&mut rgb);
        // The first pixel is far from the rope and its shadow.
        assert!(rgb[..3].iter().all(|&level| level > 220), "{:?}", &rgb[..3]);
    }

    #[test]
    fn a_film_on_a_picture_shows_it_beside_the_rope() {
        let size = [160, 160];
        for story in [Story::Clutter, Story::Handheld] {
            let [width, height] = Film::ground_size(story, size);
            let gray = vec![120; (3 * width * height) as usize];
            let mut film = Film::on(story, 1, size, gray);
            let (mut rgb, mut mask) = (Vec::new(), Vec::new());
            let truth = film.next(&mut rgb);
            film.mask(&truth, &mut mask);
            let gray = |pixel: &[u8]| pixel.iter().all(|&c| c.abs_diff(120) < 40);
            let beside = rgb.chunks_exact(3).zip(&mask).filter(|&(_, &m)| m == 0);
            let shown = beside.clone().filter(|(pixel, _)| gray(pixel)).count();
            // The rope's shadow is next to it, too.
            assert!(shown as f64 > 0.8 * beside.count() as f64, "{story:?}");
        }
    }
}
