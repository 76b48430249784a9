//! Judges whether the automatic mask can be trusted, from the data that it was made of.
//!
//! The mask is trusted if a gap separates the table's levels from the rope's: the cut is then above
//! the floor that the table's noise sets. If the cut is at the floor, or nothing was found, the
//! reason is sought. It can be a table with a pattern (`pattern`), a rope too similar to the table
//! (`faint`), or no light at all.
//!
//! A mask with a wide gap may still not show ropes. This is recognized by its coverage and its
//! holes.

use super::background::Background;
use super::faint::Faint;
use super::pattern::{self, Deviation, Table};
use super::threshold::Cut;
use crate::bitmap::components::Components;
use crate::bitmap::strips::{BLOCK, Strips};
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};
use crate::notice::Notice;
use crate::scene::MOST_CROSSINGS;

/// Samples of the difference along each side of the grid.
const GRID: usize = 64;
/// Maximum share of the image that ropes cover. A rope that covers more and is as wide as a
/// twentieth of the image's side would be six times as long as the side. A checkered table covers
/// half.
const MOST_COVERED: f32 = 0.3;
/// Mean number of changes between rope and table per row above which the image is covered by a
/// pattern. With fewer, it is covered by one large object.
const CHANGES: f32 = 4.0;
/// Minimum number of pixels just below the cut (from 0.6 of it), as a share of those above, if no
/// gap separates rope and table. If noise sets the cut, a clear rope's blurred edges have up to a
/// tenth.
const FRINGE: f32 = 0.2;
/// A pixel is black up to the first level and white from the second. These are the ends of the
/// camera's range, with some noise.
const BLACK: u8 = 6;
const WHITE: u8 = 249;
/// The share of pixels at an end of the range that makes the image black or white.
const WHOLE: f32 = 0.99;

/// The data that an image's mask was made of.
pub(crate) struct Evidence<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) background: &'a Background,
    pub(crate) difference: &'a GrayPlane,
    /// Minimum cut that the table's noise allows, in levels of difference.
    pub(crate) floor: f32,
    /// The cut that was used, and its coverage.
    pub(crate) cut: Cut,
    /// The resulting mask, cleaned.
    pub(crate) mask: &'a Strips,
}

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Diagnosis {
    faint: Faint,
}

/// Number of a mask's holes minus the number of its pieces.
pub(crate) fn holes_beyond_pieces(mask: &Strips) -> i64 {
    -lariat_portable::Arch::new().dispatch(PiecesLessHoles(mask))
}

/// Returns whether the cut covers more than ropes do, whatever the mask becomes.
pub(crate) fn covers_much(cut: Cut) -> bool {
    cut.covered > MOST_COVERED
}

impl Diagnosis {
    /// The notice about the mask; `None` if the mask is trusted.
    pub(crate) fn notice(&mut self, of: &Evidence, components: &mut Components) -> Option<Notice> {
        let cut = of.cut.rope;
        if covers_much(of.cut) {
            let seen = GridStatistics::of(of.difference, cut);
            return Some(match seen.changes > CHANGES {
                true => Notice::CheckeredTable,
                false => Notice::Covered,
            });
        }
        let is_empty = of.mask.used.is_empty();
        // A rope that crosses itself n times encloses n + 1 holes.
        if !is_empty && holes_beyond_pieces(of.mask) > MOST_CROSSINGS as i64 {
            return Some(Notice::CheckeredTable);
        }
        let is_at_floor = !of.cut.is_sure(of.floor);
        if !is_empty && !is_at_floor {
            return None;
        }
        let table = Table {
            image: of.image,
            background: of.background,
            difference: of.difference,
            cut,
        };
        match pattern::deviation(&table) {
            Deviation::Pattern => return Some(Notice::CheckeredTable),
            Deviation::Uneven => return Some(Notice::UnevenTable),
            Deviation::Noise => {}
        }
        if !is_empty {
            let seen = GridStatistics::of(of.difference, cut);
            return (seen.fringe > FRINGE).then_some(Notice::LikeTheTable);
        }
        if self.faint.is_there(of.difference, components) {
            return Some(Notice::LikeTheTable);
        }
        clipped(of.image)
    }
}

/// Statistics of the difference on a grid.
struct GridStatistics {
    /// Mean number of times that a row passes the cut.
    changes: f32,
    /// Number of samples just below the cut, as a share of those above.
    fringe: f32,
}

impl GridStatistics {
    fn of(difference: &GrayPlane, cut: u8) -> Self {
        let (width, height) = (difference.width(), difference.height());
        let (columns, rows) = (GRID.min(width), GRID.min(height));
        let near = (0.6 * f32::from(cut)) as u8;
        let (mut above, mut below, mut changes) = (0u32, 0u32, 0u32);
        for j in 0..rows {
            let row = difference.row((2 * j + 1) * height / (2 * rows));
            let mut was_above = false;
            for i in 0..columns {
                let level = row[(2 * i + 1) * width / (2 * columns)];
                let is_above = level >= cut;
                above += u32::from(is_above);
                below += u32::from(!is_above && level >= near);
                changes += u32::from(is_above != was_above && i > 0);
                was_above = is_above;
            }
        }
        Self {
            changes: changes as f32 / rows as f32,
            fringe: below as f32 / above.max(1) as f32,
        }
    }
}

/// Euler number of a mask: its pieces (of pixels that touch by side or corner) minus the holes in
/// them.
///
/// With pixels as closed squares, it equals vertices − edges + faces. Along a row, all but the ends
/// of runs cancel. The result is the number of runs in the unions of neighboring rows, minus the
/// number of runs in the rows.
struct PiecesLessHoles<'a>(&'a Strips);

impl lariat_portable::NullaryFnOnce for PiecesLessHoles<'_> {
    type Output = i64;

    #[inline(always)]
    fn call(self) -> i64 {
        let Strips {
            shape, words, used, ..
        } = self.0;
        let mut number = 0;
        for (from, count) in used.runs(shape) {
            let (strip, y) = shape.place(from);
            // Include the first row below a run of blocks, unless another block follows there.
            let below = usize::from(!used.holds(shape, strip, (y + count) / BLOCK));
            for at in from..from + count + below {
                let left = at - shape.stride;
                let (union, left_union) =
                    (words[at] | words[at - 1], words[left] | words[left - 1]);
                number += i64::from(starts(union, left_union));
                number -= i64::from(starts(words[at], words[left]));
            }
        }
        number
    }
}

/// Number of runs of set bits that begin in `word`, which follows `before`.
#[inline(always)]
fn starts(word: u64, before: u64) -> u32 {
    (word & !(word << 1 | before >> 63)).count_ones()
}

/// Returns a notice if nearly all of the image is at one end of the camera's range.
fn clipped(image: &Image) -> Option<Notice> {
    let (width, height) = (image.width(), image.height());
    let (columns, rows) = (GRID.min(width), GRID.min(height));
    let (mut black, mut white) = (0u32, 0u32);
    for j in 0..rows {
        for i in 0..columns {
            let x = (2 * i + 1) * width / (2 * columns);
            let y = (2 * j + 1) * height / (2 * rows);
            let [r, g, b] = color::rgb(image, x, y);
            black += u32::from(r.max(g).max(b) <= BLACK);
            white += u32::from(r.min(g).min(b) >= WHITE);
        }
    }
    let whole = WHOLE * (columns * rows) as f32;
    if black as f32 >= whole {
        Some(Notice::Black)
    } else if white as f32 >= whole {
        Some(Notice::White)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bitmap::bits::BitPlane;
    use imageproc::region_labelling::{Connectivity, connected_components};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pieces_less_holes_agree_with_an_independent_labeling(
            width in 1usize..140, height in 1usize..16,
            bits in proptest::collection::vec(any::<u64>(), 64), sparse in any::<bool>(),
        ) {
            let word = |i: usize| if sparse { bits[i % 64] & bits[(i + 7) % 64] } else { bits[i % 64] };
            let set = |x: usize, y: usize| word(y * 3 + x / 64) >> (x % 64) & 1 == 1;
            let mut plane = BitPlane::default();
            plane.resize(width, height);
            // A frame of unset pixels, so that the outside is one more hole.
            let mut picture = image::GrayImage::new(width as u32 + 2, height as u32 + 2);
            for y in 0..height {
                for x in (0..width).filter(|&x| set(x, y)) {
                    plane.fill(y, x, x + 1, true);
                    picture.put_pixel(x as u32 + 1, y as u32 + 1, image::Luma([255]));
                }
            }
            let count = |picture: &image::GrayImage, by| {
                let labels = connected_components(picture, by, image::Luma([0]));
                i64::from(labels.pixels().map(|label| label[0]).max().unwrap_or(0))
            };
            let pieces = count(&picture, Connectivity::Eight);
            image::imageops::invert(&mut picture);
            let holes = count(&picture, Connectivity::Four) - 1;
            let mut strips = Strips::default();
            strips.take(&plane);
            let number = lariat_portable::Arch::new().dispatch(PiecesLessHoles(&strips));
            prop_assert_eq!(number, pieces - holes);
        }
    }
}
