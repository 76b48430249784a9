//! Basis functions of the control points and their derivatives with respect to ρ: a row of the
//! fit's matrix `B`.
//!
//! Bezier curves are B-splines without inner knots, so one recurrence serves both: Cox and de
//! Boor's, in the form of Piegl and Tiller (*The NURBS Book*, algorithm A2.2). A derivative is the
//! difference of two functions of one degree lower (equation 2.7), and the recurrence computes
//! those functions on the way. `lariat-fit` evaluates curves in other ways; tests compare the two.

use std::f64::consts::TAU;

use super::form::Form;
use crate::MAX_CONTROL_POINTS;

/// Row `k` is the `k`-th derivative with respect to ρ of all control points' functions; unused
/// entries are 0.
pub(super) type Rows<const K: usize> = [[f64; MAX_CONTROL_POINTS]; K];

/// Basis functions for `count` control points, and their derivatives.
pub(super) fn rows<const K: usize>(form: &Form, count: usize, rho: f64) -> Rows<K> {
    let mut rows = [[0.0; MAX_CONTROL_POINTS]; K];
    match *form {
        Form::Bezier => Knots::bezier(count).rows(rho, &mut rows),
        Form::BSpline { degree, inner } => Knots { degree, inner }.rows(rho, &mut rows),
        Form::Rational { weights } => {
            Knots::bezier(count).rows(rho, &mut rows);
            weigh(&mut rows, weights);
        }
        Form::Fourier => fourier(rho, count, &mut rows),
    }
    rows
}

/// Clamped knots: `degree + 1` zeros, the inner knots, `degree + 1` ones.
struct Knots<'a> {
    degree: usize,
    inner: &'a [f64],
}

impl Knots<'_> {
    fn bezier(count: usize) -> Self {
        Self {
            degree: count - 1,
            inner: &[],
        }
    }

    fn at(&self, index: usize) -> f64 {
        match index.checked_sub(self.degree + 1) {
            None => 0.0,
            Some(inner) => self.inner.get(inner).copied().unwrap_or(1.0),
        }
    }

    /// Evaluates the functions; outside 0 to 1, the first and last pieces are extrapolated.
    fn rows<const K: usize>(&self, rho: f64, rows: &mut Rows<K>) {
        // The span that contains ρ begins at knot `degree + pieces`; its nonzero functions start at
        // `pieces`.
        let pieces = self.inner.partition_point(|&knot| knot <= rho);
        let span = self.degree + pieces;
        let mut values = [0.0; MAX_CONTROL_POINTS];
        values[0] = 1.0;
        for degree in 0..=self.degree {
            if degree > 0 {
                self.raise(span, degree, rho, &mut values);
            }
            let k = self.degree - degree;
            if k < K {
                let mut row = values;
                for lower in degree..self.degree {
                    self.differentiate(span, lower, &mut row);
                }
                rows[k][pieces..=span].copy_from_slice(&row[..=self.degree]);
            }
        }
    }

    /// Raises the functions by one degree, to `degree`.
    fn raise(&self, span: usize, degree: usize, rho: f64, values: &mut [f64; MAX_CONTROL_POINTS]) {
        let mut saved = 0.0;
        for (r, value) in values[..degree].iter_mut().enumerate() {
            let (right, left) = (self.at(span + r + 1), self.at(span + 1 + r - degree));
            let share = *value / (right - left);
            *value = saved + (right - rho) * share;
            saved = (rho - left) * share;
        }
        values[degree] = saved;
    }

    /// Turns functions of degree `lower`, or their derivatives, into the next derivatives one
    /// degree higher.
    fn differentiate(&self, span: usize, lower: usize, row: &mut [f64; MAX_CONTROL_POINTS]) {
        let degree = lower + 1;
        let mut before = 0.0;
        for (r, value) in row[..degree].iter_mut().enumerate() {
            let after = *value / (self.at(span + r + 1) - self.at(span + 1 + r - degree));
            *value = degree as f64 * (before - after);
            before = after;
        }
        row[degree] = degree as f64 * before;
    }
}

/// Turns polynomials into rational functions `wⱼ Bⱼ / Σ w B`, by Leibniz's rule: `wⱼ Bⱼ⁽ᵏ⁾ = Σ C(k,
/// i) Rⱼ⁽ᵏ⁻ⁱ⁾ W⁽ⁱ⁾`.
fn weigh<const K: usize>(rows: &mut Rows<K>, weights: &[f64]) {
    let mut sums = [0.0; K];
    for (row, sum) in rows.iter_mut().zip(&mut sums) {
        for (value, weight) in row.iter_mut().zip(weights) {
            *value *= weight;
            *sum += *value;
        }
    }
    for k in 0..K {
        let (lower, row) = rows.split_at_mut(k);
        let mut binomial = 1.0;
        for i in 1..=k {
            binomial = binomial * (k + 1 - i) as f64 / i as f64;
            for (value, lower) in row[0].iter_mut().zip(&lower[k - i]) {
                *value -= binomial * sums[i] * lower;
            }
        }
        for value in &mut row[0] {
            *value /= sums[0];
        }
    }
}

/// The functions `1, cos 2πρ, sin 2πρ, cos 4πρ, …`.
fn fourier<const K: usize>(rho: f64, count: usize, rows: &mut Rows<K>) {
    if let Some(values) = rows.first_mut() {
        values[0] = 1.0;
    }
    // ρ = 1 gives exactly the same bits as ρ = 0.
    let turn = TAU * (rho - rho.floor());
    for harmonic in 1..=(count - 1) / 2 {
        let (sin, cos) = (harmonic as f64 * turn).sin_cos();
        let frequency = harmonic as f64 * TAU;
        let (mut even, mut odd) = (cos, sin);
        for row in rows.iter_mut() {
            (row[2 * harmonic - 1], row[2 * harmonic]) = (even, odd);
            (even, odd) = (-frequency * odd, frequency * even);
        }
    }
}
