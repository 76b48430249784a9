//! Expands the limited range of video to full range.
//!
//! In limited range (ITU-R BT.601 and BT.709) luma ranges from 16 (black) to 235 (white), and U and
//! V from 16 to 240. The pipeline uses full range, 0 to 255, as do recordings and pictures.
//! Limited-range frames are expanded as they are read. Their colors then match those of a picture
//! of the same scene.

use lariat_message::PixelFormat;

/// Range of levels that a source uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum ColorRange {
    /// 16 to 235, and 16 to 240 for U and V.
    Limited,
    /// 0 to 255.
    #[default]
    Full,
}

/// Expands a luma level to full range: 255 / 219 ≈ 149 / 128 times its distance from black. The
/// error is at most 0.6.
fn luma(level: u8) -> u8 {
    let expanded = (u16::from(level.saturating_sub(16)) * 149 + 64) >> 7;
    expanded.min(255) as u8
}

/// Expands a level of U or V to full range: 255 / 224 ≈ 146 / 128 times its distance from 128. The
/// error is at most 0.8.
fn chroma(level: u8) -> u8 {
    // The product exceeds the result by 128 · 146 / 128 − 128 = 18. `OFF` is 64 (half a level) less
    // than that, so that the result is rounded to the nearest level.
    const OFF: u16 = 18 * 128 - 64;
    let expanded = (u16::from(level) * 146).saturating_sub(OFF) >> 7;
    expanded.min(255) as u8
}

impl ColorRange {
    /// Expands an image in one of the YUV formats to full range; other formats stay unchanged.
    pub(crate) fn expand_yuv(
        self,
        format: PixelFormat,
        stride: u32,
        height: u32,
        pixels: &mut [u8],
    ) {
        if format != PixelFormat::Gray8 {
            self.expand(format, stride, height, pixels);
        }
    }

    /// Expands an image in one of the YUV formats, or in gray, to full range.
    pub(crate) fn expand(self, format: PixelFormat, stride: u32, height: u32, pixels: &mut [u8]) {
        if self == Self::Full {
            return;
        }
        let each = |bytes: &mut [u8], of: fn(u8) -> u8| bytes.iter_mut().for_each(|b| *b = of(*b));
        match format {
            PixelFormat::Gray8 => each(pixels, luma),
            PixelFormat::Nv12 => {
                let rows = (stride as usize * height as usize).min(pixels.len());
                let (light, color) = pixels.split_at_mut(rows);
                each(light, luma);
                each(color, chroma);
            }
            PixelFormat::Yuyv => {
                for [y, c] in pixels.as_chunks_mut().0 {
                    (*y, *c) = (luma(*y), chroma(*c));
                }
            }
            PixelFormat::Uyvy => {
                for [c, y] in pixels.as_chunks_mut().0 {
                    (*y, *c) = (luma(*y), chroma(*c));
                }
            }
            // Not YUV, and never in limited range.
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_expanded_to_the_nearest() {
        for level in 0..=255u8 {
            let exact = |black: f64, middle: f64, span: f64| {
                ((f64::from(level) - black) * 255.0 / span + middle).clamp(0.0, 255.0)
            };
            let off = |found: u8, exact: f64| (f64::from(found) - exact).abs();
            assert!(off(luma(level), exact(16.0, 0.0, 219.0)) <= 0.6, "{level}");
            assert!(
                off(chroma(level), exact(128.0, 128.0, 224.0)) <= 0.8,
                "{level}"
            );
        }
        assert_eq!([16, 235].map(luma), [0, 255]);
        assert_eq!([16, 128, 240].map(chroma), [0, 128, 255]);
    }

    #[test]
    fn each_byte_is_expanded_as_what_it_is() {
        for (format, bytes, expected) in [
            (PixelFormat::Yuyv, [235, 240, 16, 16], [255, 255, 0, 0]),
            (PixelFormat::Uyvy, [240, 235, 16, 16], [255, 255, 0, 0]),
            (PixelFormat::Gray8, [235, 16, 240, 0], [255, 0, 255, 0]),
            (PixelFormat::Rgb8, [235, 16, 240, 0], [235, 16, 240, 0]),
        ] {
            let mut pixels = bytes;
            ColorRange::Limited.expand(format, 4, 1, &mut pixels);
            assert_eq!(pixels, expected, "{format:?}");
            pixels = bytes;
            ColorRange::Full.expand(format, 4, 1, &mut pixels);
            assert_eq!(pixels, bytes);
        }
        let mut nv12 = [235, 235, 16, 16, 240, 16];
        ColorRange::Limited.expand(PixelFormat::Nv12, 2, 2, &mut nv12);
        assert_eq!(nv12, [255, 255, 0, 0, 255, 0]);
    }
}
