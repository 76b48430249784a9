//! The skeleton as a list: each pixel's position, neighbors and distance to the rope's edge.

use crate::bits::BitPlane;

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
    /// Index of the first pixel of each word that has any.
    first: Vec<u32>,
    pub(crate) pixels: Vec<Pixel>,
}

/// One pixel of the skeleton.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) x: u16,
    pub(crate) y: u16,
    /// Distance from the pixel's center to the rope's edge, in pixels.
    pub(crate) half_px: f32,
    pub(crate) neighbors: [u32; 8],
    pub(crate) degree: u8,
}

impl Pixel {
    pub(crate) fn at(&self) -> [f32; 2] {
        [f32::from(self.x), f32::from(self.y)]
    }
}

impl Skeleton {
    /// Lists the pixels of `thin`, the skeleton of `mask`. An image that is noise gets none.
    pub(crate) fn list(&mut self, thin: &BitPlane, mask: &BitPlane) {
        self.pixels.clear();
        self.first.resize(thin.words().len(), 0);
        for y in 0..thin.height() {
            for (i, &row_word) in thin.row(y).iter().enumerate() {
                self.first[y * thin.words_per_row() + i] = self.pixels.len() as u32;
                let mut word = row_word;
                while word != 0 {
                    let x = 64 * i + word.trailing_zeros() as usize;
                    self.pixels.push(Pixel {
                        x: x as u16,
                        y: y as u16,
                        half_px: 0.0,
                        neighbors: [NONE; 8],
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
        for i in 0..self.pixels.len() {
            let (x, y) = (i32::from(self.pixels[i].x), i32::from(self.pixels[i].y));
            self.pixels[i].half_px = half_width(mask, x, y);
            self.connect(thin, i, x, y);
        }
    }

    /// Finds the neighbors of pixel `i`. A corner neighbor that is also reached through a side
    /// neighbor is left out, so that a staircase is a path and not a row of junctions.
    fn connect(&mut self, thin: &BitPlane, i: usize, x: i32, y: i32) {
        for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
            if thin.get(x + dx, y + dy) {
                self.link(thin, i, x + dx, y + dy);
            }
        }
        for (dx, dy) in [(1, 1), (-1, 1), (-1, -1), (1, -1)] {
            let around = thin.get(x + dx, y) || thin.get(x, y + dy);
            if thin.get(x + dx, y + dy) && !around {
                self.link(thin, i, x + dx, y + dy);
            }
        }
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

    fn link(&mut self, thin: &BitPlane, i: usize, x: i32, y: i32) {
        let (x, y) = (x as usize, y as usize);
        let word = y * thin.words_per_row() + x / 64;
        let before = thin.words()[word] & ((1u64 << (x % 64)) - 1);
        let index = self.first[word] + before.count_ones();
        let pixel = &mut self.pixels[i];
        pixel.neighbors[usize::from(pixel.degree)] = index;
        pixel.degree += 1;
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
