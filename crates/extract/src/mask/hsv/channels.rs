//! A row of an image as three channels of one byte per pixel, in any format.

use super::kernels::Kernels;
use crate::image::{Image, PixelFormat};

/// Memory for a row of three channels.
#[derive(Debug, Default)]
pub(super) struct Channels {
    planes: [Vec<u8>; 3],
}

impl Channels {
    /// The channels of row `y`, in the order of [`color::native`](crate::image::color::native).
    pub(super) fn of<'a>(
        &'a mut self,
        kernels: &Kernels,
        image: &Image<'a>,
        y: usize,
    ) -> [&'a [u8]; 3] {
        let (row, width) = (image.row(y), image.width());
        let even = width.next_multiple_of(2);
        self.planes.iter_mut().for_each(|p| p.resize(even, 0));
        let [a, b, c] = self.planes.each_mut().map(|plane| &mut plane[..]);
        match image.format() {
            PixelFormat::Gray8 => return [row; 3],
            PixelFormat::Rgb8 => {
                (kernels.split_three)(row, [&mut a[..width], &mut b[..width], &mut c[..width]]);
            }
            PixelFormat::Bgr8 => {
                (kernels.split_three)(row, [&mut c[..width], &mut b[..width], &mut a[..width]]);
            }
            PixelFormat::Yuyv => (kernels.split_yuyv)(row, [a, b, c]),
            PixelFormat::Uyvy => (kernels.split_uyvy)(row, [a, b, c]),
            PixelFormat::Nv12 => {
                // Two rows share their U and V.
                if y.is_multiple_of(2) {
                    (kernels.split_uv)(image.chroma_row(y), [b, c]);
                }
                let [_, u, v] = &self.planes;
                return [row, &u[..width], &v[..width]];
            }
            // Other formats were unpacked earlier.
            _ => {}
        }
        self.planes.each_ref().map(|plane| &plane[..width])
    }
}

#[cfg(test)]
mod tests {
    use super::super::kernels;
    use super::*;
    use crate::image::color;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_format_comes_apart_into_its_pixels(
            width in 1usize..300, height in 1usize..4, extra in 0usize..5, seed: u64,
        ) {
            let stride = 4 * width + extra;
            let mut state = seed | 1;
            let bytes: Vec<u8> = (0..stride * (2 * height + 1))
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    (state >> 56) as u8
                })
                .collect();
            use PixelFormat::*;
            for (format, kernels) in [Gray8, Rgb8, Bgr8, Yuyv, Uyvy, Nv12]
                .into_iter()
                .flat_map(|format| kernels::all().into_iter().map(move |k| (format, k)))
            {
                let image = Image::new(&bytes, width, height, stride, format).expect("enough bytes");
                let mut channels = Channels::default();
                for y in 0..height {
                    let planes = channels.of(&kernels, &image, y);
                    for x in 0..width {
                        prop_assert_eq!(planes.map(|p| p[x]), color::native(&image, x, y));
                    }
                }
            }
        }
    }
}
