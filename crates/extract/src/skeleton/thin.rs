//! The skeleton: the mask thinned to lines one pixel wide, 64 pixels at a time.
//!
//! Guo and Hall, "Parallel thinning with two-subiteration algorithms", CACM 32 (1989), algorithm
//! A1: it keeps connections, leaves diagonal lines whole (Zhang-Suen can erode them) and comes
//! close to the medial axis. Each condition is a sum of neighbors, written here as logic on whole
//! words. The scalar twin in the tests is the definition, equal bit for bit.
//!
//! Cost: only blocks that hold rope are visited, while they or their neighbors still change. At
//! most `max_passes` passes are made, so a mask of all ones costs no more than the widest rope that
//! is sought.

use crate::bitmap::neighbors::{Around, Rule, apply_to_block};
use crate::bitmap::strips::{BLOCK, Blocks, Strips, block, block_mut};

/// Memory of the thinning, kept from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Thinner {
    /// The skeleton after the last sub-iteration, and the output of the next one. They are equal
    /// outside the blocks that it visits.
    pub(crate) thin: Strips,
    next: Strips,
    /// Blocks that the last sub-iteration changed, and those that the one before it changed.
    changed: [Blocks; 2],
    active: Blocks,
}

impl Thinner {
    /// Thins `mask`. Returns whether nothing changed any more within `max_passes`.
    pub(crate) fn thin(&mut self, mask: &Strips, max_passes: u32) -> bool {
        self.begin(mask);
        let arch = lariat_portable::Arch::new();
        for _ in 0..max_passes {
            arch.dispatch(SubIteration::<false>(self));
            arch.dispatch(SubIteration::<true>(self));
            if self.changed.iter().all(Blocks::is_empty) {
                return true;
            }
        }
        false
    }

    /// Copies the mask and marks all of it for processing.
    fn begin(&mut self, mask: &Strips) {
        self.thin.copy_from(mask);
        self.next.resize(&mask.shape);
        self.next.used.copy_from(&mask.used);
        for changed in &mut self.changed {
            changed.copy_from(&mask.used);
        }
        self.active.resize(&mask.shape);
    }

    /// Runs one parallel sub-iteration over all blocks that can still change. These are the blocks
    /// around which one of the last two sub-iterations, whose rules alternate, changed anything.
    #[inline(always)]
    fn sub_iteration<const SOUTH_EAST: bool>(&mut self) {
        let (shape, [last, other]) = (&self.thin.shape, &mut self.changed);
        self.active.around(shape, &self.thin.used, last, other);
        let (old, new) = (&self.thin.words[..], &mut self.next.words[..]);
        let sets = self.active.words().iter().zip(other.words_mut());
        for (i, (&blocks, changed)) in sets.enumerate() {
            *changed = 0;
            let (first, mut rest) = (shape.first_of(i), blocks);
            while rest != 0 {
                let bit = rest & rest.wrapping_neg();
                let at = first + BLOCK * rest.trailing_zeros() as usize;
                rest ^= bit;
                let left = apply_to_block(&GuoHall::<SOUTH_EAST>, old, at, shape.stride);
                *changed |= if left == *block(old, at) { 0 } else { bit };
                *block_mut(new, at) = left;
            }
        }
        std::mem::swap(last, other);
        std::mem::swap(&mut self.thin, &mut self.next);
    }
}

/// A sub-iteration, compiled for each kind of machine.
struct SubIteration<'a, const SOUTH_EAST: bool>(&'a mut Thinner);

impl<const SOUTH_EAST: bool> lariat_portable::NullaryFnOnce for SubIteration<'_, SOUTH_EAST> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.0.sub_iteration::<SOUTH_EAST>();
    }
}

/// One sub-iteration of Guo and Hall.
struct GuoHall<const SOUTH_EAST: bool>;

impl<const SOUTH_EAST: bool> Rule for GuoHall<SOUTH_EAST> {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let &Around { here, .. } = around;
        // North-west is south-east turned around.
        let [n, s, w, e] = if SOUTH_EAST {
            [around.n, around.s, around.w, around.e]
        } else {
            [around.s, around.n, around.e, around.w]
        };
        let [nw, ne, sw, se] = if SOUTH_EAST {
            [around.nw, around.ne, around.sw, around.se]
        } else {
            [around.se, around.sw, around.ne, around.nw]
        };
        // C, the number of 8-connected pieces around the pixel, is exactly one.
        let (c1, c2) = (!n & (ne | e), !e & (se | s));
        let (c3, c4) = (!s & (sw | w), !w & (nw | n));
        let one_piece = (c1 ^ c2 ^ c3 ^ c4) & !majority(c1, c2, c3);
        let side = !e | !n & !ne & se;

        // 2 ≤ min(N1, N2) ≤ 3, where N1 and N2 are the two ways to pair the eight neighbors. For
        // pixels that meet the other conditions, this requires at least two side neighbors, or one
        // between two corners. It excludes three side neighbors with both corners of the fourth.
        let two = majority(n, s, w) | e & s | nw & (ne | sw) | se & sw;
        let four = n & s & w & ne & se;
        here & !(one_piece & side & two & !four)
    }
}

#[inline(always)]
fn majority(a: u64, b: u64, c: u64) -> u64 {
    a & b | c & (a | b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bitmap::bits::BitPlane;
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

    fn strips(plane: &BitPlane) -> Strips {
        let mut strips = Strips::default();
        strips.take(plane);
        strips
    }

    fn both_agree(mask: &BitPlane) -> Result<(), TestCaseError> {
        let mut thinner = Thinner::default();
        // The second mask reuses the memory of the first.
        let other = plane(mask.width(), mask.height(), |x, y| (x ^ y) & 6 != 0);
        thinner.thin(&strips(&other), 3);
        thinner.thin(&strips(mask), 100);
        let mut slow = mask.clone();
        thin_scalar(&mut slow, 100);
        prop_assert_eq!(thinner.thin.plane(), slow);
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
        let (mut thinner, mut slow) = (Thinner::default(), plane(130, 70, |_, _| true));
        assert!(thinner.thin(&strips(&slow), 100));
        thin_scalar(&mut slow, 100);
        assert!(slow.count() > 0);
        assert_eq!(thinner.thin.plane(), slow);
    }

    #[test]
    fn a_mask_wider_than_the_passes_allow_says_so() {
        let wide = plane(200, 200, |_, _| true);
        assert!(!Thinner::default().thin(&strips(&wide), 5));
    }
}
