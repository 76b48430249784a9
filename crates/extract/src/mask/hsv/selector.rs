//! Makes a mask from ranges of colors.

use super::channels::Channels;
use super::contains;
use super::cube::Cube;
use super::kernels::Kernels;
use crate::bitmap::bits::BitPlane;
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};
use crate::options::HsvRange;

/// Images of fewer pixels are tested color by color. A small image is finished before the answers
/// for all colors would be known. The many small pictures that are seen once, when colors are
/// picked, are not worth 2 MiB.
const FEWEST_PIXELS: usize = 1 << 15;

/// Memory of the mask by ranges.
#[derive(Debug, Default)]
pub(crate) struct Selector {
    kernels: Kernels,
    cube: Cube,
    channels: Channels,
}

impl Selector {
    /// Computes the answers for images of this size in advance.
    pub(crate) fn prepare(&mut self, ranges: &[HsvRange], pixels: usize, yuv: bool) {
        if pixels >= FEWEST_PIXELS && !self.cube.is_of(ranges, yuv) {
            self.cube.fill(ranges, yuv);
        }
    }

    /// Sets the pixels of `mask` that are in any range. In `inside`, these are 255 and the others
    /// 0.
    pub(crate) fn run(
        &mut self,
        image: &Image,
        ranges: &[HsvRange],
        inside: &mut GrayPlane,
        mask: &mut BitPlane,
    ) {
        let (width, height) = (image.width(), image.height());
        inside.resize(width, height);
        mask.resize(width, height);
        if width * height < FEWEST_PIXELS {
            return one_by_one(image, ranges, inside, mask);
        }
        self.prepare(ranges, width * height, color::is_yuv(image.format()));
        for y in 0..height {
            let planes = self.channels.of(&self.kernels, image, y);
            (self.kernels.select)(&self.cube, planes, inside.row_mut(y), mask.row_mut(y));
        }
    }
}

/// Definition of [`Selector::run`].
fn one_by_one(image: &Image, ranges: &[HsvRange], inside: &mut GrayPlane, mask: &mut BitPlane) {
    for y in 0..image.height() {
        let (bytes, words) = (inside.row_mut(y), mask.row_mut(y));
        // Neighbors on a table mostly have the same color, so the last answer can often be reused.
        let (mut last, mut answer) = ([0; 3], contains(ranges, [0; 3]));
        for (x, byte) in bytes.iter_mut().enumerate() {
            let rgb = color::rgb(image, x, y);
            if rgb != last {
                (last, answer) = (rgb, contains(ranges, rgb));
            }
            *byte = if answer { 255 } else { 0 };
            words[x / 64] |= u64::from(answer) << (x % 64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cube::tests::examples;
    use super::*;
    use crate::image::PixelFormat;

    #[test]
    fn an_image_is_selected_pixel_by_pixel_in_every_format_and_after_a_change_of_ranges() {
        // Odd sides and all kinds of colors: every byte varies on its own.
        let (width, height) = (225usize, 147usize);
        let stride = 3 * width + 225;
        let bytes: Vec<u8> = (0..stride * (height + height.div_ceil(2)))
            .map(|i| ((i % stride * 7 / 16) ^ (i / stride * (1 + i % 4))) as u8)
            .collect();
        let (mut selector, mut inside, mut mask) = <(Selector, GrayPlane, BitPlane)>::default();
        let (mut expected, mut expected_mask) = <(GrayPlane, BitPlane)>::default();
        for ranges in &examples()[..2] {
            use PixelFormat::*;
            for format in [Rgb8, Gray8, Bgr8, Yuyv, Uyvy, Nv12] {
                let image = Image::new(&bytes, width, height, stride, format).expect("whole");
                selector.run(&image, ranges, &mut inside, &mut mask);
                expected.resize(width, height);
                expected_mask.resize(width, height);
                one_by_one(&image, ranges, &mut expected, &mut expected_mask);
                assert!(mask == expected_mask, "{format:?}");
                assert!(
                    (0..height).all(|y| inside.row(y) == expected.row(y)),
                    "{format:?}"
                );
            }
        }
    }
}
