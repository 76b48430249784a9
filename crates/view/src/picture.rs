//! Encodes a frame as a JPEG, no larger than it is shown.

use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use lariat_chain::pipeline::FrameView;
use lariat_wire::FrameHeader;

/// JPEG quality. Lines are drawn over the picture separately, so it need not be sharper than this.
const QUALITY: u8 = 82;
/// Chroma subsampling: four pixels share one color, as in most JPEGs.
const SAMPLING: SamplingFactor = SamplingFactor::F_2_2;
/// Maximum reduction of a picture.
const MOST_SMALLER: u32 = 8;

/// A frame's pixels: red, green, blue, row by row.
#[derive(Debug)]
pub(crate) struct Rgb {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixels: Vec<u8>,
}

/// Returns the colors of a frame as the mask sees them; `None` if the image is blank, or the header
/// does not describe these bytes.
pub(crate) fn rgb(header: &FrameHeader, bytes: &[u8]) -> Option<Rgb> {
    if header.is_blank() {
        return None;
    }
    let image = FrameView::new(header, bytes).image().ok()?;
    Some(Rgb {
        width: header.width,
        height: header.height,
        pixels: image.to_rgb(),
    })
}

/// Returns the integer reduction, from 1 to [`MOST_SMALLER`], for a picture `width` pixels wide
/// that is shown `shown` pixels wide.
pub(crate) fn times_smaller(width: u32, shown: u32) -> u32 {
    (width / shown.max(1)).clamp(1, MOST_SMALLER)
}

impl Rgb {
    /// Encodes the picture as a JPEG, reduced by a factor. `None` if it is too large for a JPEG.
    pub(crate) fn jpeg(&self, times: u32) -> Option<Vec<u8>> {
        let smaller;
        let picture = match times {
            ..=1 => self,
            _ => {
                smaller = self.smaller(times as usize)?;
                &smaller
            }
        };
        let [width, height] = [picture.width, picture.height].map(u16::try_from);
        let mut jpeg = Vec::new();
        let mut encoder = Encoder::new(&mut jpeg, QUALITY);
        encoder.set_sampling_factor(SAMPLING);
        let pixels = &picture.pixels;
        (encoder.encode(pixels, width.ok()?, height.ok()?, ColorType::Rgb)).ok()?;
        Some(jpeg)
    }

    /// Averages squares of `times` pixels a side. Incomplete squares at the right and bottom are
    /// left out.
    fn smaller(&self, times: usize) -> Option<Self> {
        let row = 3 * self.width as usize;
        let [width, height] = [self.width, self.height].map(|side| side as usize / times);
        if width == 0 || height == 0 {
            return None;
        }
        let area = (times * times) as u32;
        let mut pixels = Vec::with_capacity(3 * width * height);
        let mut sums = vec![0_u32; 3 * width];
        for rows in self.pixels.chunks_exact(row * times) {
            sums.fill(0);
            for line in rows.chunks_exact(row) {
                let squares = line.chunks_exact(3 * times);
                for (sum, square) in sums.chunks_exact_mut(3).zip(squares) {
                    for pixel in square.chunks_exact(3) {
                        (0..3).for_each(|i| sum[i] += u32::from(pixel[i]));
                    }
                }
            }
            pixels.extend(sums.iter().map(|sum| ((sum + area / 2) / area) as u8));
        }
        Some(Self {
            width: width as u32,
            height: height as u32,
            pixels,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_made_smaller_where_it_is_shown_smaller_and_never_larger() {
        assert_eq!(times_smaller(640, 1280), 1);
        assert_eq!(times_smaller(640, 640), 1);
        assert_eq!(times_smaller(3840, 1200), 3);
        assert_eq!(times_smaller(8192, 0), 8);
    }

    #[test]
    fn a_smaller_picture_has_the_means_of_its_pixels() {
        let pixels = (0..5 * 3).flat_map(|i| [i, 2 * i, 100]).collect();
        let picture = Rgb {
            width: 5,
            height: 3,
            pixels,
        };
        let smaller = picture.smaller(2).unwrap();
        assert_eq!((smaller.width, smaller.height), (2, 1));
        // The means of 0, 1, 5, 6 and of 2, 3, 7, 8.
        assert_eq!(smaller.pixels, [3, 6, 100, 5, 10, 100]);
        assert!(picture.smaller(4).is_none());
    }

    #[test]
    fn a_jpeg_decodes_to_the_picture() {
        let picture = Rgb {
            width: 32,
            height: 16,
            pixels: [200, 40, 60].repeat(32 * 16),
        };
        let jpeg = picture.jpeg(2).unwrap();
        let decoded = image::load_from_memory(&jpeg).unwrap().into_rgb8();
        assert_eq!(decoded.dimensions(), (16, 8));
        let pixel = decoded.get_pixel(8, 4).0;
        assert!(
            pixel
                .iter()
                .zip([200, 40, 60])
                .all(|(a, b)| a.abs_diff(b) < 6),
            "{pixel:?}"
        );
    }
}
