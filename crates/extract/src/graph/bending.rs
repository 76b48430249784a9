//! The hidden stretch between two ends: a cubic, and its bending energy.
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

/// Hermite cubic from one place, in the direction out of it, to another. Its speed at both ends
/// makes it nearly an arc of a circle if both turn by the same angle.
pub(crate) fn cubic([from, out]: [Vec2; 2], [to, back]: [Vec2; 2]) -> impl Fn(f32) -> Vec2 {
    // The speed is 4 tan(θ/4) radii for a turn by θ.
    let cos_half = (0.5 - 0.5 * vec2::dot(out, back)).clamp(0.0, 1.0).sqrt();
    let pace_px = 2.0 * vec2::distance(from, to) / (1.0 + cos_half);
    move |t| {
        let (s, u) = (t * t * (3.0 - 2.0 * t), 1.0 - t);
        let straight = vec2::along(from, vec2::sub(to, from), s);
        let leaving = vec2::along(straight, out, pace_px * t * u * u);
        vec2::along(leaving, back, pace_px * t * t * u)
    }
}
