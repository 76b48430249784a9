//! Uncertainty of a fit, computed from `Z = A L⁻ᵀ` and `X = L⁻¹R⁻ᵀ`, the factor of
//! `(BᵀWB + K)⁻¹ = XᵀX`: noise gains of the curve's points, covariance of the control points,
//! degrees of freedom, condition number.
//!
//! In the coordinates `y`, noise of the points has covariance `σ² (I − P + VJVᵀ)`. The points alone
//! contribute `σ² I`. A ridge subtracts `P = ΠK̃Π`, `K̃ = XKXᵀ` (it also shrinks the noise), and
//! pinned ends add `VJVᵀ` (see `ends`). The residuals' `tr((I−H)ᵀW(I−H))` is `N − m + |P|²` plus
//! the contribution of `ends`.

use super::columns::{Gains, Gram, Residuals, Triangular};
use super::{MAX_NOISE_GAIN, Problem, Weighted, WeightedError, WeightedFit};

impl<const D: usize> Weighted<D> {
    /// Computes the control points and all quality numbers from the coefficients.
    pub(crate) fn finish(
        &mut self,
        problem: &Problem<'_, D>,
        seen: usize,
        control_points: &mut [[f64; D]],
    ) -> Result<WeightedFit, WeightedError> {
        assert_eq!(control_points.len(), self.count, "m control points");
        self.refine(problem);
        let noise_gain = self.noise_gain(problem.pins);
        // Not `>`, so that NaN is rejected.
        if noise_gain.is_nan() || noise_gain > MAX_NOISE_GAIN {
            return Err(WeightedError::Undetermined {
                gain: noise_gain,
                limit: MAX_NOISE_GAIN,
            });
        }
        let [largest, sum_w_r2] = self.exact_residuals();
        control_points.copy_from_slice(&self.control_points);
        self.invert();
        let condition = self.condition(problem.ridge);
        let ridge = problem.ridge.is_some();
        let mut freedom = (seen - self.count) as f64;
        if let Some(k) = problem.ridge {
            congruent(&self.x, k, &mut self.room, &mut self.ridge);
        }
        if problem.pins {
            freedom += self.ends.freedom(ridge.then_some(&self.ridge[..]));
            self.spread_pins();
        }
        if ridge {
            if problem.pins {
                self.ends.project(&mut self.ridge);
            }
            freedom += self.ridge.iter().map(|number| number * number).sum::<f64>();
            self.spread_ridge();
        }
        Ok(WeightedFit {
            sum_w_r2,
            max_px: largest.sqrt(),
            degrees_of_freedom: freedom,
            condition,
            noise_gain,
        })
    }

    /// Computes the control points, corrected once by the residuals of `B` itself.
    fn refine(&mut self, problem: &Problem<'_, D>) {
        self.control_points.fill([0.0; D]);
        self.add_coefficients();
        self.exact_residuals();
        // y of the correction is L⁻¹ (AᵀWr − R⁻ᵀKs).
        self.solve_left();
        if let Some(k) = problem.ridge {
            self.subtract_penalty(k);
        }
        self.normal.solve_lower(&mut self.y);
        let pinned = problem.pinned();
        let last = self.count - 1;
        self.complete(pinned.map(|[first_end, last_end]| {
            [
                difference(first_end, self.control_points[0]),
                difference(last_end, self.control_points[last]),
            ]
        }));
        self.add_coefficients();
        if let Some(pinned) = pinned {
            [self.control_points[0], self.control_points[last]] = pinned;
        }
    }

    /// `s + R⁻¹ a`.
    fn add_coefficients(&mut self) {
        for (row, a) in self.lower.chunks_exact(self.count).zip(&self.coefficients) {
            for (point, inverse) in self.control_points.iter_mut().zip(row) {
                for axis in 0..D {
                    point[axis] += inverse * a[axis];
                }
            }
        }
    }

    /// Subtracts `R⁻ᵀKs` from the right-hand sides of the correction.
    fn subtract_penalty(&mut self, k: &[f64]) {
        for (i, k) in k.chunks_exact(self.count).enumerate() {
            let mut pull = [0.0; D];
            for (k, s) in k.iter().zip(&self.control_points) {
                for axis in 0..D {
                    pull[axis] += k * s[axis];
                }
            }
            let rows = self.lower.chunks_exact(self.count).zip(&mut self.y);
            for (row, right) in rows.skip(i) {
                for axis in 0..D {
                    right[axis] -= row[i] * pull[axis];
                }
            }
        }
    }

    /// Computes the residuals of `B` and the control points. Returns the largest square of those
    /// with a weight, and the weighted sum.
    fn exact_residuals(&mut self) -> [f64; 2] {
        let points = &self.a.all()[self.count * self.a.stride()..];
        self.arch.dispatch(Residuals {
            basis: self.b.all(),
            points,
            left: self.left.all_mut(),
            coefficients: &self.control_points,
            weights: self.weights.all(),
            squared: self.squared.all_mut(),
        })
    }

    /// The largest noise gain of a point of the curve.
    fn noise_gain(&mut self, pins: bool) -> f64 {
        let stride = self.a.stride();
        self.arch.dispatch(Triangular {
            from: self.a.all(),
            lower: self.normal.inverse(),
            lower_stride: self.normal.stride(),
            count: self.count,
            stride,
            to: self.z.all_mut(),
        });
        let squared = self.arch.dispatch(Gains {
            columns: self.z.all(),
            stride,
            pinned: pins.then_some(&self.ends),
        });
        let heaviest = self.weights.all().iter().fold(0.0, |a, &b| f64::max(a, b));
        (squared * heaviest).sqrt()
    }

    /// Computes `X`, and `XᵀX` as the covariance.
    fn invert(&mut self) {
        let (count, normal, lower) = (self.count, &self.normal, &self.lower[..]);
        let (x, covariance) = (&mut self.x[..], &mut self.covariance[..]);
        self.arch.dispatch(
            #[inline(always)]
            || {
                x.fill(0.0);
                covariance.fill(0.0);
                for (j, row) in x.chunks_exact_mut(count).enumerate() {
                    for (k, &inverse) in normal.inverse_row(j)[..=j].iter().enumerate() {
                        add(row, inverse, &lower[k * count..(k + 1) * count]);
                    }
                    for (i, &number) in row[..=j].iter().enumerate() {
                        add(&mut covariance[i * count..(i + 1) * count], number, row);
                    }
                }
            },
        );
    }

    /// Condition number of `BᵀWB + K` from its largest eigenvalue and that of its inverse. Each
    /// takes two steps of the power method: from the sums of the weighted columns of `B`, and from
    /// the axis that the inverse stretches most.
    fn condition(&mut self, ridge: Option<&[f64]>) -> f64 {
        let mut norm = self.largest_eigenvalue();
        if let Some(ridge) = ridge {
            let rows = ridge.chunks_exact(self.count);
            norm += rows
                .map(|row| row.iter().map(|k| k.abs()).sum())
                .fold(0.0, f64::max);
        }
        let diagonal = |j: usize| self.covariance[j * self.count + j];
        let widest = (0..self.count).fold(0, |a, b| if diagonal(b) > diagonal(a) { b } else { a });
        let rows = self.covariance.chunks_exact(self.count);
        let axis = &self.covariance[widest * self.count..(widest + 1) * self.count];
        let (mut before, mut after) = (0.0, 0.0);
        for (row, &along) in rows.zip(axis) {
            let product: f64 = row.iter().zip(axis).map(|(a, b)| a * b).sum();
            before += along * along;
            after += product * product;
        }
        norm * (after / before).sqrt()
    }

    /// Largest eigenvalue of `BᵀWB`: `vᵀBᵀWBv / vᵀv`, `v = BᵀW1`.
    fn largest_eigenvalue(&mut self) -> f64 {
        let v = &mut self.room[..self.count];
        self.arch.dispatch(Gram {
            left: self.b.all(),
            right: self.weights.all(),
            stride: self.b.stride(),
            symmetric: false,
            sums: v,
            sums_stride: 1,
        });
        let length: f64 = v.iter().map(|v| v * v).sum();
        // The residual of zero is −Bv.
        let [_, weighted] = self.arch.dispatch(Residuals {
            basis: self.b.all(),
            points: self.zeros.all(),
            left: &mut self.left.all_mut()[..self.b.stride()],
            coefficients: v.as_chunks::<1>().0,
            weights: self.weights.all(),
            squared: self.squared.all_mut(),
        });
        weighted / length
    }

    /// Adds `XᵀVJVᵀX` to the covariance.
    fn spread_pins(&mut self) {
        let count = self.count;
        let j = self.ends.j();
        let along = &mut self.along;
        along.fill([0.0; 2]);
        for (row, v) in self.x.chunks_exact(count).zip(&self.ends.v) {
            for (along, &x) in along.iter_mut().zip(row) {
                along[0] += x * v[0];
                along[1] += x * v[1];
            }
        }
        for (row, g) in self.covariance.chunks_exact_mut(count).zip(&*along) {
            let left = [
                j[0][0] * g[0] + j[1][0] * g[1],
                j[0][1] * g[0] + j[1][1] * g[1],
            ];
            for (number, g) in row.iter_mut().zip(&*along) {
                *number += left[0] * g[0] + left[1] * g[1];
            }
        }
    }

    /// Subtracts `XᵀPX` from the covariance.
    fn spread_ridge(&mut self) {
        let count = self.count;
        self.room.fill(0.0);
        for (row, p) in self
            .room
            .chunks_exact_mut(count)
            .zip(self.ridge.chunks_exact(count))
        {
            for (&p, x) in p.iter().zip(self.x.chunks_exact(count)) {
                add(row, p, x);
            }
        }
        for (x, row) in self
            .x
            .chunks_exact(count)
            .zip(self.room.chunks_exact(count))
        {
            for (&x, covariance) in x.iter().zip(self.covariance.chunks_exact_mut(count)) {
                add(covariance, -x, row);
            }
        }
    }
}

fn difference<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// `to += factor · row`.
#[inline(always)]
fn add(to: &mut [f64], factor: f64, row: &[f64]) {
    for (to, number) in to.iter_mut().zip(row) {
        *to += factor * number;
    }
}

/// `out = lower · k · lowerᵀ`, square matrices row by row; `room` is scratch memory of the same
/// size.
pub(super) fn congruent(lower: &[f64], k: &[f64], room: &mut [f64], out: &mut [f64]) {
    let count = k.len().isqrt();
    room.fill(0.0);
    for (j, row) in room.chunks_exact_mut(count).enumerate() {
        let factors = &lower[j * count..][..=j];
        for (&factor, k) in factors.iter().zip(k.chunks_exact(count)) {
            add(row, factor, k);
        }
    }
    for (row, out) in room.chunks_exact(count).zip(out.chunks_exact_mut(count)) {
        for (i, (out, lower)) in out.iter_mut().zip(lower.chunks_exact(count)).enumerate() {
            *out = row[..=i].iter().zip(lower).map(|(a, b)| a * b).sum();
        }
    }
}
