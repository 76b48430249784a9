//! The Alexander polynomial of a rope whose ends are joined over everything, at a few whole
//! numbers.
//!
//! This is Wirtinger's presentation of the knot group, in the Alexander module. The strand between
//! two passes under is an arc. If the strand continues from arc `b` to `c` under the arc `a`, then
//! `c = t·b + (1 − t)·a`, or `b = t·c + (1 − t)·a` for the other sign. Δ(t) is any minor of these
//! relations that leaves one arc out, up to ±tᵏ. It is 1 for a straight rope.
//!
//! An arc that joins the ends *under* everything adds only the one relation that is redundant
//! anyway (Turaev 2012, section 2.4), and needs no place in the plane. The rope is therefore viewed
//! from below, with over and under exchanged.

use super::Pass;

/// A prime. A product of two residues fits into `u128`, and values below the prime are exact.
const PRIME: u64 = (1 << 61) - 1;
/// Points where the polynomial is evaluated. −1 gives the knot's determinant; the others detect
/// knots of determinant 1.
const PLACES: [u64; 4] = [PRIME - 1, 2, 3, 5];

/// Returns whether the closed rope is proven to be a knot. `signs` has one entry per crossing.
pub(super) fn proves_a_knot(passes: &[Pass], signs: &[bool]) -> bool {
    // A straight rope's minor is a polynomial of at most this degree, and so one of ±1, ±t, ±t² …
    let most = signs.len();
    PLACES.into_iter().any(|t| {
        let value = minor(passes, signs, t);
        let mut power = 1;
        let is_unit = (0..=most).any(|_| {
            let hit = value == power || value == minus(0, power);
            power = times(power, t);
            hit
        });
        !is_unit
    })
}

/// The minor of the relations without the first arc, at `t`, modulo [`PRIME`], up to its sign.
pub(super) fn minor(passes: &[Pass], signs: &[bool], t: u64) -> u64 {
    let n = signs.len();
    let mut relations = vec![vec![0u64; n + 1]; n];
    let mut arc = 0;
    for pass in passes {
        let relation = &mut relations[pass.crossing];
        let mut add = |arc: usize, value: u64| relation[arc] = plus(relation[arc], value);
        if pass.over {
            // Seen from below, this is the strand that passes under, and its arc ends.
            let (before, after) = if signs[pass.crossing] {
                (t, PRIME - 1)
            } else {
                (PRIME - 1, t)
            };
            add(arc, before);
            add(arc + 1, after);
            arc += 1;
        } else {
            add(arc, minus(1, t));
        }
    }
    let mut square: Vec<Vec<u64>> = relations.into_iter().map(|row| row[1..].to_vec()).collect();
    determinant(&mut square)
}

/// The determinant by elimination, up to its sign.
fn determinant(rows: &mut [Vec<u64>]) -> u64 {
    let n = rows.len();
    let mut product = 1;
    for column in 0..n {
        let Some(pivot) = (column..n).find(|&row| rows[row][column] != 0) else {
            return 0;
        };
        rows.swap(column, pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let pivot = &above[column];
        product = times(product, pivot[column]);
        let inverse = power(pivot[column], PRIME - 2);
        for row in below {
            let share = times(row[column], inverse);
            for (value, &above) in row.iter_mut().zip(pivot).skip(column) {
                *value = minus(*value, times(share, above));
            }
        }
    }
    product
}

fn plus(a: u64, b: u64) -> u64 {
    (a + b) % PRIME
}

fn minus(a: u64, b: u64) -> u64 {
    (a + PRIME - b) % PRIME
}

fn times(a: u64, b: u64) -> u64 {
    // The remainder is below 2⁶¹.
    (u128::from(a) * u128::from(b) % u128::from(PRIME)) as u64
}

fn power(mut base: u64, mut exponent: u64) -> u64 {
    let mut result = 1;
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = times(result, base);
        }
        base = times(base, base);
        exponent >>= 1;
    }
    result
}

/// The knot's determinant |Δ(−1)|.
#[cfg(test)]
pub(super) fn knot_determinant(passes: &[Pass], signs: &[bool]) -> u64 {
    let value = minor(passes, signs, PRIME - 1);
    value.min(PRIME - value)
}
