//! The picture as ribbons are looked for in it: brightness and chroma, smoothed over the noise of a pixel, and made smaller
//! if it is a large one.

use lariat_portable::{Arch, NullaryFnOnce};

use super::{Color, distance};
use crate::image::gray::GrayPlane;
use crate::image::{Image, PixelFormat, color};
use crate::statistics;
use crate::vec2::Vec2;

/// The longest side that is looked at; of larger pictures the means of blocks are.
const LONGEST: usize = 1000;
/// Pixels from one to the next of which the noise is taken.
const STRIDE: usize = 5;

/// The smoothed picture.
#[derive(Debug, Default)]
pub(super) struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Pixels of the image along a pixel of this.
    pub(super) scale: usize,
    /// The middle change over two pixels: noise and grain.
    pub(super) noise: f32,
    colors: Vec<Color>,
    /// How likely each pixel is of a rope, 255 for certain.
    likely: Vec<u8>,
    spare: Vec<Color>,
    places: Vec<usize>,
    row: Vec<u32>,
    steps: Vec<f32>,
}

impl Picture {
    /// Makes the buffers for images of this size, and says which this is.
    pub(super) fn reserve(&mut self, width: usize, height: usize) -> [usize; 2] {
        self.scale = width.max(height).div_ceil(LONGEST);
        (self.width, self.height) = (width / self.scale, height / self.scale);
        let pixels = self.width * self.height;
        self.colors.reserve(pixels);
        self.likely.reserve(pixels);
        self.spare.reserve(pixels);
        self.places.reserve(width);
        self.row.reserve(width);
        self.steps
            .reserve(pixels / (STRIDE * STRIDE) + self.height + self.width);
        [self.width, self.height]
    }

    /// Takes up an image, and how likely its pixels are of a rope.
    pub(super) fn take(&mut self, image: &Image, likely: &GrayPlane) {
        self.scale = image.width().max(image.height()).div_ceil(LONGEST);
        self.width = image.width() / self.scale;
        self.height = image.height() / self.scale;
        self.read(image);
        self.smooth();
        self.likely.clear();
        for y in 0..self.height {
            // In the middle of each block.
            let row = likely.row(y * self.scale + self.scale / 2);
            let places = row.iter().skip(self.scale / 2).step_by(self.scale);
            self.likely.extend(places.take(self.width));
        }
        self.steps.clear();
        for y in (0..self.height).step_by(STRIDE) {
            let row = &self.colors[y * self.width..][..self.width];
            let steps = row.windows(3).step_by(STRIDE);
            (self.steps).extend(steps.map(|near| distance(near[0], near[2])));
        }
        self.noise = match self.steps.is_empty() {
            true => 0.0,
            false => statistics::median(&mut self.steps),
        };
    }

    /// The mean color of each block.
    fn read(&mut self, image: &Image) {
        let (scale, width) = (self.scale, self.width);
        let share = 1.0 / (scale * scale) as f32;
        self.colors.clear();
        self.colors.resize(width * self.height, [0.0; 3]);
        self.places.clear();
        self.places.extend(0..width * scale);
        self.row.resize(width * scale, 0);
        for y in 0..self.height * scale {
            color::at_places(image, y, &self.places, &mut self.row);
            let colors = &mut self.colors[y / scale * width..][..width];
            for (color, block) in colors.iter_mut().zip(self.row.chunks_exact(scale)) {
                for &pixel in block {
                    let own = converted(pixel, image.format());
                    *color = std::array::from_fn(|c| color[c] + share * own[c]);
                }
            }
        }
    }

    /// A binomial of five pixels either way.
    fn smooth(&mut self) {
        self.spare.resize(self.width * self.height, [0.0; 3]);
        Arch::new().dispatch(Smooth {
            width: 3 * self.width,
            colors: self.colors.as_flattened_mut(),
            spare: self.spare.as_flattened_mut(),
        });
    }

    /// The color of a pixel.
    pub(super) fn at(&self, x: usize, y: usize) -> Color {
        self.colors[y * self.width + x]
    }

    /// The colors of a row, and how likely its pixels are of a rope.
    pub(super) fn row(&self, y: usize) -> (&[Color], &[u8]) {
        let row = y * self.width..(y + 1) * self.width;
        (&self.colors[row.clone()], &self.likely[row])
    }

    /// How likely the pixel at a place is; not at all outside.
    pub(super) fn likely_at(&self, at: Vec2) -> f32 {
        (self.index(at)).map_or(0.0, |index| f32::from(self.likely[index]) / 255.0)
    }

    /// The pixel at a place, if that is inside.
    pub(super) fn index(&self, [x, y]: Vec2) -> Option<usize> {
        let is_inside =
            x >= -0.5 && y >= -0.5 && x < self.width as f32 - 0.5 && y < self.height as f32 - 0.5;
        is_inside.then(|| (y + 0.5) as usize * self.width + (x + 0.5) as usize)
    }

    /// The color between pixels, if the place is inside.
    pub(super) fn between(&self, [x, y]: Vec2) -> Option<Color> {
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (i, j) = (x as usize, y as usize);
        if i + 1 >= self.width || j + 1 >= self.height {
            return None;
        }
        let (right, down) = (x - i as f32, y - j as f32);
        let [above, below] =
            [j, j + 1].map(|j| super::mix(self.at(i, j), self.at(i + 1, j), right));
        Some(super::mix(above, below, down))
    }
}

/// What a pixel of this format is in brightness and chroma.
fn converted(pixel: u32, format: PixelFormat) -> Color {
    let [a, b, c, _] = pixel.to_le_bytes().map(f32::from);
    match format {
        PixelFormat::Gray8 => [a, 0.0, 0.0],
        _ if color::is_yuv(format) => [a, 2.0 * (b - 128.0), 2.0 * (c - 128.0)],
        _ => {
            let luma = 0.299 * a + 0.587 * b + 0.114 * c;
            [luma, 1.128 * (c - luma), 1.426 * (a - luma)]
        }
    }
}

struct Smooth<'a> {
    /// Numbers in a row.
    width: usize,
    colors: &'a mut [f32],
    spare: &'a mut [f32],
}

impl NullaryFnOnce for Smooth<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            width,
            colors,
            spare,
        } = self;
        if width == 0 {
            return;
        }
        let rows = colors
            .chunks_exact(width)
            .zip(spare.chunks_exact_mut(width));
        for (row, out) in rows {
            let middle = 6.min(width)..width.saturating_sub(6).max(6.min(width));
            for i in (0..middle.start).chain(middle.end..width) {
                let at = |by: isize| {
                    let pixel = (i / 3).saturating_add_signed(by).min(width / 3 - 1);
                    row[3 * pixel + i % 3]
                };
                out[i] = binomial([at(-2), at(-1), at(0), at(1), at(2)]);
            }
            let near = [0, 3, 6, 9, 12].map(|by| &row[by.min(width)..]);
            let near = near.map(|row| row.iter());
            let [a, b, c, d, e] = near;
            let near = a.zip(b).zip(c).zip(d).zip(e);
            for (out, ((((a, b), c), d), e)) in out[middle.start..].iter_mut().zip(near) {
                *out = binomial([*a, *b, *c, *d, *e]);
            }
        }
        let height = spare.len() / width;
        for (y, out) in colors.chunks_exact_mut(width).enumerate() {
            let [a, b, c, d, e] = [-2, -1, 0, 1, 2].map(|by| {
                let y = y.saturating_add_signed(by).min(height - 1);
                spare[y * width..][..width].iter()
            });
            let near = a.zip(b).zip(c).zip(d).zip(e);
            for (out, ((((a, b), c), d), e)) in out.iter_mut().zip(near) {
                *out = binomial([*a, *b, *c, *d, *e]);
            }
        }
    }
}

#[inline(always)]
fn binomial([a, b, c, d, e]: [f32; 5]) -> f32 {
    (a + e + 4.0 * (b + d) + 6.0 * c) / 16.0
}
