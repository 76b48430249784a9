//! Formats of raw frames: those of messages, and others that are converted to one of them when
//! read.
//!
//! A format is known by lariat's own name and by the names that ffmpeg, GStreamer and ROS use for
//! the same bytes. YUV is in limited range, as these programs write it, except for ffmpeg's
//! `yuvj…`.

use lariat_message::PixelFormat;

use crate::ahead::Layout;
use crate::color_range::ColorRange;
use crate::yuv::{Chroma, write_rgb};

/// Arrangement of the bytes in raw frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawFormat {
    name: &'static str,
    lie: Lie,
    range: ColorRange,
}

/// Arrangement of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lie {
    /// Same as in a message.
    Known(PixelFormat),
    /// Planes of Y, U and V, or of Y, V and U.
    Planes(Chroma, Order),
    /// A plane of Y, and one of VU pairs at half the size.
    Nv21,
    /// A plane of Y, and one of pairs at full size.
    Nv24(Order),
    /// Four bytes per pixel; contains the places of red, green and blue.
    Four([usize; 3]),
}

/// The order of U and V.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Order {
    Uv,
    Vu,
}

const RED_FIRST: [usize; 3] = [0, 1, 2];

/// All names and their formats. If a format has several names, its own name comes first.
const NAMES: [(&str, Lie, ColorRange); 50] = {
    use ColorRange::{Full, Limited};
    use Lie::{Four, Known, Nv21, Nv24, Planes};
    use PixelFormat::{
        BayerBggr8, BayerGbrg8, BayerGrbg8, BayerRggb8, Bgr8, Bgra8, Gray8, Gray16, Nv12, Rgb8,
        Uyvy, Yuyv,
    };
    const I420: Lie = Planes(Chroma::Half, Order::Uv);
    const YV12: Lie = Planes(Chroma::Half, Order::Vu);
    [
        ("gray8", Known(Gray8), Full),
        ("rgb8", Known(Rgb8), Full),
        ("bgr8", Known(Bgr8), Full),
        ("yuyv", Known(Yuyv), Limited),
        ("nv12", Known(Nv12), Limited),
        ("uyvy", Known(Uyvy), Limited),
        ("bgra8", Known(Bgra8), Full),
        ("gray16", Known(Gray16), Full),
        ("bayer_rggb8", Known(BayerRggb8), Full),
        ("bayer_bggr8", Known(BayerBggr8), Full),
        ("bayer_grbg8", Known(BayerGrbg8), Full),
        ("bayer_gbrg8", Known(BayerGbrg8), Full),
        ("i420", I420, Limited),
        ("yv12", YV12, Limited),
        ("nv21", Nv21, Limited),
        ("nv24", Nv24(Order::Uv), Limited),
        ("nv42", Nv24(Order::Vu), Limited),
        ("rgba8", Four(RED_FIRST), Full),
        ("argb8", Four([1, 2, 3]), Full),
        ("abgr8", Four([3, 2, 1]), Full),
        ("yuv422p", Planes(Chroma::HalfWidth, Order::Uv), Limited),
        ("yuv444p", Planes(Chroma::Full, Order::Uv), Limited),
        ("yuv411p", Planes(Chroma::QuarterWidth, Order::Uv), Limited),
        ("yuvj420p", I420, Full),
        ("yuvj422p", Planes(Chroma::HalfWidth, Order::Uv), Full),
        ("yuvj444p", Planes(Chroma::Full, Order::Uv), Full),
        ("yuv420p", I420, Limited),
        ("iyuv", I420, Limited),
        ("yu12", I420, Limited),
        ("yuyv422", Known(Yuyv), Limited),
        ("yuy2", Known(Yuyv), Limited),
        ("yuv422_yuy2", Known(Yuyv), Limited),
        ("uyvy422", Known(Uyvy), Limited),
        ("gray", Known(Gray8), Full),
        ("grey", Known(Gray8), Full),
        ("mono8", Known(Gray8), Full),
        ("mono16", Known(Gray16), Full),
        ("gray16le", Known(Gray16), Full),
        ("rgb24", Known(Rgb8), Full),
        ("rgb", Known(Rgb8), Full),
        ("bgr24", Known(Bgr8), Full),
        ("bgr", Known(Bgr8), Full),
        ("bgra", Known(Bgra8), Full),
        ("bgr0", Known(Bgra8), Full),
        ("bgrx", Known(Bgra8), Full),
        ("rgba", Four(RED_FIRST), Full),
        ("rgb0", Four(RED_FIRST), Full),
        ("rgbx", Four(RED_FIRST), Full),
        ("argb", Four([1, 2, 3]), Full),
        ("abgr", Four([3, 2, 1]), Full),
    ]
};
/// Number of leading entries whose name is not an alias of an earlier one.
const OWN_NAMES: usize = 26;

impl RawFormat {
    /// Returns the format with this name, in upper or lower case.
    pub fn from_name(name: &str) -> Option<Self> {
        let known = NAMES
            .iter()
            .position(|(known, ..)| known.eq_ignore_ascii_case(name))?;
        let (_, lie, range) = NAMES[known];
        let first = NAMES.iter().find(|&&(_, l, r)| (l, r) == (lie, range))?;
        Some(Self {
            name: first.0,
            lie,
            range,
        })
    }

    /// Name of the format.
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// Names of all formats.
    pub fn names() -> impl Iterator<Item = &'static str> {
        NAMES[..OWN_NAMES].iter().map(|&(name, ..)| name)
    }

    /// Number of pixels, across and down, that share a color sample. A frame's sides are multiples
    /// of these.
    fn shared(self) -> [u32; 2] {
        match self.lie {
            Lie::Known(PixelFormat::Nv12) | Lie::Nv21 | Lie::Planes(Chroma::Half, _) => [2, 2],
            Lie::Known(PixelFormat::Yuyv | PixelFormat::Uyvy) => [2, 1],
            Lie::Planes(Chroma::HalfWidth, _) => [2, 1],
            Lie::Planes(Chroma::QuarterWidth, _) => [4, 1],
            _ => [1, 1],
        }
    }

    /// Returns true if a frame can have this size.
    pub(crate) fn fits(self, [width, height]: [u32; 2]) -> bool {
        let [across, down] = self.shared();
        width.is_multiple_of(across) && height.is_multiple_of(down)
    }

    /// Layout of converted frames of this size.
    pub(crate) fn layout(self, [width, height]: [u32; 2]) -> Layout {
        let format = match self.lie {
            Lie::Known(format) => format,
            Lie::Planes(chroma, _) => return chroma.layout(width, height),
            Lie::Nv21 => PixelFormat::Nv12,
            Lie::Nv24(_) | Lie::Four(_) => PixelFormat::Rgb8,
        };
        Layout {
            width,
            height,
            stride: format.row_bytes(width) as u32,
            format,
        }
    }

    /// Number of bytes in an unconverted frame of this size.
    pub(crate) fn frame_bytes(self, size: [u32; 2]) -> usize {
        let [width, height] = size.map(|side| side as usize);
        match self.lie {
            Lie::Known(_) | Lie::Nv21 => self.layout(size).bytes(),
            Lie::Planes(chroma, _) => width * height + 2 * chroma.samples(width, height),
            Lie::Nv24(_) => 3 * width * height,
            Lie::Four(_) => 4 * width * height,
        }
    }

    /// Converts a frame.
    pub(crate) fn write(self, layout: &Layout, frame: &[u8], pixels: &mut [u8]) {
        let (width, height) = (layout.width as usize, layout.height as usize);
        let (light, color) = frame.split_at((width * height).min(frame.len()));
        match self.lie {
            Lie::Known(_) => pixels.copy_from_slice(frame),
            Lie::Planes(chroma, order) => {
                let (first, second) = color.split_at(chroma.samples(width, height));
                let planes = match order {
                    Order::Uv => [light, first, second],
                    Order::Vu => [light, second, first],
                };
                return chroma.write(self.range, layout, planes, pixels);
            }
            Lie::Nv21 => {
                let (to_light, to_color) = pixels.split_at_mut(light.len());
                to_light.copy_from_slice(light);
                let pairs = to_color.as_chunks_mut::<2>().0.iter_mut();
                for (to, &[v, u]) in pairs.zip(color.as_chunks().0) {
                    *to = [u, v];
                }
            }
            Lie::Nv24(order) => {
                let pixels = pixels.as_chunks_mut::<3>().0.iter_mut();
                for ((pixel, y), &[a, b]) in pixels.zip(light).zip(color.as_chunks().0) {
                    let [u, v] = if order == Order::Uv { [a, b] } else { [b, a] };
                    write_rgb(self.range, [&[*y], &[u], &[v]], pixel);
                }
                return;
            }
            Lie::Four(places) => {
                let pixels = pixels.as_chunks_mut::<3>().0.iter_mut();
                for (pixel, four) in pixels.zip(frame.as_chunks::<4>().0) {
                    *pixel = places.map(|place| four[place]);
                }
            }
        }
        self.range
            .expand(layout.format, layout.stride, layout.height, pixels);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Converts a frame of 4 × 2 pixels.
    fn written(name: &str, frame: &[u8]) -> (PixelFormat, Vec<u8>) {
        let format = RawFormat::from_name(name).expect("a format");
        assert_eq!(format.frame_bytes([4, 2]), frame.len(), "{name}");
        let layout = format.layout([4, 2]);
        let mut pixels = vec![0; layout.bytes()];
        format.write(&layout, frame, &mut pixels);
        (layout.format, pixels)
    }

    #[test]
    fn planes_and_pairs_of_every_order_are_the_same_picture() {
        let y = [1, 2, 3, 4, 5, 6, 7, 8];
        let [u, v] = [[10, 11], [20, 21]];
        let full = [&y[..], &u, &v].concat();
        let (format, expected) = written("yuvj420p", &full);
        assert_eq!(format, PixelFormat::Nv12);
        assert_eq!(expected, [&y[..], &[10, 20, 11, 21]].concat());
        let limited = written("i420", &full);
        assert_eq!(written("YUV420P", &full), limited);
        assert_eq!(written("yv12", &[&y[..], &v, &u].concat()), limited);
        assert_eq!(written("nv12", &expected), limited);
        assert_eq!(
            written("nv21", &[&y[..], &[20, 10, 21, 11]].concat()),
            limited
        );
    }

    #[test]
    fn colours_come_out_as_red_green_and_blue() {
        for (name, pixel) in [
            ("rgba8", &[1, 2, 3, 9][..]),
            ("argb", &[9, 1, 2, 3]),
            ("ABGR", &[9, 3, 2, 1]),
            ("rgb0", &[1, 2, 3, 9]),
        ] {
            let expected = (PixelFormat::Rgb8, [1, 2, 3].repeat(8));
            assert_eq!(written(name, &pixel.repeat(8)), expected, "{name}");
        }
        // Red in BT.601, limited range.
        let near = |pixels: &[u8]| {
            let is_red = |p: &[u8]| p[0] > 252 && p[1] < 3 && p[2] < 3;
            pixels.chunks_exact(3).all(is_red)
        };
        let nv24 = [[81; 8].to_vec(), [90, 240].repeat(8)].concat();
        let nv42 = [[81; 8].to_vec(), [240, 90].repeat(8)].concat();
        let planes = [[81; 8], [90; 8], [240; 8]].concat();
        for (name, frame) in [("nv24", nv24), ("nv42", nv42), ("yuv444p", planes)] {
            let (format, pixels) = written(name, &frame);
            assert!(
                format == PixelFormat::Rgb8 && near(&pixels),
                "{name}: {pixels:?}"
            );
        }
    }

    #[test]
    fn every_name_is_known_once_and_other_names_are_names_of_one_of_them() {
        let own: Vec<_> = RawFormat::names().collect();
        for (index, (name, ..)) in NAMES.iter().enumerate() {
            let format = RawFormat::from_name(name).expect("it is known");
            assert!(own.contains(&format.name()), "{name}");
            assert_eq!(format.name() == *name, index < OWN_NAMES, "{name}");
        }
        for format in PixelFormat::ALL {
            assert_eq!(
                RawFormat::from_name(format.name()).map(RawFormat::name),
                Some(format.name())
            );
        }
        assert_eq!(RawFormat::from_name("p010"), None);
    }
}
