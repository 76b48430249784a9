//! Correlation of the control points' errors in a fit: `(BᵀB)⁻¹`, computed from the inverse of the
//! triangle `R` of `B = QR`.
//!
//! The message has the covariance of each control point only. Their correlations are the same in
//! every frame and are computed here from basis, knots and number of points. The triangle `R` is
//! used instead of `BᵀB`, whose condition number is the square of that of `B` and exceeds double
//! precision at high orders.

use std::cell::RefCell;

use super::Shape;
use super::form::Form;
use super::rows;
use crate::MAX_CONTROL_POINTS;

/// The upper triangle `R⁻¹`, so that `(BᵀB)⁻¹ = R⁻¹R⁻ᵀ`.
#[derive(Debug, Clone)]
pub(super) struct Inverse {
    /// Row `j` belongs to control point `j`; its entries before `j` are 0.
    rows: [[f64; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS],
    count: usize,
}

/// Everything that `B` depends on.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    kind: u8,
    count: usize,
    degree: usize,
    samples: usize,
    /// Inner knots, or weights.
    numbers: [f64; MAX_CONTROL_POINTS],
}

thread_local! {
    /// The last two inverses, typically one for open curves and one for closed ones. They are kept
    /// per thread, because each thread has its own readers.
    static LAST: RefCell<Vec<(Key, Box<Inverse>)>> = const { RefCell::new(Vec::new()) };
}

impl Inverse {
    /// Lends the inverse of a shape's `B`. It is computed if it is not among the last two. The
    /// first two calls of a thread allocate some kilobytes.
    pub(super) fn with<const D: usize, T>(shape: &Shape<D>, use_it: impl FnOnce(&Self) -> T) -> T {
        let key = Key::of(shape);
        LAST.with_borrow_mut(|last| {
            match last.iter().position(|(known, _)| *known == key) {
                Some(index) => last[index..].rotate_left(1),
                None if last.len() < 2 => last.push((key, Box::new(Self::of(shape)))),
                None => {
                    last.rotate_left(1);
                    let (known, inverse) = &mut last[1];
                    *known = key;
                    **inverse = Self::of(shape);
                }
            }
            // The list is not empty: an inverse was just found or added.
            use_it(&last[last.len() - 1].1)
        })
    }

    /// Row `j` of `R⁻¹`; its entries before column `j` are 0.
    pub(super) fn row(&self, j: usize) -> &[f64] {
        &self.rows[j][..self.count]
    }

    /// Variance of control point `j` for unit noise in the points.
    pub(super) fn variance(&self, j: usize) -> f64 {
        self.row(j).iter().map(|r| r * r).sum()
    }

    fn of<const D: usize>(shape: &Shape<D>) -> Self {
        let count = shape.control_points.len();
        let mut triangle = [[0.0; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS];
        for i in 0..shape.samples {
            let rho = shape.even_rho(i, shape.samples);
            let [mut row] = rows::rows(&shape.form, count, rho);
            take_in(&mut triangle, &mut row, count);
        }
        Self {
            rows: inverted(&triangle, count),
            count,
        }
    }
}

/// Adds a row of `B` to the triangle by Givens rotations, one per column.
fn take_in(
    triangle: &mut [[f64; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS],
    row: &mut [f64; MAX_CONTROL_POINTS],
    count: usize,
) {
    for j in 0..count {
        if row[j] == 0.0 {
            continue;
        }
        let length = triangle[j][j].hypot(row[j]);
        let (cos, sin) = (triangle[j][j] / length, row[j] / length);
        for k in j..count {
            let (above, below) = (triangle[j][k], row[k]);
            triangle[j][k] = cos * above + sin * below;
            row[k] = cos * below - sin * above;
        }
    }
}

/// Inverts an upper triangle, column by column from the diagonal up.
fn inverted(
    triangle: &[[f64; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS],
    count: usize,
) -> [[f64; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS] {
    let mut inverse = [[0.0; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS];
    for j in 0..count {
        let mut column = [0.0; MAX_CONTROL_POINTS];
        for i in (0..=j).rev() {
            let right = if i == j { 1.0 } else { 0.0 };
            let known: f64 = (i + 1..=j).map(|k| triangle[i][k] * column[k]).sum();
            column[i] = (right - known) / triangle[i][i];
        }
        for (row, entry) in inverse.iter_mut().zip(column) {
            row[j] = entry;
        }
    }
    inverse
}

impl Key {
    fn of<const D: usize>(shape: &Shape<D>) -> Self {
        let (kind, degree, given) = match shape.form {
            Form::Bezier => (0, 0, &[][..]),
            Form::BSpline { degree, inner } => (1, degree, inner),
            Form::Rational { weights } => (2, 0, weights),
            Form::Fourier => (3, 0, &[][..]),
        };
        let mut numbers = [0.0; MAX_CONTROL_POINTS];
        numbers[..given.len()].copy_from_slice(given);
        Self {
            kind,
            count: shape.control_points.len(),
            degree,
            samples: shape.samples,
            numbers,
        }
    }
}
