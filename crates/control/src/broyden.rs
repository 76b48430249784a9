//! Broyden's rank-one rule, damped:
//!
//! ```text
//! J ← J + γ (δs − J δr) δrᵀ/(δrᵀδr)
//! ```
//!
//! the least change of `J` that agrees with the pair (γ = 1), or goes a part of the way (C. Broyden, Math. Comp. 19, 1965; in visual
//! servoing M. Jägersand, O. Fuentes, R. Nelson, ICRA 1997). Noise `n` in `δs` makes `γn/‖δr‖` of `J`: pairs are chosen so that this is
//! small (`pairs`).

use crate::Coordinates;
use crate::estimator::NONE;
use crate::jacobian::square;

/// What of the surprise each column takes.
pub(crate) fn gain(share: f64, dr: &Coordinates) -> Coordinates {
    let square = square(dr);
    if square == 0.0 {
        return NONE;
    }
    dr.map(|dr| share * dr / square)
}
