//! Difference of each pixel from the table, straight from the camera's bytes, and the pixels that
//! exceed the table's noise.
//!
//! `difference = max over channels |pixel − table|`, with U and V counted double. The maximum
//! scales with the share of rope in a pixel (see `color::distance`). The rope's edge is therefore
//! at half the rope's own difference, whatever its color. Everything that is needed from every
//! pixel is computed here, while the row is in cache.

mod planes;
mod table;

use super::background::Background;
use super::threshold::Levels;
use crate::bitmap::bits::BitPlane;
use crate::image::gray::GrayPlane;
use crate::image::kernels::{self, Band, Kernels, Rows};
use crate::image::{Image, PixelFormat, color};
use std::ops::Range;
use table::Table;

/// Rows, and pixels along a row, that share one evaluation of the table's surface. The surface
/// takes many more pixels to change by one level.
const BLOCK: usize = kernels::BLOCK;

/// Pixels along a row that are processed together.
const STRIP: usize = 64;

/// Pixels down a column that are processed together.
const PART: usize = 64;

/// Maximum noise level of the table at which only the parts that exceed the noise are computed.
/// Differences above this level also matter to steps that read the difference alongside the mask.
const MOST_NOISE: u8 = 24;

/// Memory of the differencing.
#[derive(Debug, Default)]
pub(crate) struct Differencer {
    kernels: Kernels,
    /// The table along the current band.
    table: Table,
    /// The table along the previous band.
    before: Table,
    /// Hits of each strip of the bands, with an empty strip at each end and an empty band above and
    /// below.
    hits: Vec<u8>,
    /// Hits in the second plane of a band.
    chroma_hits: Vec<u8>,
    /// The blocks that were computed, band after band; empty if all were.
    kept: Vec<bool>,
    /// One row of the difference.
    row: Vec<u8>,
}

/// The inputs of an image's difference.
#[derive(Clone, Copy)]
struct Scene<'a> {
    image: &'a Image<'a>,
    background: &'a Background,
    least: u8,
}

impl Scene<'_> {
    /// The rows of the band that begins at `top`.
    fn band(&self, top: usize) -> Range<usize> {
        top..(top + BLOCK).min(self.image.height())
    }

    /// Number of bands, and number of strips of 64 pixels.
    fn blocks(&self) -> (usize, usize) {
        let (width, height) = (self.image.width(), self.image.height());
        (height.div_ceil(BLOCK), width.div_ceil(STRIP))
    }
}

impl Differencer {
    /// Fills `out` with the difference of each pixel of `image` from `background`. Marks pixels of
    /// at least `least` in `faint` and records the levels.
    ///
    /// If nothing reaches `least` within eight pixels of a pixel, `out` may be 0 there until it is
    /// [filled](Self::fill).
    pub(crate) fn run(
        &mut self,
        image: &Image,
        background: &Background,
        least: u8,
        out: &mut GrayPlane,
        faint: &mut BitPlane,
        levels: &mut Levels,
    ) {
        let scene = Scene {
            image,
            background,
            least,
        };
        self.work(scene, least <= MOST_NOISE, out, faint, levels);
    }

    /// As [`run`](Self::run), either only where there are hits (`is_sparse`) or everywhere.
    fn work(
        &mut self,
        scene: Scene,
        is_sparse: bool,
        out: &mut GrayPlane,
        faint: &mut BitPlane,
        levels: &mut Levels,
    ) {
        let image = scene.image;
        let (width, height) = (image.width(), image.height());
        out.resize(width, height);
        faint.reshape(width, height);
        levels.clear(width, height);
        self.reserve_blocks(scene);
        let kernel = match image.format() {
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => Some(self.kernels.three_channel_band),
            PixelFormat::Yuyv => self.kernels.yuyv_band,
            PixelFormat::Uyvy => self.kernels.uyvy_band,
            _ => None,
        };
        if is_sparse {
            self.run_where_seen(scene, kernel, out, faint, levels);
        } else {
            self.run_everywhere(scene, kernel, out, faint, levels);
        }
        levels.close();
    }

    /// Computes what [`run`](Self::run) left at 0. Keeps levels that have been lifted since then.
    pub(crate) fn fill(&mut self, image: &Image, background: &Background, out: &mut GrayPlane) {
        if self.kept.is_empty() {
            return;
        }
        self.kept.clear();
        let mut row = std::mem::take(&mut self.row);
        for y in 0..image.height() {
            if y % BLOCK == 0 {
                self.table.lay(&self.kernels, image, background, y);
            }
            self.table.apart(&self.kernels, image, [0, y], &mut row);
            let pairs = out.row_mut(y).iter_mut().zip(&row);
            pairs.for_each(|(level, &own)| *level = own.max(*level));
        }
        self.row = row;
    }

    fn run_everywhere(
        &mut self,
        scene: Scene,
        kernel: Option<fn(Band)>,
        out: &mut GrayPlane,
        faint: &mut BitPlane,
        levels: &mut Levels,
    ) {
        let (image, least) = (scene.image, scene.least);
        let (width, words) = (image.width(), scene.blocks().1);
        for top in (0..image.height()).step_by(BLOCK) {
            self.table.lay(&self.kernels, image, scene.background, top);
            let rows = scene.band(top);
            let (out, faint) = (out.rows_mut(rows.clone()), faint.rows_mut(rows.clone()));
            if let Some(kernel) = kernel {
                kernel(Band {
                    rows: image.rows(rows.clone()),
                    stride: image.stride(),
                    table: &self.table.luma,
                    width,
                    out,
                    out_stride: width,
                    faint,
                    faint_stride: words,
                    least,
                });
            } else {
                let lines = out.chunks_exact_mut(width);
                let faint = faint.chunks_exact_mut(words);
                for (y, (out, faint)) in rows.clone().zip(lines.zip(faint)) {
                    self.table.apart(&self.kernels, image, [0, y], out);
                    (self.kernels.at_least)(out, least, faint);
                }
            }
            let lines = out.chunks_exact(width).zip(faint.chunks_exact(words));
            for (y, (row, bits)) in rows.zip(lines) {
                levels.add(&self.kernels, y, row, bits);
                if levels.asks_table(y) {
                    levels.add_table(row, least);
                }
            }
        }
    }

    /// Searches each band. Once the band below has also been searched, computes the parts with hits
    /// in the band or in one next to it, while the bytes are still in cache.
    fn run_where_seen(
        &mut self,
        scene: Scene,
        kernel: Option<fn(Band)>,
        out: &mut GrayPlane,
        faint: &mut BitPlane,
        levels: &mut Levels,
    ) {
        let (bands, strips) = scene.blocks();
        self.kept.resize(bands * strips, false);
        for band in 0..=bands {
            std::mem::swap(&mut self.table, &mut self.before);
            if band < bands {
                self.look_at(scene, band, levels);
            }
            if let Some(band) = band.checked_sub(1) {
                self.work_out(scene, band, kernel, out, faint, levels);
            }
        }
    }

    /// Lays the table along a band and searches the band for pixels that differ from it.
    fn look_at(&mut self, scene: Scene, band: usize, levels: &mut Levels) {
        let (image, strips, least) = (scene.image, scene.blocks().1, scene.least);
        let (width, top) = (image.width(), BLOCK * band);
        self.table.lay(&self.kernels, image, scene.background, top);
        let format = image.format();
        // U and V count double.
        let half = least.div_ceil(2);
        let least = match format {
            PixelFormat::Yuyv => [least, half],
            PixelFormat::Uyvy => [half, least],
            _ => [least; 2],
        };
        let rows = scene.band(top);
        let at = (band + 1) * (strips + 2) + 1;
        let hits = &mut self.hits[at..at + strips];
        let (stride, bytes) = (image.stride(), format.row_bytes(2) / 2);
        (self.kernels.look)(Rows {
            rows: image.rows(rows.clone()),
            stride,
            row: if bytes == 1 {
                width
            } else {
                format.row_bytes(width)
            },
            bytes,
            table: &self.table.luma,
            least,
            hits,
        });
        if format == PixelFormat::Nv12 {
            let lines = image.chroma_line(rows.start)..image.chroma_line(rows.end - 1) + 1;
            (self.kernels.look)(Rows {
                rows: image.rows(lines),
                stride,
                row: format.row_bytes(width),
                bytes,
                table: &self.table.chroma,
                least: [half; 2],
                hits: &mut self.chroma_hits[..strips],
            });
            let both = hits.iter_mut().zip(&self.chroma_hits);
            both.for_each(|(hits, chroma)| *hits |= chroma);
        }
        for y in scene.band(top) {
            if !levels.asks_table(y) {
                continue;
            }
            let mut row = std::mem::take(&mut self.row);
            self.table.apart(&self.kernels, image, [0, y], &mut row);
            levels.add_table(&row, scene.least);
            self.row = row;
        }
    }

    /// Computes a band where it has hits or is next to hits.
    fn work_out(
        &mut self,
        scene: Scene,
        band: usize,
        kernel: Option<fn(Band)>,
        out: &mut GrayPlane,
        faint: &mut BitPlane,
        levels: &mut Levels,
    ) {
        let (image, strips) = (scene.image, scene.blocks().1);
        let (width, rows) = (image.width(), scene.band(BLOCK * band));
        let kept = &mut self.kept[band * strips..][..strips];
        let [above, here, below] =
            [band, band + 1, band + 2].map(|k| &self.hits[k * (strips + 2)..][..strips + 2]);
        let seen = |strip: usize| above[strip] | here[strip] | below[strip];
        for (strip, kept) in kept.iter_mut().enumerate() {
            let beside = seen(strip) & Rows::RIGHT | seen(strip + 2) & Rows::LEFT;
            *kept = seen(strip + 1) | beside != 0;
        }
        let out = out.keep_blocks(rows.start, kept);
        let faint = faint.rows_mut(rows.clone());
        faint.fill(0);
        let bytes = image.rows(rows.clone());
        let part = |strip: usize| image.format().row_bytes(STRIP) * strip;
        let mut first = 0;
        while first < strips {
            let run = kept[first..].iter().take_while(|kept| **kept).count();
            let end = first + run;
            let (x, pixels) = (STRIP * first, (STRIP * end).min(width) - STRIP * first);
            match kernel {
                _ if run == 0 => {}
                Some(kernel) => kernel(Band {
                    rows: &bytes[part(first)..],
                    stride: image.stride(),
                    table: &self.before.luma[part(first)..],
                    width: pixels,
                    out: &mut out[x..],
                    out_stride: width,
                    faint: &mut faint[first..],
                    faint_stride: strips,
                    least: scene.least,
                }),
                None => {
                    let faint = faint.chunks_exact_mut(strips);
                    for (y, (out, faint)) in
                        rows.clone().zip(out.chunks_exact_mut(width).zip(faint))
                    {
                        let out = &mut out[x..x + pixels];
                        self.before.apart(&self.kernels, image, [x, y], out);
                        (self.kernels.at_least)(out, scene.least, &mut faint[first..end]);
                    }
                }
            }
            first = end + 1;
        }
        if here.iter().all(|&hits| hits == 0) {
            return;
        }
        let lines = out.chunks_exact(width).zip(faint.chunks_exact(strips));
        for (y, (row, bits)) in rows.zip(lines) {
            levels.add(&self.kernels, y, row, bits);
        }
    }

    /// Computes the difference down a column from pixel [x, y] into `out`, compiled for the
    /// caller's registers. The table has one color along all of it.
    #[inline(always)]
    pub(crate) fn down(image: &Image, table: [u8; 3], [x, y]: [usize; 2], out: &mut [u8]) {
        // U and V count double.
        let more = if color::is_yuv(image.format()) {
            0xFF
        } else {
            0
        };
        for (part, out) in out.chunks_mut(PART).enumerate() {
            let mut pixels = [[0; 4]; PART];
            color::down(image, [x, y + part * PART], out.len(), |k, [a, b, c]| {
                pixels[k] = [a, b, c, 0];
            });
            four_channels(&pixels, table, more, out);
        }
    }

    /// Clears the hits of the last image and reserves all memory that this one may need, so that a
    /// camera's first noisy frame allocates nothing.
    fn reserve_blocks(&mut self, scene: Scene) {
        let (bands, strips) = scene.blocks();
        self.hits.clear();
        self.hits.resize((bands + 2) * (strips + 2), 0);
        self.chroma_hits.resize(strips, 0);
        self.kept.clear();
        self.kept.reserve(bands * strips);
        self.row.resize(scene.image.width(), 0);
    }
}

/// Differences of pixels of four bytes. The last byte is unused.
#[inline(always)]
fn four_channels(pixels: &[[u8; 4]; PART], [a, b, c]: [u8; 3], more: u8, out: &mut [u8]) {
    let mut differences = [0; PART];
    for (difference, pixel) in differences.iter_mut().zip(pixels) {
        let chroma = pixel[1].abs_diff(b).max(pixel[2].abs_diff(c));
        let chroma = chroma.saturating_add(chroma & more);
        *difference = pixel[0].abs_diff(a).max(chroma);
    }
    out.copy_from_slice(&differences[..out.len()]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns an image's difference, the filled difference, the faint pixels, and the cut that its
    /// levels give.
    fn made(
        (by, is_sparse): (&mut Differencer, bool),
        (image, background, least): (&Image, &Background, u8),
        out: &mut GrayPlane,
    ) -> (Vec<u8>, Vec<u8>, BitPlane, String) {
        let (mut faint, mut levels) = <(BitPlane, Levels)>::default();
        let scene = Scene {
            image,
            background,
            least,
        };
        by.work(scene, is_sparse, out, &mut faint, &mut levels);
        let bare = out.bytes().to_vec();
        by.fill(image, background, out);
        let cut = format!(
            "{:?}",
            crate::mask::threshold::choose(&levels, background.noise)
        );
        (bare, out.bytes().to_vec(), faint, cut)
    }

    proptest! {
        /// Runs on several images in sequence, so that each meets the state that the one before has
        /// left.
        #[test]
        fn what_is_not_worked_out_is_the_tables(
            width in 1usize..300, height in 1usize..60, seed: u64, noise in 1u64..14, least in 10u8..30,
            spots in prop::collection::vec((0.0f32..1.0, 0.0f32..1.0, 1usize..20, any::<u8>()), 0..5),
        ) {
            let mut state = seed | 1;
            let mut next = move || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                state >> 33
            };
            let (mut sparse, mut whole) = <(Differencer, Differencer)>::default();
            let (mut out, mut other) = <(GrayPlane, GrayPlane)>::default();
            let fewer = &spots[..spots.len() / 2];
            use PixelFormat::*;
            for (format, spots) in [Rgb8, Yuyv, Uyvy, Nv12, Gray8].into_iter().zip([&spots[..], fewer, fewer, &spots[..], fewer]) {
                let stride = 3 * width + 5;
                let rows = format.rows(height);
                let mut bytes: Vec<u8> = (0..stride * rows).map(|_| 90 + (next() % noise) as u8).collect();
                for &(x, y, side, byte) in spots {
                    let (x, y) = ((x * stride as f32) as usize, (y * rows as f32) as usize);
                    for y in y..(y + side).min(rows) {
                        bytes[y * stride + x..][..(3 * side).min(stride - x)].fill(byte);
                    }
                }
                let image = Image::new(&bytes, width, height, stride, format).expect("whole");
                let mut background = Background::default();
                background.estimate(&image);
                let of = (&image, &background, least);
                let (bare, filled, faint, cut) = made((&mut sparse, true), of, &mut out);
                let (full, expected, all_faint, all_cut) = made((&mut whole, false), of, &mut other);
                prop_assert_eq!(&filled, &expected);
                prop_assert_eq!((&faint, cut), (&all_faint, all_cut));
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    let (own, all) = (bare[y * width + x], full[y * width + x]);
                    prop_assert!(own == all || own == 0);
                    if own != all {
                        let near = |at: usize, last: usize| at.saturating_sub(8)..(at + 9).min(last);
                        for (x, y) in near(y, height).flat_map(|y| near(x, width).map(move |x| (x, y))) {
                            prop_assert!(full[y * width + x] < least);
                        }
                    }
                }
            }
        }
    }
}
