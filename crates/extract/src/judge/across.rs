//! The image read across a curve at one of its points.

use super::PLACES;
use crate::image::ray::{LANES, Lanes};
use crate::image::{Image, color};
use crate::scene::Curve;
use crate::vec2::{self, Vec2};
use lariat_portable::{Arch, NullaryFnOnce};

/// Distances from the middle, in widths, at which the inside is read.
const INSIDE: [f32; 3] = [-0.22, 0.0, 0.22];
/// Distances beyond the edge at which the ground is read, in widths and with a minimum in pixels.
/// Little of the edge's blur is left there.
const BESIDE: [(f32, f32); 3] = [(0.2, 1.5), (0.4, 2.5), (0.65, 4.0)];

/// The places at one point of a curve where the image is read across it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    at: [Lanes; 2],
}

impl Place {
    /// The places at point `i`, or `None` if any of them is outside of the image.
    pub(super) fn new(image: &Image, curve: &Curve, i: usize) -> Option<Self> {
        let points = &curve.points;
        let (at, width_px) = (points[i], curve.widths_px[i].max(1.5));
        let (before, after) = (i.saturating_sub(2), (i + 2).min(points.len() - 1));
        let along = vec2::unit_or(vec2::sub(points[after], points[before]), [1.0, 0.0]);
        let normal = vec2::normal(along);
        let size = [image.width() as f32, image.height() as f32];
        let reach_px = 0.5 * width_px + (BESIDE[2].0 * width_px).max(BESIDE[2].1);
        let is_inside = |side: f32| {
            let [x, y] = vec2::along(at, normal, side * reach_px);
            x >= 0.0 && y >= 0.0 && x <= size[0] - 1.0 && y <= size[1] - 1.0
        };
        (is_inside(1.0) && is_inside(-1.0)).then(|| Self::across(at, normal, width_px))
    }

    fn across(at: Vec2, normal: Vec2, width_px: f32) -> Self {
        let half_px = 0.5 * width_px;
        let mut far_px = [0.0; LANES];
        for (k, inside) in INSIDE.iter().enumerate() {
            far_px[k] = inside * width_px;
        }
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let from = INSIDE.len() + BESIDE.len() * side;
            for (k, (widths, least_px)) in BESIDE.into_iter().enumerate() {
                far_px[from + k] = sign * (half_px + (widths * width_px).max(least_px));
            }
        }
        let mut place = Self::default();
        for (l, far_px) in far_px.into_iter().enumerate() {
            let [x, y] = vec2::along(at, normal, far_px);
            (place.at[0][l], place.at[1][l]) = (x, y);
        }
        place
    }
}

/// Reads all places, for the widest registers.
struct ReadColors<'a> {
    image: &'a Image<'a>,
    places: &'a [Place],
    colors: &'a mut [[Lanes; 3]],
}

impl NullaryFnOnce for ReadColors<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (colors, place) in self.colors.iter_mut().zip(self.places) {
            *colors = color::between_each(self.image, &place.at);
        }
    }
}

/// The image across a curve at one of its points, in native colors.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Across {
    pub(super) inside: [f32; 3],
    /// Excess brightness of the inside's middle over its two sides, and of one side over the other.
    pub(super) relief: [f32; 2],
    /// The color beyond each edge.
    pub(super) beside: [[f32; 3]; 2],
    /// Color distance from the inside to the color beyond each edge.
    pub(super) edges: [f32; 2],
    /// Variation of the adjacent ground.
    pub(super) texture: f32,
    yuv: bool,
}

impl Across {
    /// Reads the image at these places.
    pub(super) fn read(image: &Image, places: &[Place], out: &mut [Self]) {
        let mut colors = [[[0.0; LANES]; 3]; PLACES];
        Arch::new().dispatch(ReadColors {
            image,
            places,
            colors: &mut colors,
        });
        let yuv = color::is_yuv(image.format());
        for (across, colors) in out.iter_mut().zip(&colors) {
            *across = Self::of(colors, yuv);
        }
    }

    fn of(colors: &[Lanes; 3], yuv: bool) -> Self {
        let color = |l: usize| [0, 1, 2].map(|c| colors[c][l]);
        let mean = |from: usize, count: usize| {
            let sum = |c: usize| colors[c][from..from + count].iter().sum::<f32>();
            [0, 1, 2].map(|c| sum(c) / count as f32)
        };
        let inside = mean(0, INSIDE.len());
        let mut across = Self {
            inside,
            yuv,
            ..Self::default()
        };
        let [left, middle, right] = [0, 1, 2].map(|l| across.light(color(l)));
        across.relief = [middle - 0.5 * (left + right), right - left];
        for side in 0..2 {
            let from = INSIDE.len() + BESIDE.len() * side;
            // Take the color, of three, that differs most from the inside. Near another strand,
            // only one of them may show the ground.
            let three = [0, 1, 2].map(|k| color(from + k));
            let far = three.map(|beside| across.distance(inside, beside));
            let farthest = (0..3).fold(0, |most, k| if far[k] > far[most] { k } else { most });
            let beside = three[farthest];
            across.beside[side] = beside;
            across.edges[side] = across.distance(inside, beside);
            let varies = |a: usize, b: usize| across.distance(three[a], three[b]);
            across.texture += 0.25 * (varies(0, 1) + varies(1, 2));
        }
        across
    }

    fn light(&self, [a, b, c]: [f32; 3]) -> f32 {
        if self.yuv {
            a
        } else {
            0.25 * (a + c) + 0.5 * b
        }
    }

    pub(super) fn distance(&self, a: [f32; 3], b: [f32; 3]) -> f32 {
        color::distance(a, b, self.yuv)
    }

    /// Returns whether the color of the inside continues beyond a tip, in the direction `along`.
    pub(super) fn goes_on(&self, image: &Image, tip: Vec2, along: Vec2, width_px: f32) -> bool {
        let size = [image.width() as f32, image.height() as f32];
        let mut alike = 0;
        for widths in [0.9, 1.4, 1.9] {
            let [x, y] = vec2::along(tip, along, (widths * width_px).max(3.0));
            if x < 0.0 || y < 0.0 || x > size[0] - 1.0 || y > size[1] - 1.0 {
                return false;
            }
            let own = color::between(image, [x, y]);
            let far = self.beside.map(|beside| self.distance(own, beside));
            alike += usize::from(self.distance(own, self.inside) < 0.5 * far[0].min(far[1]));
        }
        alike >= 2
    }
}
