//! Growth of some pixels to everything that is connected with them.

use super::bits::BitPlane;
use std::ops::Range;

/// Maximum number of bends of an outline that are followed.
const MOST_BENDS: usize = 24;

/// Grows `plane` within `limits`, through sides, to everything that is connected with it. Goes down
/// and up until a round changes nothing or the plane has more than `most` pixels.
///
/// The pixels are within `rows`, whose limits are known. When another row is reached, `limit`
/// writes its limits. Returns the rows whose limits are known in the end.
pub(crate) fn spread(
    (plane, limits): (&mut BitPlane, &mut BitPlane),
    mut rows: Range<usize>,
    most: f32,
    mut limit: impl FnMut(usize, &mut BitPlane),
) -> Range<usize> {
    let is_empty = |plane: &BitPlane, y: usize| plane.row(y).iter().all(|&word| word == 0);
    // Each round goes around one bend. A shape with more bends is not an object's outline.
    for _ in 0..MOST_BENDS {
        let mut changed = false;
        for y in rows.start + 1..plane.height() {
            if y == rows.end {
                if is_empty(plane, y - 1) {
                    break;
                }
                limit(y, limits);
                rows.end += 1;
            }
            changed |= spread_row(plane, limits, y, y - 1);
        }
        for y in (0..rows.end - 1).rev() {
            if y + 1 == rows.start {
                if is_empty(plane, y + 1) {
                    break;
                }
                limit(y, limits);
                rows.start -= 1;
            }
            changed |= spread_row(plane, limits, y, y + 1);
        }
        if !changed || plane.count() as f32 > most {
            break;
        }
    }
    rows
}

/// Grows row `y` from row `from` and along itself. Returns whether it grew.
fn spread_row(plane: &mut BitPlane, limits: &BitPlane, y: usize, from: usize) -> bool {
    let words = plane.words_per_row();
    let mut any = false;
    for i in 0..words {
        let new = plane.row(from)[i] & limits.row(y)[i] & !plane.row(y)[i];
        plane.row_mut(y)[i] |= new;
        any |= new != 0;
    }
    if !any {
        return false;
    }
    spread_along(plane.row_mut(y), limits.row(y));
    true
}

/// Grows a row along itself, to the whole of each run of `limits` that has one of its pixels.
pub(crate) fn spread_along(row: &mut [u64], limits: &[u64]) {
    let mut carried = 0;
    for (word, &own) in row.iter_mut().zip(limits) {
        *word |= rest_of_runs(own, (*word | carried) & own);
        carried = *word >> 63;
    }
    carried = 0;
    for (word, &own) in row.iter_mut().zip(limits).rev() {
        let seeds = (*word | carried << 63) & own;
        *word |= rest_of_runs(own.reverse_bits(), seeds.reverse_bits()).reverse_bits();
        carried = *word & 1;
    }
}

/// For each run of set bits in `own`, the bits from its first seed on. Adding the seeds carries
/// through each run.
fn rest_of_runs(own: u64, seeds: u64) -> u64 {
    seeds | own & !own.wrapping_add(seeds & !(seeds << 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreading_stays_within_its_limits_and_reaches_all_that_hangs_together() {
        let (mut plane, mut limits) = (BitPlane::default(), BitPlane::default());
        plane.resize(150, 20);
        limits.resize(150, 20);
        // A U, and a piece apart from it.
        (2..15).for_each(|y| {
            limits.fill(y, 10, 14, true);
            limits.fill(y, 120, 125, true);
        });
        limits.fill(14, 10, 125, true);
        limits.fill(2, 60, 90, true);
        plane.fill(3, 11, 12, true);
        // Rows get their limits when they are reached.
        let mut known = BitPlane::default();
        known.resize(150, 20);
        let limit = |y: usize, known: &mut BitPlane| {
            known.row_mut(y).copy_from_slice(limits.row(y));
        };
        limit(3, &mut known);
        let rows = spread((&mut plane, &mut known), 3..4, f32::INFINITY, limit);
        assert_eq!(rows, 1..16);
        assert!(plane.get(122, 2) && plane.get(70, 14) && plane.get(10, 2));
        assert!(!plane.get(70, 2));
        assert_eq!(plane.count(), limits.count() - 30);
    }
}
