//! Warped pictures: ropes whose width changes along them, as real ones do by their lay, by bends and
//! by perspective. Drawn ropes are as wide everywhere.

use image::{GrayImage, RgbImage};
use lariat_portable::SplitMix64;

/// Number of waves that are added.
const WAVES: usize = 4;
/// Range of a wave's length, in pixels.
const LENGTH_PX: (f64, f64) = (18.0, 90.0);
/// Maximum change of a wave's scale: amplitude times wave number.
const STRETCH: f64 = 0.22;

/// A displacement of each point of a picture.
pub(super) struct Warp([Wave; WAVES]);

struct Wave {
    /// Change of the phase per pixel, along x and y.
    turn: [f64; 2],
    phase: f64,
    /// Displacement at the wave's top, in pixels.
    by_px: [f64; 2],
}

impl Warp {
    pub(super) fn draw(random: &mut SplitMix64) -> Self {
        Self([(); WAVES].map(|()| {
            let number = std::f64::consts::TAU / random.uniform(LENGTH_PX.0, LENGTH_PX.1);
            let mut directed = |length: f64| {
                let angle = random.uniform(0.0, std::f64::consts::TAU);
                [length * libm::cos(angle), length * libm::sin(angle)]
            };
            let turn = directed(number);
            let by_px = directed(STRETCH / number);
            let phase = random.uniform(0.0, std::f64::consts::TAU);
            Wave { turn, phase, by_px }
        }))
    }

    /// Returns the point of the original picture that is seen at `at`.
    fn source(&self, at: [f64; 2]) -> [f64; 2] {
        let add = |to: [f64; 2], wave: &Wave| {
            let phase = wave.phase + wave.turn[0] * at[0] + wave.turn[1] * at[1];
            let share = libm::sin(phase) / WAVES as f64;
            [0, 1].map(|k| to[k] + share * wave.by_px[k])
        };
        self.0.iter().fold(at, add)
    }

    /// Warps a picture, between its pixels.
    pub(super) fn picture(&self, of: &RgbImage) -> RgbImage {
        let last = [of.width(), of.height()].map(|side| f64::from(side) - 1.0);
        RgbImage::from_fn(of.width(), of.height(), |x, y| {
            let from = self.source([x.into(), y.into()]);
            let from = [0, 1].map(|k| from[k].clamp(0.0, last[k]));
            let low = from.map(f64::floor);
            let high = [0, 1].map(|k| (low[k] + 1.0).min(last[k]));
            let share = [0, 1].map(|k| from[k] - low[k]);
            let at = |x: f64, y: f64| of.get_pixel(x as u32, y as u32).0.map(f64::from);
            let [a, b] = [at(low[0], low[1]), at(high[0], low[1])];
            let [c, d] = [at(low[0], high[1]), at(high[0], high[1])];
            image::Rgb([0, 1, 2].map(|k| {
                let upper = a[k] + share[0] * (b[k] - a[k]);
                let lower = c[k] + share[0] * (d[k] - c[k]);
                (upper + share[1] * (lower - upper)).round() as u8
            }))
        })
    }

    /// Warps labels, to the nearest pixel.
    pub(super) fn labels(&self, of: &GrayImage) -> GrayImage {
        let last = [of.width() - 1, of.height() - 1];
        GrayImage::from_fn(of.width(), of.height(), |x, y| {
            let from = self.source([x.into(), y.into()]);
            let [x, y] = [0, 1].map(|k| (from[k].round().max(0.0) as u32).min(last[k]));
            *of.get_pixel(x, y)
        })
    }
}
