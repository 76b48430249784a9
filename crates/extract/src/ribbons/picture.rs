//! The picture in which ribbons are sought: brightness and chroma, smoothed to reduce pixel noise,
//! and scaled down if it is large.

use lariat_portable::{Arch, NullaryFnOnce};

use super::{Color, squared_distance};
use crate::image::gray::GrayPlane;
use crate::image::{Image, PixelFormat, color};
use crate::statistics;
use crate::vec2::Vec2;

/// Maximum side of the picture, in pixels. Larger images are reduced to the means of blocks.
const LONGEST: usize = 1000;
/// Step between the pixels that are used to measure noise.
const STRIDE: usize = 5;
/// Number of rows over which a pixel is smoothed.
const RING: usize = 5;

/// The smoothed picture.
#[derive(Debug, Default)]
pub(super) struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Pixels of the image, along one axis, per pixel of this picture.
    pub(super) scale: usize,
    /// Median change over two pixels: noise and grain.
    pub(super) noise: f32,
    colors: Vec<Color>,
    /// Probability that each pixel is rope, 255 for certain.
    likely: Vec<u8>,
    /// A line of the image, and a row of the picture before it is smoothed.
    row: Vec<u32>,
    means: Vec<Color>,
    /// The last rows, smoothed along themselves.
    ring: Vec<Color>,
    steps: Vec<f32>,
}

impl Picture {
    /// Reserves the buffers for images of this size. Returns the picture's size.
    pub(super) fn reserve(&mut self, width: usize, height: usize) -> [usize; 2] {
        self.scale = width.max(height).div_ceil(LONGEST);
        (self.width, self.height) = (width / self.scale, height / self.scale);
        let pixels = self.width * self.height;
        self.colors.reserve(pixels);
        self.likely.reserve(pixels);
        self.row.reserve(width);
        self.means.reserve(self.width);
        self.ring.reserve(RING * self.width);
        self.steps
            .reserve(pixels / (STRIDE * STRIDE) + self.height + self.width);
        [self.width, self.height]
    }

    /// Reads an image, and the probabilities that its pixels are rope.
    pub(super) fn take(&mut self, image: &Image, likely: &GrayPlane) {
        self.scale = image.width().max(image.height()).div_ceil(LONGEST);
        self.width = image.width() / self.scale;
        self.height = image.height() / self.scale;
        self.read(image);
        self.likely.clear();
        for y in 0..self.height {
            // From the middle of each block.
            let row = likely.row(y * self.scale + self.scale / 2);
            if self.scale == 1 {
                self.likely.extend_from_slice(row);
                continue;
            }
            let places = row.iter().skip(self.scale / 2).step_by(self.scale);
            self.likely.extend(places.take(self.width));
        }
        self.noise = self.find_noise();
    }

    fn find_noise(&mut self) -> f32 {
        self.steps.clear();
        for y in (0..self.height).step_by(STRIDE) {
            let row = &self.colors[y * self.width..][..self.width];
            let steps = row.windows(3).step_by(STRIDE);
            // The root of the median of the squares is the median.
            (self.steps).extend(steps.map(|near| squared_distance(near[0], near[2])));
        }
        statistics::median_of_positive(&mut self.steps).sqrt()
    }

    /// Computes the mean color of each block, smoothed. Goes row by row, so that unsmoothed rows
    /// stay in the first-level cache.
    fn read(&mut self, image: &Image) {
        let (width, height) = (self.width, self.height);
        self.colors.resize(width * height, [0.0; 3]);
        self.row.resize(width * self.scale, 0);
        self.means.resize(width, [0.0; 3]);
        self.ring.resize(RING * width, [0.0; 3]);
        for y in 0..height + 2 {
            if y < height {
                self.read_row(image, y);
                let out = &mut self.ring[y % RING * width..][..width];
                Arch::new().dispatch(Along {
                    row: self.means.as_flattened(),
                    out: out.as_flattened_mut(),
                });
            }
            if let Some(y) = y.checked_sub(2) {
                let rows = [-2, -1, 0, 1, 2].map(|by| {
                    let y = y.saturating_add_signed(by).min(height - 1);
                    self.ring[y % RING * width..][..width].as_flattened()
                });
                let out = &mut self.colors[y * width..][..width];
                Arch::new().dispatch(Across {
                    rows,
                    out: out.as_flattened_mut(),
                });
            }
        }
    }

    /// Computes the means of a row of blocks.
    fn read_row(&mut self, image: &Image, y: usize) {
        let scale = self.scale;
        self.means.fill([0.0; 3]);
        for line in y * scale..(y + 1) * scale {
            color::along(image, line, &mut self.row);
            Arch::new().dispatch(Means {
                pixels: &self.row,
                format: image.format(),
                scale,
                out: &mut self.means,
            });
        }
    }

    /// The color of a pixel.
    pub(super) fn at(&self, x: usize, y: usize) -> Color {
        self.colors[y * self.width + x]
    }

    /// The colors of a row, and the probabilities that its pixels are rope.
    pub(super) fn row(&self, y: usize) -> (&[Color], &[u8]) {
        let row = y * self.width..(y + 1) * self.width;
        (&self.colors[row.clone()], &self.likely[row])
    }

    /// Probability of the pixel at a place, from 0 to 1; 0 outside.
    pub(super) fn likely_at(&self, at: Vec2) -> f32 {
        (self.index(at)).map_or(0.0, |index| f32::from(self.likely[index]) / 255.0)
    }

    /// Index of the pixel at a place, if that is inside.
    pub(super) fn index(&self, [x, y]: Vec2) -> Option<usize> {
        let is_inside =
            x >= -0.5 && y >= -0.5 && x < self.width as f32 - 0.5 && y < self.height as f32 - 0.5;
        is_inside.then(|| self.index_inside([x, y]))
    }

    /// Index of the pixel at a place that is inside.
    #[inline(always)]
    pub(super) fn index_inside(&self, [x, y]: Vec2) -> usize {
        // Convert through an integer as wide as a float, which is faster.
        (y + 0.5) as i32 as usize * self.width + (x + 0.5) as i32 as usize
    }

    /// The color between pixels, if the place is inside.
    #[inline]
    pub(super) fn between(&self, [x, y]: Vec2) -> Option<Color> {
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (i, j) = (x as usize, y as usize);
        if i + 1 >= self.width || j + 1 >= self.height {
            return None;
        }
        let (right, down) = (x - i as f32, y - j as f32);
        let first = j * self.width + i;
        let [upper, lower] = [
            &self.colors[first..][..2],
            &self.colors[first + self.width..][..2],
        ];
        let above = super::mix(upper[0], upper[1], right);
        let below = super::mix(lower[0], lower[1], right);
        Some(super::mix(above, below, down))
    }
}

/// Converts Y, U and V to brightness and chroma.
#[inline(always)]
fn from_yuv([y, u, v]: [f32; 3]) -> Color {
    [y, 2.0 * (u - 128.0), 2.0 * (v - 128.0)]
}

#[inline(always)]
fn from_rgb([r, g, b]: [f32; 3]) -> Color {
    let luma = 0.299 * r + 0.587 * g + 0.114 * b;
    [luma, 1.128 * (b - luma), 1.426 * (r - luma)]
}

/// Adds a line of pixels to the means of blocks.
struct Means<'a> {
    pixels: &'a [u32],
    format: PixelFormat,
    scale: usize,
    out: &'a mut [Color],
}

impl NullaryFnOnce for Means<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.format {
            PixelFormat::Gray8 => self.add(|[light, ..]| [light, 0.0, 0.0]),
            format if color::is_yuv(format) => self.add(from_yuv),
            _ => self.add(from_rgb),
        }
    }
}

impl Means<'_> {
    #[inline(always)]
    fn add(self, converted: impl Fn([f32; 3]) -> Color) {
        let bytes = |pixel: u32| {
            let byte = |shift: u32| (pixel >> shift & 0xff) as i32 as f32;
            [byte(0), byte(8), byte(16)]
        };
        if self.scale == 1 {
            for (out, &pixel) in self.out.iter_mut().zip(self.pixels) {
                *out = converted(bytes(pixel));
            }
            return;
        }
        let share = 1.0 / (self.scale * self.scale) as f32;
        for (out, block) in (self.out.iter_mut()).zip(self.pixels.chunks_exact(self.scale)) {
            for &pixel in block {
                let own = converted(bytes(pixel));
                *out = std::array::from_fn(|c| out[c] + share * own[c]);
            }
        }
    }
}

/// A binomial filter of five pixels along a row.
struct Along<'a> {
    row: &'a [f32],
    out: &'a mut [f32],
}

impl NullaryFnOnce for Along<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { row, out } = self;
        let width = row.len();
        let middle = 6.min(width)..width.saturating_sub(6).max(6.min(width));
        for i in (0..middle.start).chain(middle.end..width) {
            let at = |by: isize| {
                let pixel = (i / 3).saturating_add_signed(by).min(width / 3 - 1);
                row[3 * pixel + i % 3]
            };
            out[i] = binomial([at(-2), at(-1), at(0), at(1), at(2)]);
        }
        let near = [0, 3, 6, 9, 12].map(|by| &row[by.min(width)..]);
        smooth(near, &mut out[middle.start..]);
    }
}

/// A binomial filter across five rows.
struct Across<'a> {
    rows: [&'a [f32]; 5],
    out: &'a mut [f32],
}

impl NullaryFnOnce for Across<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        smooth(self.rows, self.out);
    }
}

/// Applies a binomial filter to five slices, up to the end of the shortest.
#[inline(always)]
fn smooth([a, b, c, d, e]: [&[f32]; 5], out: &mut [f32]) {
    let near = a.iter().zip(b).zip(c).zip(d).zip(e);
    for (out, ((((a, b), c), d), e)) in out.iter_mut().zip(near) {
        *out = binomial([*a, *b, *c, *d, *e]);
    }
}

#[inline(always)]
fn binomial([a, b, c, d, e]: [f32; 5]) -> f32 {
    (a + e + 4.0 * (b + d) + 6.0 * c) / 16.0
}
