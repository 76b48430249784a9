//! Reads a mask file into one byte per pixel: how likely the pixel is rope, whatever the file's
//! format.
//!
//! A mask may be gray, 16-bit, colored by instance, or the alpha channel of a cut-out. This module
//! converts each of these to levels, where 0 is background. The levels may still be small numbers
//! that label instances.

use std::path::Path;

use image::ColorType;

use crate::picture::{FullPicture, PictureDecoder, read_file};
use crate::source::SourceError;

/// Color of unlabeled pixels: number 255 in the PASCAL VOC palette.
const UNLABELLED: [u16; 3] = [224, 224, 192];
/// The largest value of one byte.
const BYTE: u16 = 255;

/// A mask file, decoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaskPicture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// One byte per pixel, row by row without padding.
    pub levels: Vec<u8>,
    /// One sentence for each ambiguity in the file, with the conclusion.
    pub news: Vec<String>,
}

impl MaskPicture {
    /// Reads a mask file: a picture in any format that lariat reads
    /// ([`PICTURES`](crate::PICTURES)).
    ///
    /// # Errors
    /// The file is missing, cut off, damaged, or not a picture.
    pub fn load(path: &Path) -> Result<Self, SourceError> {
        let unreadable = |error| SourceError::Unreadable {
            path: path.to_owned(),
            error,
        };
        let mut file = Vec::new();
        read_file(path, &mut file).map_err(unreadable)?;
        let full = PictureDecoder::default().decode_full(path, &file);
        let full = full.map_err(|reason| SourceError::Picture { reason })?;
        let [width, height] = full.size;
        let mut news = Vec::new();
        let samples = Samples::of(&full);
        let levels = samples.levels(&mut news);
        Ok(Self {
            width,
            height,
            levels,
            news,
        })
    }
}

/// The samples of a picture: one per channel of each pixel.
struct Samples {
    values: Vec<u16>,
    colors: usize,
    has_alpha: bool,
    is_wide: bool,
}

impl Samples {
    fn of(full: &FullPicture) -> Self {
        use ColorType::{L16, La8, La16, Rgb16, Rgba8, Rgba16};
        let color = full.color;
        let is_wide = matches!(color, L16 | La16 | Rgb16 | Rgba16);
        let has_alpha = matches!(color, La8 | La16 | Rgba8 | Rgba16);
        let values = if is_wide {
            let pairs = full.samples.as_chunks::<2>().0.iter();
            pairs.map(|&pair| u16::from_ne_bytes(pair)).collect()
        } else {
            full.samples.iter().map(|&byte| byte.into()).collect()
        };
        Self {
            values,
            colors: if color.has_color() { 3 } else { 1 },
            has_alpha,
            is_wide,
        }
    }

    fn pixels(&self) -> impl Iterator<Item = &[u16]> + Clone {
        let channels = self.colors + usize::from(self.has_alpha);
        self.values.chunks_exact(channels)
    }

    /// Converts each pixel to a byte.
    fn levels(&self, news: &mut Vec<String>) -> Vec<u8> {
        if let Some(alpha) = self.varying_alpha() {
            news.push("its transparency varies: opaque pixels count as rope".to_owned());
            return self.to_bytes(&alpha, news);
        }
        let colors = self.pixels().map(|pixel| &pixel[..self.colors]);
        if self.colors == 3 && colors.clone().any(|c| c[0] != c[1] || c[1] != c[2]) {
            return self.to_bytes(&self.by_color(news), news);
        }
        let gray: Vec<u16> = colors.map(|color| color[0]).collect();
        self.to_bytes(&gray, news)
    }

    /// The alpha of each pixel, if it varies.
    fn varying_alpha(&self) -> Option<Vec<u16>> {
        if !self.has_alpha {
            return None;
        }
        let alpha: Vec<u16> = self.pixels().map(|pixel| pixel[self.colors]).collect();
        let first = alpha.first().copied();
        alpha.iter().any(|&a| Some(a) != first).then_some(alpha)
    }

    /// Distance of each pixel's color from the background. The background is black, unless another
    /// color covers more than half of the picture.
    fn by_color(&self, news: &mut Vec<String>) -> Vec<u16> {
        let color = |pixel: &[u16]| [pixel[0], pixel[1], pixel[2]];
        let ground = majority(self.pixels().map(color)).unwrap_or_default();
        if ground != [0; 3] {
            news.push(format!(
                "most of it has the color {ground:?}, which counts as background"
            ));
        }
        let has_unlabelled = self.pixels().any(|pixel| color(pixel) == UNLABELLED);
        if has_unlabelled {
            news.push(format!(
                "the color {UNLABELLED:?} stands for pixels without a label, and counts as background"
            ));
        }
        let far = |pixel: &[u16]| {
            let c = color(pixel);
            let is_unlabelled = has_unlabelled && c == UNLABELLED;
            let distance = (0..3).map(|i| c[i].abs_diff(ground[i])).max();
            if is_unlabelled {
                0
            } else {
                distance.unwrap_or(0)
            }
        };
        self.pixels().map(far).collect()
    }

    /// Converts 16-bit values to bytes. If all values fit, they stay unchanged. Otherwise the
    /// largest value determines the number of bits.
    fn to_bytes(&self, values: &[u16], news: &mut Vec<String>) -> Vec<u8> {
        let largest = values.iter().copied().max().unwrap_or(0);
        if largest <= BYTE {
            return values.iter().map(|&value| value as u8).collect();
        }
        let mut bits = crate::bits::Bits::default();
        news.extend(bits.see(largest));
        let byte = |&value: &u16| ((u32::from(bits.widen(value)) + 128) / 257) as u8;
        // A faint 16-bit value stays above 0.
        let level = |value: &u16| byte(value).max(u8::from(*value > 0 && self.is_wide));
        values.iter().map(level).collect()
    }
}

/// The color of more than half of the pixels, by the majority vote of Boyer and Moore ("MJRTY",
/// 1991).
fn majority(colors: impl Iterator<Item = [u16; 3]> + Clone) -> Option<[u16; 3]> {
    let (mut candidate, mut votes) = (None, 0usize);
    for color in colors.clone() {
        if votes == 0 {
            candidate = Some(color);
        }
        votes = if candidate == Some(color) {
            votes + 1
        } else {
            votes - 1
        };
    }
    let (mut count, mut all) = (0usize, 0usize);
    for color in colors {
        count += usize::from(candidate == Some(color));
        all += 1;
    }
    candidate.filter(|_| 2 * count > all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgb, RgbImage, Rgba};

    /// Writes a picture as PNG and reads it as a mask.
    fn mask(picture: impl Into<DynamicImage>) -> MaskPicture {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mask.png");
        picture.into().save(&path).expect("it is written");
        MaskPicture::load(&path).expect("a mask")
    }

    fn three(colors: [[u8; 3]; 3]) -> RgbImage {
        RgbImage::from_fn(5, 1, |x, _| Rgb(colors[x.saturating_sub(2) as usize]))
    }

    #[test]
    fn colors_of_instances_are_levels_over_the_background() {
        let found = mask(three([[0; 3], [90, 0, 0], [0, 0, 180]]));
        assert_eq!(
            (found.levels, found.news.len()),
            (vec![0, 0, 0, 90, 180], 0)
        );
        let found = mask(three([[255; 3], [255, 0, 0], [200, 255, 255]]));
        assert_eq!(found.levels, [0, 0, 0, 255, 55]);
        assert!(found.news[0].contains("[255, 255, 255]"));
        let found = mask(three([[0; 3], [128, 0, 0], [224, 224, 192]]));
        assert_eq!(found.levels, [0, 0, 0, 128, 0]);
        assert!(found.news[0].contains("without a label"));
    }

    #[test]
    fn alpha_that_varies_is_the_mask() {
        let cut_out = ImageBuffer::from_fn(3, 1, |x, _| Rgba([9u8, 8, 7, 120 * x as u8]));
        assert_eq!(mask(cut_out).levels, [0, 120, 240]);
        let opaque = ImageBuffer::from_fn(3, 1, |x, _| LumaA([x as u8, 255u8]));
        assert_eq!(mask(opaque).levels, [0, 1, 2]);
    }

    #[test]
    fn numbers_of_16_bits_stay_numbers_or_are_scaled() {
        let wide = |values: [u16; 4]| {
            let picture = ImageBuffer::<Luma<u16>, _>::from_raw(4, 1, values.to_vec());
            mask(picture.expect("four samples")).levels
        };
        assert_eq!(wide([0, 1, 2, 1]), [0, 1, 2, 1]);
        assert_eq!(wide([0, 65535, 32768, 1]), [0, 255, 128, 1]);
        assert_eq!(wide([0, 1023, 0, 512]), [0, 255, 0, 128]);
    }
}
