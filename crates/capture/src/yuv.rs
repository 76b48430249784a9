//! Converts the planes of a video to the pixel formats of frames.

use lariat_message::PixelFormat;

use crate::ahead::Layout;
use crate::color_range::ColorRange;

/// Chroma sampling of a video.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Chroma {
    /// No color.
    Mono,
    /// Half the width and half the height.
    Half,
    /// Half the width.
    HalfWidth,
    /// A quarter of the width.
    QuarterWidth,
    /// One sample per pixel.
    Full,
}

/// Planes of Y, U and V without padding; U and V are empty for mono.
pub(crate) type Planes<'a> = [&'a [u8]; 3];

impl Chroma {
    /// Layout of the frame that [`write`](Self::write) makes.
    pub(crate) fn layout(self, width: u32, height: u32) -> Layout {
        let (format, stride) = match self {
            Self::Mono => (PixelFormat::Gray8, width),
            // A row of UV pairs needs an even number of bytes, even if the image has an odd number
            // of columns.
            Self::Half => (PixelFormat::Nv12, width.next_multiple_of(2)),
            Self::HalfWidth | Self::QuarterWidth => {
                (PixelFormat::Yuyv, 2 * width.next_multiple_of(2))
            }
            Self::Full => (PixelFormat::Rgb8, 3 * width),
        };
        Layout {
            width,
            height,
            stride,
            format,
        }
    }

    /// Number of samples of U, and also of V.
    pub(crate) fn samples(self, width: usize, height: usize) -> usize {
        match self {
            Self::Mono => 0,
            Self::Half => width.div_ceil(2) * height.div_ceil(2),
            Self::HalfWidth => width.div_ceil(2) * height,
            Self::QuarterWidth => width.div_ceil(4) * height,
            Self::Full => width * height,
        }
    }

    /// Writes the planes as one image of that layout, in full range.
    pub(crate) fn write(
        self,
        range: ColorRange,
        layout: &Layout,
        planes: Planes,
        pixels: &mut [u8],
    ) {
        match self {
            Self::Mono => pixels.copy_from_slice(planes[0]),
            Self::Half => write_nv12(layout, planes, pixels),
            Self::HalfWidth => write_yuyv(layout, planes, 1, pixels),
            Self::QuarterWidth => write_yuyv(layout, planes, 2, pixels),
            Self::Full => return write_rgb(range, planes, pixels),
        }
        range.expand(layout.format, layout.stride, layout.height, pixels);
    }
}

fn write_nv12(layout: &Layout, [y, u, v]: Planes, pixels: &mut [u8]) {
    let (width, stride) = (layout.width as usize, layout.stride as usize);
    let (luma, chroma) = pixels.split_at_mut(stride * layout.height as usize);
    for (to, from) in luma.chunks_exact_mut(stride).zip(y.chunks_exact(width)) {
        to[..width].copy_from_slice(from);
        // Repeats the last column if the width is odd.
        to[width..].fill(from[width - 1]);
    }
    for (pair, (u, v)) in chroma.chunks_exact_mut(2).zip(u.iter().zip(v)) {
        pair.copy_from_slice(&[*u, *v]);
    }
}

/// Writes the planes as YUYV. `pairs` is the number of horizontal pixel pairs that share a color
/// sample.
fn write_yuyv(layout: &Layout, [y, u, v]: Planes, pairs: usize, pixels: &mut [u8]) {
    let (width, stride) = (layout.width as usize, layout.stride as usize);
    let chroma_width = width.div_ceil(2 * pairs);
    let chroma = u
        .chunks_exact(chroma_width)
        .zip(v.chunks_exact(chroma_width));
    let rows = pixels.chunks_exact_mut(stride).zip(y.chunks_exact(width));
    for ((to, y), (u, v)) in rows.zip(chroma) {
        for (pair, (to, y)) in to.chunks_exact_mut(4).zip(y.chunks(2)).enumerate() {
            let place = pair / pairs;
            to.copy_from_slice(&[y[0], u[place], y[y.len() - 1], v[place]]);
        }
    }
}

/// Converts YUV to RGB by ITU-R BT.601, in 16-bit fixed point.
pub(crate) fn write_rgb(range: ColorRange, [y, u, v]: Planes, pixels: &mut [u8]) {
    // Factors of Y for all colors, of V for red, of U and V for green, and of U for blue.
    let ([luma, red, green_u, green_v, blue], black) = if range == ColorRange::Full {
        ([65536, 91881, 22554, 46802, 116_130], 0)
    } else {
        ([76309, 104_597, 25675, 53279, 132_201], 16)
    };
    let samples = y.iter().zip(u.iter().zip(v));
    for (pixel, (y, (u, v))) in pixels.chunks_exact_mut(3).zip(samples) {
        let y = luma * (i32::from(*y) - black) + 32768;
        let (u, v) = (i32::from(*u) - 128, i32::from(*v) - 128);
        let channels = [y + red * v, y - green_u * u - green_v * v, y + blue * u];
        for (value, channel) in pixel.iter_mut().zip(channels) {
            *value = (channel >> 16).clamp(0, 255) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_sizes_have_a_chroma_row_and_column_for_the_odd_one() {
        let layout = Chroma::Half.layout(3, 3);
        assert_eq!((layout.stride, layout.bytes()), (4, 4 * 5));
        let y: Vec<u8> = (1..=9).collect();
        let mut pixels = vec![0; layout.bytes()];
        let planes: Planes = [&y, &[10, 11, 12, 13], &[20, 21, 22, 23]];
        Chroma::Half.write(ColorRange::Full, &layout, planes, &mut pixels);
        let expected = [
            [1, 2, 3, 3],
            [4, 5, 6, 6],
            [7, 8, 9, 9],
            [10, 20, 11, 21],
            [12, 22, 13, 23],
        ];
        assert_eq!(pixels, expected.concat());
    }

    #[test]
    fn an_odd_row_of_yuyv_repeats_its_last_pixel() {
        let layout = Chroma::HalfWidth.layout(3, 2);
        let mut pixels = vec![0; layout.bytes()];
        let planes: Planes = [&[1, 2, 3, 4, 5, 6], &[10, 11, 12, 13], &[20, 21, 22, 23]];
        Chroma::HalfWidth.write(ColorRange::Full, &layout, planes, &mut pixels);
        let expected = [[1, 10, 2, 20, 3, 11, 3, 21], [4, 12, 5, 22, 6, 13, 6, 23]];
        assert_eq!(pixels, expected.concat());
    }

    #[test]
    fn four_pixels_of_a_quarter_share_their_colour() {
        let layout = Chroma::QuarterWidth.layout(5, 1);
        let mut pixels = vec![0; layout.bytes()];
        let planes: Planes = [&[1, 2, 3, 4, 5], &[10, 11], &[20, 21]];
        Chroma::QuarterWidth.write(ColorRange::Full, &layout, planes, &mut pixels);
        assert_eq!(pixels, [1, 10, 2, 20, 3, 10, 4, 20, 5, 11, 5, 21]);
    }

    #[test]
    fn every_sampling_of_a_limited_colour_is_the_same_colour() {
        // Red in BT.601, in limited range and in full range.
        let (y, u, v) = ([81; 8], [90; 8], [240; 8]);
        for chroma in [Chroma::Half, Chroma::HalfWidth, Chroma::QuarterWidth] {
            let layout = chroma.layout(4, 2);
            let mut pixels = vec![0; layout.bytes()];
            let samples = chroma.samples(4, 2);
            let planes: Planes = [&y, &u[..samples], &v[..samples]];
            chroma.write(ColorRange::Limited, &layout, planes, &mut pixels);
            let full = [76, 85, 255];
            for level in pixels {
                assert!(
                    full.iter().any(|&known| level.abs_diff(known) <= 1),
                    "{level}"
                );
            }
        }
    }

    #[test]
    fn black_white_and_the_primaries_come_out() {
        // YUV in BT.601 video range, and the color.
        let known = [
            ([16, 128, 128], [0, 0, 0]),
            ([235, 128, 128], [255, 255, 255]),
            ([81, 90, 240], [255, 0, 0]),
            ([145, 54, 34], [0, 255, 0]),
            ([41, 240, 110], [0, 0, 255]),
        ];
        for ([y, u, v], rgb) in known {
            let mut pixel = [0; 3];
            write_rgb(ColorRange::Limited, [&[y], &[u], &[v]], &mut pixel);
            for (value, expected) in pixel.into_iter().zip(rgb) {
                assert!(
                    i32::abs(i32::from(value) - expected) <= 2,
                    "{pixel:?}, {rgb:?}"
                );
            }
        }
        let mut pixel = [0; 3];
        write_rgb(ColorRange::Full, [&[200], &[128], &[128]], &mut pixel);
        assert_eq!(pixel, [200; 3]);
    }
}
