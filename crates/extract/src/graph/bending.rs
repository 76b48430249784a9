//! Bending energy of a hidden stretch between two ends.
//!
//! The cubic through both ends with slopes α and β against its chord has a bending energy
//! proportional to α² + αβ + β². An arc costs a quarter of its turn squared, an S three times as
//! much.

use crate::vec2::{self, Vec2};

/// Bending energy (times length / 4) of the cubic from `from` in direction `out` to `to` in
/// direction `onward`.
pub(crate) fn bending(from: Vec2, out: Vec2, to: Vec2, onward: Vec2) -> f32 {
    let chord = vec2::unit_or(vec2::sub(to, from), out);
    let (alpha, beta) = (vec2::angle(chord, out), vec2::angle(chord, onward));
    bending_of(alpha, beta)
}

/// Bending energy for slopes `alpha` and `beta` against the chord.
pub(crate) fn bending_of(alpha: f32, beta: f32) -> f32 {
    alpha * alpha + alpha * beta + beta * beta
}
