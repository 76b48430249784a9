//! The skeleton: the mask thinned to lines one pixel wide, 64 pixels at a time.
//!
//! Guo and Hall, "Parallel thinning with two-subiteration algorithms", CACM 32 (1989), algorithm A1:
//! it keeps connections, leaves diagonal lines whole (Zhang-Suen can eat them) and comes close to
//! the medial axis. Each condition is a sum of neighbors, written here as logic on whole words; the
//! scalar twin in the tests is the definition, equal bit for bit.
//!
//! Work: a row is visited only while it or a neighbor still changes, and at most `max_passes` passes
//! are made, so that a mask of all ones costs no more than the widest rope that is looked for.

use crate::bits::{BitPlane, left_of, right_of};

/// Memory of the thinning, kept from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Thinner {
    /// The row above and the row itself as they were before the pass reached them.
    above: Vec<u64>,
    current: Vec<u64>,
    empty: Vec<u64>,
    /// For each row the number of the last sub-iteration that changed it.
    changed: Vec<u32>,
}

impl Thinner {
    /// Thins `plane` in place. Returns whether it came to rest within `max_passes`.
    pub(crate) fn thin(&mut self, plane: &mut BitPlane, max_passes: u32) -> bool {
        let words = plane.words_per_row();
        for buffer in [&mut self.above, &mut self.current, &mut self.empty] {
            buffer.clear();
            buffer.resize(words, 0);
        }
        self.changed.clear();
        self.changed.resize(plane.height(), 2);
        for pass in 0..max_passes {
            // Sub-iterations count from 3 so that "changed at 2" means "never looked at yet".
            let first = self.sub_iteration(plane, 3 + 2 * pass, false);
            let second = self.sub_iteration(plane, 4 + 2 * pass, true);
            if !first && !second {
                return true;
            }
        }
        false
    }

    /// One parallel sub-iteration over all rows that can still change.
    fn sub_iteration(&mut self, plane: &mut BitPlane, now: u32, south_east: bool) -> bool {
        let height = plane.height();
        let mut any = false;
        // Whether `above` holds the row above as it was: only then is it not read from the plane.
        let mut above_saved = false;
        for y in 0..height {
            let recent = |row: usize| self.changed[row] + 2 >= now;
            let active = recent(y) || y > 0 && recent(y - 1) || y + 1 < height && recent(y + 1);
            if !active || plane.row(y).iter().all(|&w| w == 0) {
                above_saved = false;
                continue;
            }
            self.current.copy_from_slice(plane.row(y));
            if !above_saved && y > 0 {
                self.above.copy_from_slice(plane.row(y - 1));
            } else if y == 0 {
                self.above.fill(0);
            }
            let mut changed = false;
            for i in 0..self.current.len() {
                if self.current[i] == 0 {
                    continue;
                }
                let below = if y + 1 < height {
                    plane.row(y + 1)
                } else {
                    &self.empty
                };
                let delete = deletable(&self.above, &self.current, below, i, south_east);
                if delete != 0 {
                    plane.row_mut(y)[i] &= !delete;
                    changed = true;
                }
            }
            if changed {
                self.changed[y] = now;
                any = true;
            }
            std::mem::swap(&mut self.above, &mut self.current);
            above_saved = true;
        }
        any
    }
}

/// The pixels of word `i` that one sub-iteration of Guo and Hall takes away.
#[inline(always)]
fn deletable(above: &[u64], row: &[u64], below: &[u64], i: usize, south_east: bool) -> u64 {
    let (n, s) = (above[i], below[i]);
    let (nw, ne) = (left_of(above, i), right_of(above, i));
    let (w, e) = (left_of(row, i), right_of(row, i));
    let (sw, se) = (left_of(below, i), right_of(below, i));

    // C, the number of 8-connected pieces around the pixel, is exactly one.
    let (c1, c2) = (!n & (ne | e), !e & (se | s));
    let (c3, c4) = (!s & (sw | w), !w & (nw | n));
    let one_piece = (c1 ^ c2 ^ c3 ^ c4) & !(c1 & c2 | c3 & c4);

    // 2 ≤ min(N1, N2) ≤ 3, with N1 and N2 the two ways to pair the eight neighbors.
    let pairs1 = [nw | n, ne | e, se | s, sw | w];
    let pairs2 = [n | ne, e | se, s | sw, w | nw];
    let neighbors = at_least_two(pairs1) & at_least_two(pairs2) & !(all(pairs1) & all(pairs2));

    let side = if south_east {
        (n | ne | !se) & e
    } else {
        (s | sw | !nw) & w
    };
    row[i] & one_piece & neighbors & !side
}

#[inline(always)]
fn at_least_two([a, b, c, d]: [u64; 4]) -> u64 {
    a & b | c & d | (a | b) & (c | d)
}

#[inline(always)]
fn all([a, b, c, d]: [u64; 4]) -> u64 {
    a & b & c & d
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition: one pixel at a time, as in the paper.
    fn thin_scalar(plane: &mut BitPlane, max_passes: u32) {
        for _ in 0..max_passes {
            let before = plane.clone();
            for south_east in [false, true] {
                let old = plane.clone();
                for y in 0..old.height() as i32 {
                    for x in 0..old.width() as i32 {
                        if old.get(x, y) && deletable_scalar(&old, x, y, south_east) {
                            plane.fill(y as usize, x as usize, x as usize + 1, false);
                        }
                    }
                }
            }
            if *plane == before {
                return;
            }
        }
    }

    fn deletable_scalar(plane: &BitPlane, x: i32, y: i32, south_east: bool) -> bool {
        let at = |dx, dy| plane.get(x + dx, y + dy);
        let (p2, p3, p4, p5) = (at(0, -1), at(1, -1), at(1, 0), at(1, 1));
        let (p6, p7, p8, p9) = (at(0, 1), at(-1, 1), at(-1, 0), at(-1, -1));
        let sum = |terms: [bool; 4]| terms.iter().filter(|&&t| t).count();
        let c = sum([
            !p2 && (p3 || p4),
            !p4 && (p5 || p6),
            !p6 && (p7 || p8),
            !p8 && (p9 || p2),
        ]);
        let n1 = sum([p9 || p2, p3 || p4, p5 || p6, p7 || p8]);
        let n2 = sum([p2 || p3, p4 || p5, p6 || p7, p8 || p9]);
        let m = if south_east {
            (p2 || p3 || !p5) && p4
        } else {
            (p6 || p7 || !p9) && p8
        };
        c == 1 && (2..=3).contains(&n1.min(n2)) && !m
    }

    fn plane(width: usize, height: usize, set: impl Fn(usize, usize) -> bool) -> BitPlane {
        let mut plane = BitPlane::default();
        plane.resize(width, height);
        for y in 0..height {
            for x in 0..width {
                if set(x, y) {
                    plane.fill(y, x, x + 1, true);
                }
            }
        }
        plane
    }

    fn both_agree(mask: &BitPlane) -> Result<(), TestCaseError> {
        let (mut fast, mut slow) = (mask.clone(), mask.clone());
        Thinner::default().thin(&mut fast, 100);
        thin_scalar(&mut slow, 100);
        prop_assert_eq!(fast, slow);
        Ok(())
    }

    proptest! {
        #[test]
        fn bit_parallel_thinning_equals_its_scalar_twin(
            width in 1usize..150,
            height in 1usize..24,
            words in proptest::collection::vec(any::<u64>(), 72),
            density in 0u32..3,
        ) {
            let random = plane(width, height, |x, y| {
                let word = words[(y * 3 + x / 64) % 72];
                let other = words[(y * 5 + x / 64 + 1) % 72];
                let bits = match density { 0 => word & other, 1 => word, _ => word | other };
                bits >> (x % 64) & 1 == 1
            });
            both_agree(&random)?;
        }

        #[test]
        fn thick_strokes_thin_alike(
            width in 20usize..140, slope in -3.0f32..3.0, half in 1.0f32..9.0,
        ) {
            let stroke = plane(width, 40, |x, y| {
                let offset = y as f32 - 20.0 - slope * (x as f32 - width as f32 / 2.0);
                offset.abs() < half * (1.0 + slope * slope).sqrt()
            });
            both_agree(&stroke)?;
        }
    }

    #[test]
    fn all_ones_thin_alike() {
        let (mut fast, mut slow) = (plane(130, 70, |_, _| true), plane(130, 70, |_, _| true));
        assert!(Thinner::default().thin(&mut fast, 100));
        thin_scalar(&mut slow, 100);
        assert_eq!(fast, slow);
        assert!(fast.count() > 0);
    }

    #[test]
    fn a_mask_wider_than_the_passes_allow_says_so() {
        let mut wide = plane(200, 200, |_, _| true);
        assert!(!Thinner::default().thin(&mut wide, 5));
    }
}
