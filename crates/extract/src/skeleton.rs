//! The skeleton as a list: each pixel's position, neighbors and distance to the rope's edge.

use crate::bits::BitPlane;
use crate::clearance::Clearance;
use crate::strips::{BLOCK, Strips};

/// No pixel, node, edge or arm.
pub(crate) const NONE: u32 = u32::MAX;
/// Skeleton pixels beyond which an image is taken for noise: more than eight ropes that each cross
/// the longest image a few times.
const BUDGET: usize = 1 << 17;
/// Half-widths are measured up to this, in pixels.
const WIDEST_HALF: i32 = 160;

/// The pixels of a skeleton in the order of rows.
#[derive(Debug, Default)]
pub(crate) struct Skeleton {
    /// Index of the first pixel of each word in a block that has any.
    first: Vec<u32>,
    /// Strips that have any in the rows that are listed.
    filled: Vec<u32>,
    clearance: Clearance,
    pub(crate) pixels: Vec<Pixel>,
}

/// One pixel of the skeleton.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) x: u16,
    pub(crate) y: u16,
    /// Distance from the pixel's center to the rope's edge, in pixels.
    pub(crate) half_px: f32,
    /// The first `degree` are meant. They are no more than four: a corner neighbor counts only where neither side neighbor
    /// beside it is.
    pub(crate) neighbors: [u32; 5],
    pub(crate) degree: u8,
}

impl Pixel {
    pub(crate) fn at(&self) -> [f32; 2] {
        [f32::from(self.x), f32::from(self.y)]
    }
}

impl Skeleton {
    /// Lists the pixels of `thin`, the skeleton of `mask`, which stands in `rows`, too. An image that is noise gets none.
    pub(crate) fn list(&mut self, thin: &Strips, mask: &Strips, rows: &BitPlane) {
        self.clearance.take(mask);
        pulp::Arch::new().dispatch(List {
            skeleton: self,
            thin,
            mask: rows,
        });
    }

    /// Lists the pixels with their half-widths; none if there are too many.
    #[inline(always)]
    fn list_places(&mut self, thin: &Strips, mask: &BitPlane) {
        let shape = &thin.shape;
        self.pixels.clear();
        self.first.resize(shape.words(), 0);
        for top in (0..shape.height()).step_by(BLOCK) {
            self.filled.clear();
            for strip in 0..shape.strips() {
                if thin.used.holds(shape, strip, top / BLOCK) {
                    self.filled.push(strip as u32);
                }
            }
            if self.filled.is_empty() {
                continue;
            }
            for y in top..(top + BLOCK).min(shape.height()) {
                for &strip in &self.filled {
                    let at = shape.index(strip as usize, y);
                    let mut word = thin.words[at];
                    self.first[at] = self.pixels.len() as u32;
                    while word != 0 {
                        let (x, y) = ((64 * strip + word.trailing_zeros()) as u16, y as u16);
                        self.pixels.push(Pixel {
                            x,
                            y,
                            half_px: self.clearance.half_px(mask, x, y),
                            neighbors: [NONE; 5],
                            degree: 0,
                        });
                        word &= word - 1;
                    }
                }
                if self.pixels.len() > BUDGET {
                    self.pixels.clear();
                    return;
                }
            }
        }
    }

    /// Finds the neighbors of pixel `i`. A corner neighbor that is also reached through a side
    /// neighbor is left out, so that a staircase is a path and not a row of junctions.
    #[inline(always)]
    fn connect(&mut self, thin: &Strips, i: usize) {
        let (pixel, words) = (&mut self.pixels[i], &thin.words[..]);
        let (stride, bit) = (thin.shape.stride, pixel.x % 64);
        let strip = usize::from(pixel.x / 64);
        let at = thin.shape.index(strip, usize::from(pixel.y));
        let [above, below] = [at - 1, at + 1].map(|at| three(words, at, stride, bit));
        let ([nw, n, ne], [sw, s, se]) = (above, below);
        let [w, _, e] = three(words, at, stride, bit);
        let above = first_from(&self.first, words, at - 1, stride, bit, nw);
        let below = first_from(&self.first, words, at + 1, stride, bit, sw);
        let here = i as u32;
        let kinds = [
            (e, here + 1),
            (s, below),
            (w, here.wrapping_sub(1)),
            (n, above),
            (se & !e & !s, below),
            (sw & !w & !s, below.wrapping_sub(1)),
            (nw & !w & !n, above.wrapping_sub(1)),
            (ne & !e & !n, above),
        ];
        // Written always, kept where it is one: chance decides, and no branch guesses that.
        let mut degree = 0;
        for (is_there, index) in kinds {
            pixel.neighbors[degree] = index;
            degree += usize::from(is_there);
        }
        pixel.degree = degree as u8;
    }

    /// Takes pixel `i` out: no neighbor leads to it any more.
    pub(crate) fn remove(&mut self, i: u32) {
        let Pixel {
            neighbors, degree, ..
        } = self.pixels[i as usize];
        for &other in &neighbors[..usize::from(degree)] {
            let other = &mut self.pixels[other as usize];
            let degree = usize::from(other.degree);
            if let Some(k) = other.neighbors[..degree].iter().position(|&n| n == i) {
                other.neighbors.swap(k, degree - 1);
                other.degree -= 1;
            }
        }
        self.pixels[i as usize].degree = 0;
    }
}

/// Whether the pixels to the left of a bit, of it and to its right are set in the row of a word.
#[inline(always)]
fn three(words: &[u64], at: usize, stride: usize, bit: u16) -> [bool; 3] {
    let left = words[at] << 1 | words[at - stride] >> 63;
    let right = words[at] >> 1 | words[at + stride] << 63;
    [left, words[at], right].map(|word| word >> bit & 1 == 1)
}

/// The index of the first pixel of a row that is not to the left of a bit, if it or its neighbors in the row are set: the
/// pixels of a row follow each other.
#[inline(always)]
fn first_from(
    first: &[u32],
    words: &[u64],
    at: usize,
    stride: usize,
    bit: u16,
    is_left: bool,
) -> u32 {
    match (words[at], is_left) {
        // Nothing in this word: the one to the left is the last of its own, one to the right the first.
        (0, true) => first[at - stride] + words[at - stride].count_ones(),
        (0, false) => first[at + stride],
        (word, _) => first[at] + (word & ((1 << bit) - 1)).count_ones(),
    }
}

/// The listing, to be compiled for each kind of machine: counting bits is one instruction on most.
struct List<'a> {
    skeleton: &'a mut Skeleton,
    thin: &'a Strips,
    mask: &'a BitPlane,
}

impl pulp::NullaryFnOnce for List<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let skeleton = self.skeleton;
        skeleton.list_places(self.thin, self.mask);
        for i in 0..skeleton.pixels.len() {
            skeleton.connect(self.thin, i);
        }
    }
}

/// Distance from the center of pixel (x, y) to the nearest side of an unset pixel's center, less the
/// half pixel that the edge lies before it. What is outside the image does not count as unset: a
/// rope that leaves the image is cut, not narrow.
pub(crate) fn half_width(mask: &BitPlane, x: i32, y: i32) -> f32 {
    let mut best = WIDEST_HALF * WIDEST_HALF;
    let mut dy = 0;
    while dy * dy < best {
        for row in [y - dy, y + dy] {
            if row >= 0 && (row as usize) < mask.height() {
                let dx = nearest_unset(mask.row(row as usize), mask.width(), x);
                best = best.min(dx.saturating_mul(dx).saturating_add(dy * dy));
            }
        }
        dy += 1;
    }
    (best as f32).sqrt() - 0.5
}

/// Distance along the row from `x` to the nearest unset pixel, or far when there is none.
fn nearest_unset(row: &[u64], width: usize, x: i32) -> i32 {
    const FAR: i32 = 1 << 12;
    let (start, bit) = (x as usize / 64, x as usize % 64);
    let mut right = FAR;
    for (i, &word) in row.iter().enumerate().skip(start) {
        let from = if i == start {
            u64::MAX << bit
        } else {
            u64::MAX
        };
        let unset = !word & from;
        if unset != 0 {
            let at = 64 * i + unset.trailing_zeros() as usize;
            if at < width {
                right = at as i32 - x;
            }
            break;
        }
        if i - start > WIDEST_HALF as usize / 64 {
            break;
        }
    }
    let mut left = FAR;
    for i in (0..=start).rev() {
        let to = if i == start {
            u64::MAX >> (63 - bit)
        } else {
            u64::MAX
        };
        let unset = !row[i] & to;
        if unset != 0 {
            left = x - (64 * i + 63 - unset.leading_zeros() as usize) as i32;
            break;
        }
        if start - i > WIDEST_HALF as usize / 64 {
            break;
        }
    }
    left.min(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_bar_is_half_its_width_from_the_edge() {
        let mut mask = BitPlane::default();
        mask.resize(200, 40);
        (10..21).for_each(|y| mask.fill(y, 0, 200, true));
        assert_eq!(half_width(&mask, 100, 15), 5.5);
        assert_eq!(
            half_width(&mask, 0, 15),
            5.5,
            "the image's edge is not the rope's"
        );
        assert_eq!(half_width(&mask, 63, 12), 2.5);
    }
}
