//! The filter's algebra: a state in curve coordinates, its prediction, and its update by a
//! measurement.
//!
//! Every axis has the same covariance, so it is stored once, as three `m` × `m` blocks: positions
//! with positions, positions with velocities, velocities with velocities,
//!
//! ```text
//! P = [ X   C ]     x, v: m × D, one column an axis
//!     [ Cᵀ  V ]
//! ```

use super::rows::{LANES, Rows, eliminate, transposed_product, vectors};

/// Positions, velocities and their covariance.
#[derive(Debug, Clone)]
pub(super) struct State<const D: usize> {
    pub(super) positions: Vec<[f64; D]>,
    pub(super) velocities: Vec<[f64; D]>,
    /// `X`, symmetric.
    pub(super) of_positions: Rows,
    /// `C`, in general not symmetric.
    pub(super) mixed: Rows,
    /// `V`, symmetric.
    pub(super) of_velocities: Rows,
}

impl<const D: usize> State<D> {
    /// Allocates for `max` control points.
    pub(super) fn new(max: usize) -> Self {
        Self {
            positions: vec![[0.0; D]; max],
            velocities: vec![[0.0; D]; max],
            of_positions: Rows::square(max),
            mixed: Rows::square(max),
            of_velocities: Rows::square(max),
        }
    }

    /// Resets to these positions with the covariance `noise`, at rest with the variance
    /// `speed_variance`.
    pub(super) fn begin(&mut self, positions: &[[f64; D]], noise: &Rows, speed_variance: f64) {
        let (count, width) = (positions.len(), noise.width);
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.velocities.clear();
        self.velocities.resize(count, [0.0; D]);
        self.mixed.reshape(count, width);
        self.of_positions.reshape(count, width);
        self.of_positions.vectors.copy_from_slice(&noise.vectors);
        self.of_velocities.reshape(count, width);
        for i in 0..count {
            self.of_velocities.set(i, i, speed_variance);
        }
    }

    /// Writes the state after `seconds` to `later`, with white acceleration of the spectral density
    /// `q`. The result is the exact integral over continuous time for any time step:
    ///
    /// ```text
    /// x += h v     X += h (C + Cᵀ) + h² V + q |h|³/3
    ///              C += h V + q h |h|/2
    ///              V += q |h|
    /// ```
    ///
    /// `h < 0` goes back in time: the acceleration since then is treated as unknown.
    #[inline(always)]
    pub(super) fn propagate(&self, seconds: f64, q: f64, later: &mut Self) {
        let (h, a) = (seconds, seconds.abs());
        let (count, width) = (self.positions.len(), self.of_positions.width);
        later.positions.clear();
        let states = self.positions.iter().zip(&self.velocities);
        let moved = states.map(|(x, v)| std::array::from_fn(|axis| x[axis] + h * v[axis]));
        later.positions.extend(moved);
        later.velocities.clear();
        later.velocities.extend_from_slice(&self.velocities);
        for block in [
            &mut later.of_positions,
            &mut later.mixed,
            &mut later.of_velocities,
        ] {
            block.reshape(count, width);
        }
        let old = self.of_positions.vectors.iter().zip(&self.mixed.vectors);
        let old = old.zip(&self.of_velocities.vectors);
        let new = later.of_positions.vectors.iter_mut();
        let new = new.zip(&mut later.mixed.vectors);
        let new = new.zip(&mut later.of_velocities.vectors);
        for (((x, c), v), ((new_x, new_c), new_v)) in old.zip(new) {
            for lane in 0..LANES {
                new_c[lane] = c[lane] + h * v[lane];
                // Half of the mixed terms; the transposed half follows below.
                new_x[lane] = x[lane] + h * (c[lane] + h * v[lane]);
                new_v[lane] = v[lane];
            }
        }
        for i in 0..count {
            for j in 0..count {
                later.of_positions.add(i, j, h * self.mixed.get(j, i));
            }
            later.of_positions.add(i, i, q * a * a * a / 3.0);
            later.mixed.add(i, i, q * h * a / 2.0);
            later.of_velocities.add(i, i, q * a);
        }
    }

    /// Updates the state with measured positions, with the covariance `noise` for each axis
    /// (positive definite). Returns the normalized innovation squared: the innovation's `νᵀS⁻¹ν`
    /// summed over the axes. If that exceeds `gate`, returns it as an error and leaves the state
    /// unchanged. The value is infinite if it cannot be computed.
    ///
    /// With `S = X + R = UᵀU`, a single elimination gives everything, and the update needs no
    /// inverse:
    ///
    /// ```text
    /// [S | X | C | R | ν]  →  [U | A | B | N | y]      A = U⁻ᵀX, B = U⁻ᵀC, N = U⁻ᵀR, y = U⁻ᵀν
    ///
    /// x += Aᵀy     X = AᵀN      since X − X S⁻¹ X = X S⁻¹ R
    /// v += Bᵀy     C = NᵀB      since C − X S⁻¹ C = R S⁻¹ C
    ///              V −= BᵀB
    /// ```
    ///
    /// The forms on the right avoid differences, in which a large prior variance would swamp the
    /// small variance of a precise measurement. Their errors are proportional to the smaller of the
    /// two variances.
    #[inline(always)]
    pub(super) fn measure(
        &mut self,
        measured: &[[f64; D]],
        noise: &Rows,
        gate: f64,
        work: &mut Rows,
    ) -> Result<f64, f64> {
        let (count, width) = (measured.len(), noise.width);
        let columns = [width, 2 * width, 3 * width, 4 * width];
        let [a, b, n, y] = columns;
        work.reshape(count, 4 * width + vectors(D));
        for (i, point) in measured.iter().enumerate() {
            let row = &mut work.vectors[i * work.width..(i + 1) * work.width];
            let (x, r) = (self.of_positions.row(i), noise.row(i));
            for (sum, (x, r)) in row.iter_mut().zip(x.iter().zip(r)) {
                for lane in 0..LANES {
                    sum[lane] = x[lane] + r[lane];
                }
            }
            row[a..b].copy_from_slice(x);
            row[b..n].copy_from_slice(self.mixed.row(i));
            row[n..y].copy_from_slice(r);
            let innovation = row[y..].as_flattened_mut();
            for axis in 0..D {
                innovation[axis] = point[axis] - self.positions[i][axis];
            }
        }
        if !eliminate(work, count) {
            return Err(f64::INFINITY);
        }
        let squared = work.vectors.chunks_exact(work.width);
        let nis: f64 = squared
            .flat_map(|row| row[y..].as_flattened())
            .map(|number| number * number)
            .sum();
        // Also rejects NaN.
        if !(0.0..=gate).contains(&nis) {
            return Err(nis);
        }
        add_innovation(&mut self.positions, work, a, y);
        add_innovation(&mut self.velocities, work, b, y);
        self.of_positions.reshape(count, width);
        transposed_product(&mut self.of_positions, 1.0, work, [a, n], count);
        self.of_positions.symmetrize(count);
        self.mixed.reshape(count, width);
        transposed_product(&mut self.mixed, 1.0, work, [n, b], count);
        transposed_product(&mut self.of_velocities, -1.0, work, [b, b], count);
        Ok(nis)
    }
}

/// `state += Tᵀy`, where `T` are the columns of `work` from vector `t` on, and `y` are those from
/// vector `y` on.
#[inline(always)]
fn add_innovation<const D: usize>(state: &mut [[f64; D]], work: &Rows, t: usize, y: usize) {
    for row in work.vectors.chunks_exact(work.width) {
        let (t, y) = (row[t..].as_flattened(), row[y..].as_flattened());
        for (sum, t) in state.iter_mut().zip(t) {
            for axis in 0..D {
                sum[axis] += t * y[axis];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::rows::congruence;
    use proptest::prelude::*;

    /// Checks that the whole covariance, positions and velocities, can be factored when scaled to a
    /// diagonal of ones.
    fn is_positive_definite<const D: usize>(state: &State<D>) -> bool {
        let count = state.positions.len();
        let mut whole = Rows::square(2 * count);
        for i in 0..count {
            for j in 0..count {
                whole.set(i, j, state.of_positions.get(i, j));
                whole.set(i, count + j, state.mixed.get(i, j));
                whole.set(count + j, i, state.mixed.get(i, j));
                whole.set(count + i, count + j, state.of_velocities.get(i, j));
            }
        }
        let scales: Vec<f64> = (0..2 * count).map(|i| whole.get(i, i).sqrt()).collect();
        for i in 0..2 * count {
            for j in 0..2 * count {
                whole.set(i, j, whole.get(i, j) / (scales[i] * scales[j]));
            }
        }
        eliminate(&mut whole, 2 * count)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]

        /// Options are within their ranges, and noise is from a ten-thousandth of a pixel to ten
        /// thousand pixels, in any direction.
        #[test]
        fn the_covariance_stays_positive_definite(
            count in 1usize..=32,
            steps in prop::collection::vec(
                (-4f64..0.5, -8f64..4.0, prop::collection::vec(-1f64..1.0, 37), 0.0f64..8.0), 1..40,
            ),
            q_exponent in -2f64..12.0,
            speed_exponent in 0f64..10.0,
        ) {
            let (mut state, mut ahead) = (State::<1>::new(count), State::<1>::new(count));
            let mut work = Rows::new(count, 4 * vectors(count) + 1);
            let measured = vec![[1.0]; count];
            let q = 10f64.powf(q_exponent);
            for (step, (seconds, variance, directions, spread)) in steps.iter().enumerate() {
                let mut diagonal = Rows::square(count);
                let mut turned = Rows::square(count);
                for i in 0..count {
                    let exponent = variance + spread * directions[i].abs();
                    diagonal.set(i, i, 10f64.powf(exponent));
                    for j in 0..count {
                        let one = if i == j { 1.0 } else { 0.0 };
                        turned.set(i, j, one + 0.1 * directions[(5 * i + 3 * j) % 37]);
                    }
                }
                let (mut half, mut noise) = (Rows::square(count), Rows::square(count));
                congruence(&turned, &diagonal, &mut half, &mut noise, count);
                for i in 0..count {
                    noise.add(i, i, 1e-8 + 1e-14 * 10f64.powf(variance + spread));
                }
                if step == 0 {
                    state.begin(&measured, &noise, 10f64.powf(speed_exponent));
                    continue;
                }
                state.propagate(10f64.powf(*seconds), q, &mut ahead);
                prop_assert!(is_positive_definite(&ahead), "predicted, {step}");
                let nis = ahead.measure(&measured, &noise, f64::INFINITY, &mut work);
                prop_assert!(nis.is_ok());
                std::mem::swap(&mut state, &mut ahead);
                prop_assert!(is_positive_definite(&state), "updated, {step}");
            }
        }
    }
}
