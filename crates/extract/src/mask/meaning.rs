//! Meaning of a mask's bytes.
//!
//! Extraction expects a mask that is high where a rope is. Programs also write 0 and 1, instance
//! numbers, or ropes that are black on white. Each of these is recognized from the mask alone and
//! converted to what extraction expects, with a notice.

use super::MaskError;
use crate::image::{Image, ImageError, PixelFormat};

/// Minimum level that the automatic cut keeps, alone or next to a rope of 255: an eighth
/// (`level.rs`).
const LEAST_KEPT: u8 = 32;
/// Level of pixels without a label, next to labels that are small numbers (PASCAL VOC, Cityscapes).
const UNLABELLED: u8 = 255;
/// Minimum share of the pixels with small levels that are inside areas of one level, if these
/// levels are labels. In a label's area, all pixels except single corners are inside. In a soft
/// edge or noise, few are.
const INSIDE: f32 = 0.9;
/// Maximum number of small levels that are checked one by one. In a mask with more, this many rows
/// are checked, evenly spread.
const MOST_SMALL: usize = 1 << 15;
const ROWS: usize = 64;

/// A mask that extraction can use, and a notice if the original bytes had another meaning.
#[derive(Debug)]
#[non_exhaustive]
pub struct MaskLevels {
    /// One byte per pixel, row by row without padding. The higher, the more likely rope.
    pub levels: Vec<u8>,
    /// Width and height, in pixels.
    pub size: [usize; 2],
    /// A sentence on the meaning of the mask's bytes.
    pub notice: Option<String>,
}

impl MaskLevels {
    /// The levels as an image for extraction.
    ///
    /// # Errors
    /// If the mask is larger than extraction accepts.
    pub fn image(&self) -> Result<Image<'_>, ImageError> {
        let [width, height] = self.size;
        Image::new(&self.levels, width, height, width, PixelFormat::Gray8)
    }
}

/// Interprets the bytes of a mask whose level is to be chosen by its own histogram. Returns `None`
/// if extraction can use the mask as it is.
///
/// # Errors
/// If all pixels have the same level and it is not 0: nothing tells ropes from the rest.
pub fn mask_levels(mask: &Image) -> Result<Option<MaskLevels>, MaskError> {
    // The extractor rejects masks of other formats.
    if mask.format() != PixelFormat::Gray8 {
        return Ok(None);
    }
    let (width, height) = (mask.width(), mask.height());
    let counts = histogram(mask);
    let total = width * height;
    let used = |level: &usize| counts[*level] > 0;
    let least = (0..256).find(used).unwrap_or(0);
    let most = (0..256).rfind(used).unwrap_or(0);
    if most == 0 {
        return Ok(None);
    }
    if least == most {
        return Err(MaskError::OneLevel(most as u8));
    }
    let bright: usize = counts[(least + most).div_ceil(2)..].iter().sum();
    let is_inverted = 2 * bright > total;
    // Offset of the smallest level above the ground's.
    let step = counts[least + 1..].iter().position(|&count| count > 0);
    let has_small = step.is_some_and(|step| step + 1 < usize::from(LEAST_KEPT));
    if !is_inverted && !has_small {
        return Ok(None);
    }
    let (least, most) = (least as u8, most as u8);
    let turned = |level: u8| {
        if is_inverted {
            most - level
        } else {
            level - least
        }
    };
    let is_labelled = is_labelled(mask, &counts, turned);
    if !is_inverted && !is_labelled {
        return Ok(None);
    }
    let mut levels = Vec::with_capacity(total);
    for y in 0..height {
        levels.extend(mask.row(y).iter().map(|&level| turned(level)));
    }
    let inverted = is_inverted.then(|| {
        let share = 100.0 * bright as f32 / total as f32;
        format!(
            "the bright part of the mask covers {share:.0} % of it, more than ropes do: its dark part is taken for the ropes \
             (write ropes brighter than the rest)"
        )
    });
    let labels = is_labelled.then(|| number_labels(&mut levels, least, most - least));
    let size = [width, height];
    Ok(Some(MaskLevels {
        levels,
        size,
        notice: inverted.or(labels.flatten()),
    }))
}

/// Replaces labels with 255 and describes them. `ground` is what was subtracted from them, and
/// `top` is the largest.
fn number_labels(levels: &mut [u8], ground: u8, top: u8) -> Option<String> {
    let mut seen = [false; 256];
    (levels.iter()).for_each(|&level| seen[usize::from(level)] = true);
    let unlabelled = UNLABELLED - ground;
    let label = |level: &u8| seen[usize::from(*level)] && *level != unlabelled;
    let smallest = (1..=top).find(label)?;
    let largest = (1..=top).rfind(label)?;
    for level in levels.iter_mut() {
        *level = if (1..=largest).contains(level) {
            255
        } else {
            0
        };
    }
    let numbers = if smallest == largest {
        format!("{}", ground + largest)
    } else {
        format!("{} to {}", ground + smallest, ground + largest)
    };
    let beside = if largest < top {
        ", and 255 for pixels without a label"
    } else {
        ""
    };
    Some(format!(
        "the mask's levels are numbers: {numbers} counts as rope{beside} (mask_level changes this)"
    ))
}

/// Number of pixels of each level.
fn histogram(mask: &Image) -> [usize; 256] {
    let mut counts = [0; 256];
    let mut zeros = 0;
    for y in 0..mask.height() {
        let (eights, rest) = mask.row(y).as_chunks::<8>();
        for eight in eights {
            // Most of a mask is 0.
            if u64::from_ne_bytes(*eight) == 0 {
                zeros += 8;
            } else {
                eight
                    .iter()
                    .for_each(|&level| counts[usize::from(level)] += 1);
            }
        }
        rest.iter()
            .for_each(|&level| counts[usize::from(level)] += 1);
    }
    counts[0] += zeros;
    counts
}

/// Returns whether the mask, with its levels `turned`, has small levels that are labels: areas of
/// one level, not slopes or noise.
///
/// A pixel is inside an area if a square of 2 × 2 pixels that contains it has one level.
fn is_labelled(mask: &Image, counts: &[usize; 256], turned: impl Fn(u8) -> u8) -> bool {
    let (width, height) = (mask.width(), mask.height());
    let is_small = |level: u8| (1..LEAST_KEPT).contains(&turned(level));
    let levels = (0..=255u8).zip(counts).filter(|&(_, &count)| count > 0);
    let all: usize = levels
        .filter(|&(level, _)| is_small(level))
        .map(|(_, count)| count)
        .sum();
    let step = if all > MOST_SMALL {
        (height / ROWS).max(1)
    } else {
        1
    };
    let is_square = |x: usize, y: usize| {
        let (upper, lower) = (&mask.row(y)[x..x + 2], &mask.row(y + 1)[x..x + 2]);
        upper == lower && upper[0] == upper[1]
    };
    let (mut small, mut inside) = (0u32, 0u32);
    for y in (0..height).step_by(step) {
        for x in 0..width {
            if !is_small(mask.row(y)[x]) {
                continue;
            }
            small += 1;
            let mut columns = (x.saturating_sub(1)..=x).filter(|&left| left + 1 < width);
            let is_inside = columns.any(|left| {
                let mut rows = (y.saturating_sub(1)..=y).filter(|&top| top + 1 < height);
                rows.any(|top| is_square(left, top))
            });
            inside += u32::from(is_inside);
        }
    }
    small > 0 && inside as f32 >= INSIDE * small as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (60, 40);

    /// Bars of 6 rows, each of its own level, on a ground of one level.
    fn bars(ground: u8, levels: &[u8]) -> Vec<u8> {
        let mut mask = vec![ground; SIZE.0 * SIZE.1];
        for (index, level) in levels.iter().enumerate() {
            let from = (2 + 9 * index) * SIZE.0;
            mask[from..from + 6 * SIZE.0].fill(*level);
        }
        mask
    }

    /// The levels, and the notice about them.
    type Read = Option<(Vec<u8>, Option<String>)>;

    fn read(mask: &[u8]) -> Result<Read, MaskError> {
        let image = Image::new(mask, SIZE.0, SIZE.1, SIZE.0, PixelFormat::Gray8).unwrap();
        let read = mask_levels(&image)?;
        Ok(read.map(|read| (read.levels, read.notice)))
    }

    #[test]
    fn small_numbers_are_ropes_each() {
        for ground in [0, 1] {
            for labels in [&[2, 2][..], &[2, 3], &[2, 3, 31, 4], &[3, 200]] {
                let (levels, notice) = read(&bars(ground, labels)).unwrap().unwrap();
                assert_eq!(levels, bars(0, &vec![255; labels.len()]), "{labels:?}");
                assert!(notice.unwrap().contains("numbers: "), "{labels:?}");
            }
        }
    }

    #[test]
    fn pixels_without_a_label_are_not_rope() {
        let (levels, notice) = read(&bars(0, &[1, 255, 2])).unwrap().unwrap();
        assert_eq!(levels, bars(0, &[255, 0, 255]));
        assert!(notice.unwrap().contains("without a label"));
    }

    #[test]
    fn what_is_high_where_a_rope_is_stays_as_it_is() {
        assert!(read(&bars(0, &[255, 255])).unwrap().is_none());
        assert!(read(&bars(0, &[60, 250])).unwrap().is_none());
        assert!(read(&bars(0, &[])).unwrap().is_none());
        // A soft mask with slopes that begin at 1.
        let mut soft = bars(0, &[255]);
        for x in 0..SIZE.0 {
            for (y, level) in [(0, 9), (1, 120), (8, 120), (9, 9)] {
                soft[y * SIZE.0 + x] = level + (x % 3) as u8;
            }
        }
        assert!(read(&soft).unwrap().is_none());
    }

    #[test]
    fn ropes_that_are_black_on_white_are_turned() {
        for (ground, level) in [(255, 0), (1, 0), (200, 40)] {
            let (levels, notice) = read(&bars(ground, &[level])).unwrap().unwrap();
            let expected = if ground == 1 { 255 } else { ground - level };
            assert_eq!(levels, bars(0, &[expected]));
            assert!(notice.unwrap().contains("dark part"));
        }
    }

    #[test]
    fn a_mask_of_one_level_is_refused() {
        for level in [1, 128, 255] {
            let said = read(&bars(level, &[])).unwrap_err().to_string();
            assert!(
                said.contains(&format!("level {level} everywhere")),
                "{said}"
            );
        }
    }
}
