//! Dilation, erosion, opening and closing of a bit plane, 64 pixels at a time.
//!
//! The structuring element is an octagon: crosses and squares of 3×3, one after the other, in the order that
//! keeps its corners nearest to a circle (Adams, "Radial decomposition of discs and spheres", CVGIP 55, 1993).
//! A dilation sees nothing outside of the image and an erosion only rope, so that a rope that the image's border cuts
//! is not taken for thin.

use crate::bits::{BitPlane, left_of, right_of};

/// Squares among the steps of an octagon whose diagonals are as long as its axes: s of r steps with
/// s·√2 + (r − s)·√2/2 = r.
const SQUARES: f32 = std::f32::consts::SQRT_2 - 1.0;

/// Memory of the steps.
#[derive(Debug, Default)]
pub(crate) struct Morphology {
    before: BitPlane,
}

impl Morphology {
    /// Sets all that lies within `radius` of a set pixel.
    pub(crate) fn dilate(&mut self, plane: &mut BitPlane, radius: usize) {
        for step in 0..radius {
            self.before.copy_from(plane);
            each_row(&self.before, plane, is_square(step), grow);
        }
    }

    /// Clears all that lies within `radius` of an unset pixel.
    pub(crate) fn erode(&mut self, plane: &mut BitPlane, radius: usize) {
        for step in 0..radius {
            self.before.copy_from(plane);
            each_row(&self.before, plane, is_square(step), shrink);
        }
    }

    /// Leaves what a disc `across` pixels wide reaches without leaving the set pixels.
    pub(crate) fn open(&mut self, plane: &mut BitPlane, across: usize) {
        let radius = across.saturating_sub(1) / 2;
        let even = across > 0 && across.is_multiple_of(2);
        self.erode(plane, radius);
        if even {
            self.before.copy_from(plane);
            each_row(&self.before, plane, false, shrink_by_half);
            self.before.copy_from(plane);
            each_row(&self.before, plane, false, grow_by_half);
        }
        self.dilate(plane, radius);
    }

    /// Sets what a disc of this radius cannot reach without touching a set pixel.
    pub(crate) fn close(&mut self, plane: &mut BitPlane, radius: usize) {
        self.dilate(plane, radius);
        self.erode(plane, radius);
    }
}

/// Whether step `step` of an octagon is a square.
fn is_square(step: usize) -> bool {
    let squares = |steps: usize| (SQUARES * steps as f32).round();
    squares(step + 1) > squares(step)
}

/// Makes each word of `plane` what `step` says, given the rows of `before` above, here and below, the word's number and
/// those of its bits that lie in the image, and whether corners count.
fn each_row(
    before: &BitPlane,
    plane: &mut BitPlane,
    square: bool,
    step: impl Fn([Option<&[u64]>; 3], usize, u64, bool) -> u64,
) {
    let (height, words) = (before.height(), before.words_per_row());
    let last = before.last_word_mask();
    let row = |y: usize| (y < height).then(|| before.row(y));
    let is_empty = |y: usize| row(y).is_none_or(|row| row.iter().all(|&word| word == 0));
    let mut empty = [true, height == 0 || is_empty(0)];
    for y in 0..height {
        let below = is_empty(y + 1);
        let skip = empty[0] && empty[1] && below;
        empty = [empty[1], below];
        if skip {
            continue;
        }
        let above = y.checked_sub(1).and_then(row);
        let rows = [above, row(y), row(y + 1)];
        for i in 0..words {
            let inside = if i + 1 == words { last } else { u64::MAX };
            plane.row_mut(y)[i] = step(rows, i, inside, square) & inside;
        }
    }
}

/// Dilation: outside of the image nothing is set.
#[inline(always)]
fn grow([above, here, below]: [Option<&[u64]>; 3], i: usize, _: u64, square: bool) -> u64 {
    let wide = |row: &[u64]| row[i] | left_of(row, i) | right_of(row, i);
    let side = |row: Option<&[u64]>| row.map_or(0, |row| if square { wide(row) } else { row[i] });
    here.map_or(0, wide) | side(above) | side(below)
}

/// Erosion: outside of the image all is set.
#[inline(always)]
fn shrink([above, here, below]: [Option<&[u64]>; 3], i: usize, inside: u64, square: bool) -> u64 {
    let wide = |row: &[u64]| {
        let word = row[i] | !inside;
        let left = if i > 0 { row[i - 1] >> 63 } else { 1 };
        let right = row.get(i + 1).map_or(1 << 63, |next| next << 63);
        word & (word << 1 | left) & (word >> 1 | right)
    };
    let side =
        |row: Option<&[u64]>| row.map_or(u64::MAX, |row| if square { wide(row) } else { row[i] });
    here.map_or(u64::MAX, wide) & side(above) & side(below)
}

/// Dilation by a square of 2×2, half a pixel to the right and below.
#[inline(always)]
fn grow_by_half([above, here, _]: [Option<&[u64]>; 3], i: usize, _: u64, _: bool) -> u64 {
    let pair = |row: Option<&[u64]>| row.map_or(0, |row| row[i] | left_of(row, i));
    pair(above) | pair(here)
}

/// Erosion by that square turned around, so that one undoes the other's shift.
#[inline(always)]
fn shrink_by_half([_, here, below]: [Option<&[u64]>; 3], i: usize, inside: u64, _: bool) -> u64 {
    let pair = |row: Option<&[u64]>| {
        row.map_or(u64::MAX, |row| {
            let word = row[i] | !inside;
            word & (word >> 1 | row.get(i + 1).map_or(1 << 63, |next| next << 63))
        })
    };
    pair(here) & pair(below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition: one pixel at a time.
    fn scalar(plane: &BitPlane, radius: usize, dilate: bool) -> BitPlane {
        let mut plane = plane.clone();
        for step in 0..radius {
            let old = plane.clone();
            let (width, height) = (old.width() as i32, old.height() as i32);
            for y in 0..height {
                for x in 0..width {
                    let reaches = |dx: i32, dy: i32| is_square(step) || dx == 0 || dy == 0;
                    let mut around = (-1..=1)
                        .flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)))
                        .filter(|&(dx, dy)| reaches(dx, dy))
                        .filter(|&(dx, dy)| {
                            (0..width).contains(&(x + dx)) && (0..height).contains(&(y + dy))
                        });
                    let value = if dilate {
                        around.any(|(dx, dy)| old.get(x + dx, y + dy))
                    } else {
                        around.all(|(dx, dy)| old.get(x + dx, y + dy))
                    };
                    plane.fill(y as usize, x as usize, x as usize + 1, value);
                }
            }
        }
        plane
    }

    proptest! {
        #[test]
        fn words_at_a_time_equal_the_scalar_twin(
            width in 1usize..150, height in 1usize..16,
            words in proptest::collection::vec(any::<u64>(), 48),
            radius in 0usize..5, dense: bool,
        ) {
            let mut plane = BitPlane::default();
            plane.resize(width, height);
            for y in 0..height {
                for x in 0..width {
                    let bits = |k: usize| words[(3 * y + x / 64 + k) % 48] >> (x % 64) & 1 == 1;
                    // Half of the pixels are set, or 7 of 8, or 1 of 8.
                    let set = if dense {
                        bits(0) || bits(7) || bits(13)
                    } else {
                        bits(0) && bits(7) && bits(13)
                    };
                    plane.fill(y, x, x + 1, set);
                }
            }
            let mut morphology = Morphology::default();
            for dilate in [true, false] {
                let mut fast = plane.clone();
                if dilate {
                    morphology.dilate(&mut fast, radius);
                } else {
                    morphology.erode(&mut fast, radius);
                }
                prop_assert_eq!(&fast, &scalar(&plane, radius, dilate));
            }
        }
    }

    #[test]
    fn a_disc_is_as_wide_along_the_diagonals_as_along_the_axes() {
        for radius in 2..16 {
            let mut plane = BitPlane::default();
            plane.resize(64, 64);
            plane.fill(32, 32, 33, true);
            Morphology::default().dilate(&mut plane, radius);
            let along = |dx: i32, dy: i32| {
                (0..32)
                    .take_while(|k| plane.get(32 + k * dx, 32 + k * dy))
                    .count()
                    - 1
            };
            assert_eq!(along(1, 0), radius);
            // To a pixel, which is √2 long there.
            let pixel = std::f32::consts::SQRT_2;
            let diagonal = along(1, 1) as f32 * pixel;
            assert!(
                (diagonal - radius as f32).abs() < pixel,
                "{radius}: {diagonal}"
            );
        }
    }
}
