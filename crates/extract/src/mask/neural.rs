//! The mask from the network, for pictures of any size and format.

use std::ops::Range;
use std::sync::Arc;

use lariat_network::{Maps, Network, Picture, Workspace};
use lariat_portable::{Arch, NullaryFnOnce};

use crate::image::gray::GrayPlane;
use crate::image::{Image, PixelFormat, Region, color};

/// Maximum number of pixels that the network gets. Larger pictures are reduced to the means of
/// blocks.
const MOST_PIXELS: usize = 640 * 640;
/// Reduction of a glance's picture relative to a search's. Ropes are likely if at least one in
/// `LEAST` of its pixels is likely rope. In a VGA picture, that is a rope 4 pixels wide and a
/// quarter of the picture's height long.
const GLANCE: usize = 2;
const LEAST: usize = 640;
/// Margin that the search adds around what may be rope, in pixels of the image.
const AROUND_PX: usize = 96;

/// The network and its memory.
#[derive(Debug)]
pub(crate) struct Finder {
    network: Arc<Network>,
    workspace: Workspace,
    /// The network's input.
    rgb: Vec<u8>,
    rope: Vec<u8>,
    seam: Vec<u8>,
    row: Vec<u32>,
    line: Vec<[u8; 3]>,
    /// A row of blocks, summed down the picture: three numbers per pixel.
    sums: Vec<u32>,
}

impl Default for Finder {
    fn default() -> Self {
        Self::new(Network::ropes())
    }
}

impl Finder {
    pub(crate) fn new(network: Arc<Network>) -> Self {
        Self {
            network,
            workspace: Workspace::new(),
            rgb: Vec::new(),
            rope: Vec::new(),
            seam: Vec::new(),
            row: Vec::new(),
            line: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// Returns whether a rope may be in the part `within` of `image`: whether enough pixels there
    /// are rope with at least the probability `likely`. Costs a quarter of finding the rope.
    pub(crate) fn glance(&mut self, image: &Image, within: Region, likely: u8) -> bool {
        let scale = GLANCE * scale_of(image.width(), image.height());
        let Some(part) = image.region(within) else {
            return false;
        };
        let pixels = (image.width() / scale) * (image.height() / scale);
        let is_seen = self.look(&part, scale).is_some();
        let guessed = || self.rope.iter().filter(|&&rope| rope >= likely).count();
        !is_seen || LEAST * guessed() >= pixels
    }

    /// Fills `levels`, of the image's size, with the probability that each pixel is rope. It is 255
    /// for certain, and 0 outside the part `within`. A seam between two adjacent ropes belongs to
    /// neither.
    pub(crate) fn find(&mut self, image: &Image, within: Region, levels: &mut GrayPlane) {
        levels.resize(image.width(), image.height());
        (0..image.height()).for_each(|y| levels.row_mut(y).fill(0));
        let scale = scale_of(image.width(), image.height());
        let part = image.region(within);
        let Some(pixels) = part.and_then(|part| self.look(&part, scale)) else {
            return;
        };
        for (rope, seam) in self.rope.iter_mut().zip(&self.seam) {
            *rope = (u16::from(*rope) * u16::from(255 - seam) / 255) as u8;
        }
        self.spread(scale, pixels, within, levels);
    }

    /// Runs the network on the means of blocks of `scale` × `scale` pixels, and returns the number
    /// of columns and rows. `None` for a strip that is too long for the network, or without blocks.
    fn look(&mut self, image: &Image, scale: usize) -> Option<[usize; 2]> {
        let (columns, rows) = (image.width() / scale, image.height() / scale);
        self.rope.resize(columns * rows, 0);
        self.seam.resize(columns * rows, 0);
        let is_as_it_lies = scale == 1 && image.format() == PixelFormat::Rgb8;
        if !is_as_it_lies {
            self.read(image, scale, [columns, rows]);
        }
        let (rgb, stride) = match is_as_it_lies {
            true => (image.bytes(), image.stride()),
            false => (&self.rgb[..], 3 * columns),
        };
        let picture = Picture {
            rgb,
            width: columns,
            height: rows,
            stride,
        };
        let maps = Maps {
            rope: &mut self.rope,
            seam: &mut self.seam,
            stride: columns,
        };
        let seen = self.network.run(&mut self.workspace, picture, maps);
        seen.ok().map(|()| [columns, rows])
    }

    /// Computes the means of blocks in red, green and blue.
    fn read(&mut self, image: &Image, scale: usize, [columns, rows]: [usize; 2]) {
        let format = image.format();
        self.row.resize(columns * scale, 0);
        self.line.resize(columns * scale, [0; 3]);
        self.sums.resize(3 * columns * scale, 0);
        self.rgb.resize(3 * columns * rows, 0);
        let out = self.rgb.as_chunks_mut().0.chunks_exact_mut(columns.max(1));
        for (y, out) in out.enumerate() {
            if scale == 1 {
                color::along(image, y, &mut self.row);
                let pixels = &self.row[..];
                Arch::new().dispatch(InRgb {
                    pixels,
                    format,
                    out,
                });
                continue;
            }
            self.sums.fill(0);
            for line in y * scale..(y + 1) * scale {
                let sums = &mut self.sums;
                if format == PixelFormat::Rgb8 {
                    let line = image.row(line);
                    Arch::new().dispatch(AddLine { line, sums });
                    continue;
                }
                color::along(image, line, &mut self.row);
                Arch::new().dispatch(InRgb {
                    pixels: &self.row,
                    format,
                    out: &mut self.line,
                });
                let line = self.line.as_flattened();
                Arch::new().dispatch(AddLine { line, sums });
            }
            let sums = &self.sums[..];
            Arch::new().dispatch(Means { sums, scale, out });
        }
    }

    /// Writes the map at the picture's size, interpolated between the middles of blocks.
    fn spread(
        &self,
        scale: usize,
        [columns, rows]: [usize; 2],
        within: Region,
        levels: &mut GrayPlane,
    ) {
        if scale == 1 {
            for (y, row) in self.rope.chunks_exact(columns).enumerate() {
                levels.row_mut(within.y + y)[within.x..][..columns].copy_from_slice(row);
            }
            return;
        }
        // In units of half a pixel: the middle of block k is at scale · (2k + 1) − 1.
        let place = |at: usize, count: usize| {
            let from = (2 * at + 1).saturating_sub(scale);
            let first = (from / (2 * scale)).min(count - 1);
            let share = from - 2 * scale * first;
            (first, (first + 1).min(count - 1), share.min(2 * scale))
        };
        let whole = 2 * scale;
        for y in 0..within.height {
            let (above, below, down) = place(y, rows);
            let out = &mut levels.row_mut(within.y + y)[within.x..][..within.width];
            for (x, out) in out.iter_mut().enumerate() {
                let (left, right, along) = place(x, columns);
                let mix = |row: usize| {
                    let at = |column: usize| usize::from(self.rope[row * columns + column]);
                    at(left) * (whole - along) + at(right) * along
                };
                let sum = mix(above) * (whole - down) + mix(below) * down;
                *out = (sum / (whole * whole)) as u8;
            }
        }
    }

    /// Reserves the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        let scale = scale_of(width, height);
        let (columns, rows) = (width / scale, height / scale);
        self.workspace.reserve(columns, rows);
        self.rope.reserve(columns * rows);
        self.seam.reserve(columns * rows);
        self.rgb.reserve(3 * columns * rows);
        self.row.reserve(width);
        self.line.reserve(width);
        self.sums.reserve(3 * columns * scale);
    }
}

/// The part of an image in these columns and rows, with the margin that the network needs. It
/// begins at the start of whole blocks of pixels.
pub(super) fn grown([columns, rows]: [Range<usize>; 2], image: &Image) -> Region {
    let begin = |at: usize| at.saturating_sub(AROUND_PX) / Network::MULTIPLE * Network::MULTIPLE;
    let end = |at: usize| (at + AROUND_PX).next_multiple_of(Network::MULTIPLE);
    let (x, y) = (begin(columns.start), begin(rows.start));
    Region {
        x,
        y,
        width: end(columns.end).min(image.width()) - x,
        height: end(rows.end).min(image.height()) - y,
    }
}

/// Pixels of the image, along one axis, per pixel of the network's input.
fn scale_of(width: usize, height: usize) -> usize {
    (1..)
        .find(|scale| (width / scale) * (height / scale) <= MOST_PIXELS)
        .unwrap_or(1)
}

/// Converts a row of pixels to red, green and blue.
struct InRgb<'a> {
    pixels: &'a [u32],
    format: PixelFormat,
    out: &'a mut [[u8; 3]],
}

impl NullaryFnOnce for InRgb<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.format {
            PixelFormat::Gray8 | PixelFormat::Gray16 => self.write(|[light, ..]| [light; 3]),
            format if color::is_yuv(format) => self.write(color::yuv_to_rgb),
            _ => self.write(|rgb| rgb),
        }
    }
}

impl InRgb<'_> {
    #[inline(always)]
    fn write(self, converted: impl Fn([u8; 3]) -> [u8; 3]) {
        for (out, pixel) in self.out.iter_mut().zip(self.pixels) {
            let [a, b, c, _] = pixel.to_le_bytes();
            *out = converted([a, b, c]);
        }
    }
}

/// Adds the levels of a line to the sums of those above it.
struct AddLine<'a> {
    line: &'a [u8],
    sums: &'a mut [u32],
}

impl NullaryFnOnce for AddLine<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (sum, &level) in self.sums.iter_mut().zip(self.line) {
            *sum += u32::from(level);
        }
    }
}

/// Means of blocks whose columns have been summed.
struct Means<'a> {
    sums: &'a [u32],
    scale: usize,
    out: &'a mut [[u8; 3]],
}

impl NullaryFnOnce for Means<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let count = (self.scale * self.scale) as u32;
        // Division by multiplication. It is exact because a sum times the count is below 2⁴⁰.
        let share = (1u64 << 40).div_ceil(u64::from(count));
        for (out, block) in (self.out.iter_mut()).zip(self.sums.chunks_exact(3 * self.scale)) {
            let mut sum = [count / 2; 3];
            for pixel in block.as_chunks::<3>().0 {
                (0..3).for_each(|k| sum[k] += pixel[k]);
            }
            *out = [0, 1, 2].map(|k| ((u64::from(sum[k]) * share) >> 40) as u8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_grown_to_whole_blocks_within_the_image() {
        let pixels = vec![0; 650 * 480];
        let image = Image::new(&pixels, 650, 480, 650, PixelFormat::Gray8).expect("a picture");
        let grown = |columns, rows| grown([columns, rows], &image);
        for part in [grown(200..260, 210..230), grown(0..20, 470..480)] {
            assert_eq!([part.x, part.y].map(|at| at % Network::MULTIPLE), [0, 0]);
            assert!(part.x + part.width <= 650 && part.y + part.height <= 480);
        }
        let inner = grown(200..260, 210..230);
        assert!(inner.x <= 200 - AROUND_PX && inner.x + inner.width >= 260 + AROUND_PX);
        assert!(inner.y <= 210 - AROUND_PX && inner.y + inner.height >= 230 + AROUND_PX);
        let all = Region {
            x: 0,
            y: 0,
            width: 650,
            height: 480,
        };
        assert_eq!(grown(0..650, 0..480), all);
    }
}
