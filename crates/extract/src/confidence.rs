//! How sure it is that a curve is a rope, whole and in order.

use crate::scene::{Curve, Status};

/// What a doubt leaves of it.
const DOUBTED: f32 = 0.5;

/// The confidence of a curve: what is covered is not seen, and what is doubted may be no rope.
pub(crate) fn of(curve: &Curve) -> f32 {
    let points = curve.hidden.len().max(1) as f32;
    let hidden = curve.hidden.iter().filter(|&&is_hidden| is_hidden).count() as f32;
    let seen = 1.0 - hidden / points;
    match curve.status {
        Status::Doubtful => DOUBTED * seen,
        _ => seen,
    }
}
