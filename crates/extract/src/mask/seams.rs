//! Seams: places within a mask where one strand ends and another begins.
//!
//! A strand is round, so light leaves its sides darker than its middle. On top of another strand,
//! it also casts a narrow shadow. There is therefore a valley of light between two strands that
//! touch or cross, whatever their color. In a valley, the light bends upward across it, after
//! smoothing over a part of the rope's width. The bend is the larger eigenvalue of the second
//! derivatives (Steger, "An unbiased detector of curvilinear structures", 1998).

use lariat_portable::{Arch, NullaryFnOnce};

use crate::bitmap::bits::BitPlane;
use crate::image::{Image, PixelFormat, color};

/// Standard deviation of the smoothing, as a share of the rope's width, and its maximum in pixels
/// for wide ropes.
const SMOOTHED: f32 = 0.21;
const MOST_PX: f32 = 4.0;
/// Reach of the smoothing to either side, in standard deviations.
const REACH: f32 = 3.0;

/// Maximum reach of the smoothing in pixels, and maximum margin around the mask.
const MOST_REACH: usize = (REACH * MOST_PX) as usize;
const MOST_PAD: usize = MOST_REACH + 1;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Seams {
    /// Light of the mask's pixels and of a margin around them. Pixels outside the mask have the
    /// ropes' mean light.
    light: Vec<f32>,
    smoothed: Vec<f32>,
    row: Vec<u32>,
    is_bent: Vec<bool>,
    taps: Vec<f32>,
    /// Place of the mask's rectangle in `light`: the margin on each side, and the length of a row.
    pad: usize,
    width: usize,
    /// Unit of bending, per square pixel: a bend as deep as the standard deviation of the ropes'
    /// light.
    unit: f32,
    /// Pixels of the mask that belong to a seam.
    pub(crate) plane: BitPlane,
}

impl Seams {
    /// Reserves memory for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        let pixels = (width + 2 * MOST_PAD) * (height + 2 * MOST_PAD);
        self.light.reserve(pixels);
        self.smoothed.reserve(pixels);
        self.row.reserve(width);
        self.is_bent.reserve(width);
        self.taps.reserve(2 * MOST_REACH + 1);
        self.plane.resize(width, height);
    }

    /// Smooths the light of `mask`, whose ropes are about `width_px` wide in `image`.
    pub(crate) fn smooth(&mut self, image: &Image, mask: &BitPlane, width_px: f32) {
        let Some([columns, rows]) = mask.bounds() else {
            return;
        };
        let deviation_px = (SMOOTHED * width_px).min(MOST_PX);
        let reach = libm::ceilf(REACH * deviation_px) as usize;
        let pad = reach + 1;
        let width = columns.len() + 2 * pad;
        let deviation = self.read(
            image,
            mask,
            [columns.start, rows.start],
            [width, rows.len() + 2 * pad, pad],
        );
        self.fill_taps(deviation_px, reach);
        Arch::new().dispatch(Smooth {
            light: &mut self.light,
            smoothed: &mut self.smoothed,
            taps: &self.taps,
            width,
        });
        (self.pad, self.width) = (pad, width);
        self.unit = deviation / (deviation_px * deviation_px);
    }

    /// Finds the seams of the mask whose light was [smoothed](Self::smooth). A seam is where the
    /// light bends upward by `bent`, in standard deviations of the ropes' light.
    pub(crate) fn find(&mut self, mask: &BitPlane, bent: f32) {
        self.plane.resize(mask.width(), mask.height());
        let Some([columns, rows]) = mask.bounds() else {
            return;
        };
        let (pad, width) = (self.pad, self.width);
        self.is_bent.resize(columns.len(), false);
        for (k, y) in rows.enumerate() {
            Arch::new().dispatch(Bend {
                above: &self.light[(k + pad - 1) * width + pad - 1..][..columns.len() + 2],
                here: &self.light[(k + pad) * width + pad - 1..][..columns.len() + 2],
                below: &self.light[(k + pad + 1) * width + pad - 1..][..columns.len() + 2],
                least: bent * self.unit,
                is_bent: &mut self.is_bent,
            });
            let bent = self.is_bent.iter().zip(columns.clone());
            for (_, x) in bent.filter(|&(&is_bent, _)| is_bent) {
                if mask.get(x as i32, y as i32) {
                    self.plane.fill(y, x, x + 1, true);
                }
            }
        }
    }

    /// Reads the mask's light and returns its standard deviation.
    fn read(
        &mut self,
        image: &Image,
        mask: &BitPlane,
        [left, top]: [usize; 2],
        [width, height, pad]: [usize; 3],
    ) -> f32 {
        use PixelFormat::*;
        let is_light_first =
            color::is_yuv(image.format()) || matches!(image.format(), Gray8 | Gray16);
        let (mut sum, mut squares, mut count) = (0u64, 0u64, 0u64);
        self.light.clear();
        self.light.resize(width * height, f32::NAN);
        self.row.resize(left + width - 2 * pad, 0);
        let rows = self.light.chunks_exact_mut(width).skip(pad);
        for (k, lights) in rows.take(height - 2 * pad).enumerate() {
            color::along(image, top + k, &mut self.row);
            let pixels = lights[pad..].iter_mut().zip(&self.row[left..]);
            for (x, (light, pixel)) in (left..).zip(pixels) {
                if mask.get(x as i32, (top + k) as i32) {
                    let [a, b, c, _] = pixel.to_le_bytes().map(u32::from);
                    let level = if is_light_first { 3 * a } else { a + b + c };
                    *light = level as f32;
                    sum += u64::from(level);
                    squares += u64::from(level * level);
                    count += 1;
                }
            }
        }
        let share = 1.0 / count.max(1) as f64;
        let mean = sum as f64 * share;
        for light in self.light.iter_mut().filter(|light| light.is_nan()) {
            *light = mean as f32;
        }
        (squares as f64 * share - mean * mean).max(0.0).sqrt() as f32
    }

    fn fill_taps(&mut self, deviation_px: f32, reach: usize) {
        self.taps.clear();
        self.taps.extend((0..=2 * reach).map(|k| {
            let off = (k as f32 - reach as f32) / deviation_px;
            libm::expf(-0.5 * off * off)
        }));
        let sum: f32 = self.taps.iter().sum();
        self.taps.iter_mut().for_each(|tap| *tap /= sum);
    }
}

/// Smooths the light along rows, then down columns. Pixels nearer to the border than the kernel
/// reaches are unchanged.
struct Smooth<'a> {
    light: &'a mut Vec<f32>,
    smoothed: &'a mut Vec<f32>,
    taps: &'a [f32],
    width: usize,
}

impl NullaryFnOnce for Smooth<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            light,
            smoothed,
            taps,
            width,
        } = self;
        let reach = taps.len() / 2;
        smoothed.clone_from(light);
        let rows = light.chunks_exact(width);
        for (out, row) in smoothed.chunks_exact_mut(width).zip(rows) {
            let out = &mut out[reach..width - reach];
            out.fill(0.0);
            for (k, tap) in taps.iter().enumerate() {
                let levels = &row[k..][..out.len()];
                out.iter_mut()
                    .zip(levels)
                    .for_each(|(out, level)| *out += tap * level);
            }
        }
        let rows = light.chunks_exact_mut(width).enumerate().skip(reach);
        let last = smoothed.len() / width - reach;
        for (y, out) in rows.take_while(|&(y, _)| y < last) {
            out.fill(0.0);
            for (k, tap) in taps.iter().enumerate() {
                let levels = &smoothed[(y - reach + k) * width..][..width];
                out.iter_mut()
                    .zip(levels)
                    .for_each(|(out, level)| *out += tap * level);
            }
        }
    }
}

/// For each pixel of a row, tests whether the light bends upward by at least `least` in some
/// direction. The three input rows begin one pixel before the first.
struct Bend<'a> {
    above: &'a [f32],
    here: &'a [f32],
    below: &'a [f32],
    least: f32,
    is_bent: &'a mut [bool],
}

impl NullaryFnOnce for Bend<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let threes = self
            .above
            .windows(3)
            .zip(self.here.windows(3))
            .zip(self.below.windows(3));
        for (is_bent, ((above, here), below)) in self.is_bent.iter_mut().zip(threes) {
            let xx = here[0] + here[2] - 2.0 * here[1];
            let yy = above[1] + below[1] - 2.0 * here[1];
            let xy = 0.25 * (below[2] + above[0] - above[2] - below[0]);
            // The larger eigenvalue is mean + √spread.
            let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
            let (spread, lacking) = (half * half + xy * xy, self.least - mean);
            *is_bent = (lacking < 0.0) | (spread > lacking * lacking);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [120, 80];

    /// Bars from left to right, `width_px` wide, with their middles in these rows and lighter
    /// there. Returns their mask and picture.
    fn bars(width_px: f32, middles: &[f32]) -> (BitPlane, Vec<u8>) {
        let mut mask = BitPlane::default();
        mask.resize(SIZE[0], SIZE[1]);
        let mut pixels = vec![220; SIZE[0] * SIZE[1]];
        for y in 0..SIZE[1] {
            let off = middles.iter().map(|middle| (y as f32 - middle).abs());
            let off = off.fold(f32::INFINITY, f32::min) / (0.5 * width_px);
            if off <= 1.0 {
                mask.fill(y, 10, 110, true);
                let light = 40.0 + 100.0 * (1.0 - off * off).sqrt();
                pixels[y * SIZE[0]..][10..110].fill(light as u8);
            }
        }
        (mask, pixels)
    }

    fn seams(width_px: f32, middles: &[f32]) -> BitPlane {
        let (mask, pixels) = bars(width_px, middles);
        let image = Image::new(&pixels, SIZE[0], SIZE[1], SIZE[0], PixelFormat::Gray8);
        let mut seams = Seams::default();
        seams.smooth(&image.expect("a picture"), &mask, width_px);
        seams.find(&mask, 0.17);
        seams.plane
    }

    #[test]
    fn two_strands_side_by_side_have_a_seam_between_them() {
        for width_px in [8.0, 12.0, 20.0] {
            let plane = seams(width_px, &[30.0, 30.0 + width_px]);
            let between = (30.0 + 0.5 * width_px) as i32;
            for x in 20..100 {
                assert!(plane.get(x, between), "{width_px}: column {x}");
                assert!(!plane.get(x, 30), "{width_px}: column {x}");
            }
        }
    }

    #[test]
    fn the_middle_of_one_strand_is_no_seam() {
        let plane = seams(12.0, &[40.0]);
        for (x, y) in (20..100).flat_map(|x| (37..44).map(move |y| (x, y))) {
            assert!(!plane.get(x, y), "({x}, {y})");
        }
    }

    #[test]
    fn nothing_has_no_seams() {
        assert_eq!(seams(12.0, &[]).count(), 0);
    }
}
