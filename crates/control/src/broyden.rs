//! Broyden's rank-one rule, damped:
//!
//! ```text
//! J ← J + γ (δs − J δr) δrᵀ/(δrᵀδr)
//! ```
//!
//! With γ = 1, this is the smallest change of `J` that agrees with the pair. A smaller γ makes part
//! of that change (C. Broyden, Math. Comp. 19, 1965; in visual servoing M. Jägersand, O. Fuentes,
//! R. Nelson, ICRA 1997). Noise `n` in `δs` changes `J` by `γn/‖δr‖`, so pairs are chosen to keep
//! this small (`pairs`).

use crate::Coordinates;
use crate::estimator::NONE;
use crate::jacobian::square;

/// Returns the share of the innovation that each column takes.
pub(crate) fn gain(share: f64, dr: &Coordinates) -> Coordinates {
    let square = square(dr);
    if square == 0.0 {
        return NONE;
    }
    dr.map(|dr| share * dr / square)
}
