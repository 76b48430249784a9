//! A picture of one bit per pixel, 64 pixels to a word: the form of masks and skeletons.

use std::ops::Range;

use crate::vec2::Vec2;

/// One bit per pixel. Bit `x % 64` of word `x / 64` of row `y` is pixel (x, y). Bits past the width
/// are always 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct BitPlane {
    words: Vec<u64>,
    words_per_row: usize,
    width: usize,
    height: usize,
}

impl BitPlane {
    /// Sets the size and clears all pixels. Reuses the memory.
    pub(crate) fn resize(&mut self, width: usize, height: usize) {
        self.width = width;
        self.height = height;
        self.words_per_row = width.div_ceil(64);
        self.words.clear();
        self.words.resize(self.words_per_row * height, 0);
    }

    /// Sets the size and reuses the memory. Pixels keep whatever values they had, and the caller
    /// must write 0 past the width.
    pub(crate) fn reshape(&mut self, width: usize, height: usize) {
        self.width = width;
        self.height = height;
        self.words_per_row = width.div_ceil(64);
        self.words.resize(self.words_per_row * height, 0);
    }

    /// Copies the size and pixels of `other`.
    pub(crate) fn copy_from(&mut self, other: &BitPlane) {
        self.width = other.width;
        self.height = other.height;
        self.words_per_row = other.words_per_row;
        self.words.clear();
        self.words.extend_from_slice(&other.words);
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn height(&self) -> usize {
        self.height
    }

    pub(crate) fn words_per_row(&self) -> usize {
        self.words_per_row
    }

    pub(crate) fn words(&self) -> &[u64] {
        &self.words
    }

    pub(crate) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    pub(crate) fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_per_row..][..self.words_per_row]
    }

    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [u64] {
        &mut self.words[y * self.words_per_row..][..self.words_per_row]
    }

    /// Some rows, one after the other.
    pub(crate) fn rows_mut(&mut self, rows: Range<usize>) -> &mut [u64] {
        let words = self.words_per_row;
        &mut self.words[words * rows.start..words * rows.end]
    }

    /// Returns whether pixel (x, y) is set. Pixels outside the picture are not.
    pub(crate) fn get(&self, x: i32, y: i32) -> bool {
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            return false;
        }
        let (x, y) = (x as usize, y as usize);
        self.words[y * self.words_per_row + x / 64] >> (x % 64) & 1 == 1
    }

    /// Returns whether the pixel nearest to a position is set.
    pub(crate) fn has(&self, [x, y]: Vec2) -> bool {
        self.get((x + 0.5) as i32, (y + 0.5) as i32)
    }

    /// Pixels `x..x + 64` of row `y`, the first in the lowest bit. Pixels outside the picture are
    /// 0.
    pub(crate) fn bits_from(&self, x: i32, y: i32) -> u64 {
        if y < 0 || y as usize >= self.height {
            return 0;
        }
        let row = self.row(y as usize);
        let word = |i: i32| row.get(i as usize).copied().unwrap_or(0);
        let (i, bit) = (x.div_euclid(64), x.rem_euclid(64) as u32);
        // Two shifts, because a shift by 64 is not allowed.
        word(i) >> bit | word(i + 1) << 1 << (63 - bit)
    }

    /// Calls `visit` with each set pixel of row `y`.
    pub(crate) fn for_each_set(&self, y: usize, mut visit: impl FnMut(usize)) {
        for (i, &row_word) in self.row(y).iter().enumerate() {
            let mut word = row_word;
            while word != 0 {
                visit(64 * i + word.trailing_zeros() as usize);
                word &= word - 1;
            }
        }
    }

    /// Sets pixels `from..to` of row `y` to `value`.
    pub(crate) fn fill(&mut self, y: usize, from: usize, to: usize, value: bool) {
        let row = self.row_mut(y);
        let mut x = from;
        while x < to {
            let end = to.min((x / 64 + 1) * 64);
            let bits = (u64::MAX >> (64 - (end - x))) << (x % 64);
            if value {
                row[x / 64] |= bits;
            } else {
                row[x / 64] &= !bits;
            }
            x = end;
        }
    }

    /// Columns and rows that contain all set pixels; `None` if no pixel is set.
    pub(crate) fn bounds(&self) -> Option<[Range<usize>; 2]> {
        let is_set = |y: &usize| self.row(*y).iter().any(|&word| word != 0);
        let top = (0..self.height).find(is_set)?;
        let end = (top..self.height).rfind(is_set)? + 1;
        let any = |word: usize| (top..end).fold(0, |any, y| any | self.row(y)[word]);
        let first = (0..self.words_per_row).find(|&word| any(word) != 0)?;
        let last = (first..self.words_per_row).rfind(|&word| any(word) != 0)?;
        let left = 64 * first + any(first).trailing_zeros() as usize;
        let right = 64 * (last + 1) - any(last).leading_zeros() as usize;
        Some([left..right, top..end])
    }

    /// Number of set pixels.
    pub(crate) fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }
}

/// For each pixel in word `i` of `row`, its left neighbor.
#[inline(always)]
pub(crate) fn left_of(row: &[u64], i: usize) -> u64 {
    let carry = if i > 0 { row[i - 1] >> 63 } else { 0 };
    row[i] << 1 | carry
}

/// For each pixel in word `i` of `row`, its right neighbor.
#[inline(always)]
pub(crate) fn right_of(row: &[u64], i: usize) -> u64 {
    let carry = if i + 1 < row.len() {
        row[i + 1] << 63
    } else {
        0
    };
    row[i] >> 1 | carry
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_is_set_lies_within_the_bounds() {
        let mut plane = BitPlane::default();
        plane.resize(200, 9);
        assert_eq!(plane.bounds(), None);
        plane.fill(4, 70, 71, true);
        assert_eq!(plane.bounds(), Some([70..71, 4..5]));
        plane.fill(2, 63, 64, true);
        plane.fill(7, 130, 200, true);
        assert_eq!(plane.bounds(), Some([63..200, 2..8]));
    }

    #[test]
    fn a_run_of_pixels_is_what_each_of_them_is() {
        let mut plane = BitPlane::default();
        plane.resize(150, 2);
        (0..150)
            .filter(|x| x % 3 == 0 || x % 7 == 0)
            .for_each(|x| plane.fill(1, x, x + 1, true));
        for x in -70..220 {
            let each = (0..64).fold(0, |bits, i| bits | u64::from(plane.get(x + i, 1)) << i);
            assert_eq!(plane.bits_from(x, 1), each, "from {x} on");
            assert_eq!([plane.bits_from(x, -1), plane.bits_from(x, 2)], [0; 2]);
        }
    }
}
