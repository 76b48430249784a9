//! `J = ∂s/∂r`: the response of each coordinate of the shape to each coordinate of the grippers, px
//! per px.

use crate::{Coordinates, Features, INPUTS, MAX_FEATURES};

/// The columns. Columns of inputs that cannot move are 0, as are entries after the shape's size.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Jacobian {
    pub(crate) columns: [Features; INPUTS],
}

impl Jacobian {
    pub(crate) const ZERO: Self = Self {
        columns: [[0.0; MAX_FEATURES]; INPUTS],
    };

    /// Returns `J δr`.
    pub(crate) fn times(&self, dr: &Coordinates) -> Features {
        let mut product = [0.0; MAX_FEATURES];
        for (column, dr) in self.columns.iter().zip(dr) {
            for (sum, entry) in product.iter_mut().zip(column) {
                *sum += entry * dr;
            }
        }
        product
    }

    /// Returns the innovation `δs − J δr`.
    pub(crate) fn surprise(&self, dr: &Coordinates, ds: &Features) -> Features {
        let mut rest = *ds;
        for (rest, expected) in rest.iter_mut().zip(self.times(dr)) {
            *rest -= expected;
        }
        rest
    }

    /// `J ← J + δs gᵀ`.
    pub(crate) fn add(&mut self, ds: &Features, gain: &Coordinates) {
        for (column, gain) in self.columns.iter_mut().zip(gain) {
            for (entry, ds) in column.iter_mut().zip(ds) {
                *entry += ds * gain;
            }
        }
    }
}

/// `a·a`.
pub(crate) fn square(a: &Coordinates) -> f64 {
    a.iter().map(|a| a * a).sum()
}
