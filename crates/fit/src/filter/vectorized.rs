//! The filter's three tasks, each compiled as a whole for every instruction set.

use super::Prediction;
use super::rows::{Rows, congruence, eliminate};
use super::space::{CurveSpace, transform};
use super::state::State;
use lariat_portable::{Simd, WithSimd};

/// Propagates a state and updates it with a measurement: see [`State::propagate`] and
/// [`State::measure`].
pub(super) struct TakeIn<'a, const D: usize> {
    pub(super) state: &'a State<D>,
    pub(super) seconds: f64,
    pub(super) q: f64,
    pub(super) measured: &'a [[f64; D]],
    pub(super) noise: &'a Rows,
    pub(super) gate: f64,
    pub(super) work: &'a mut Rows,
    /// The result.
    pub(super) later: &'a mut State<D>,
}

impl<const D: usize> WithSimd for TakeIn<'_, D> {
    type Output = Result<f64, f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Result<f64, f64> {
        self.state.propagate(self.seconds, self.q, self.later);
        self.later
            .measure(self.measured, self.noise, self.gate, self.work)
    }
}

/// Propagates a state and writes it as control points.
pub(super) struct Foretell<'a, const D: usize> {
    pub(super) state: &'a State<D>,
    pub(super) seconds: f64,
    pub(super) q: f64,
    pub(super) space: &'a CurveSpace,
    /// Scratch memory for the state and its covariances.
    pub(super) later: &'a mut State<D>,
    pub(super) half: &'a mut Rows,
    pub(super) whole: &'a mut Rows,
    /// The result.
    pub(super) prediction: &'a mut Prediction<D>,
}

impl<const D: usize> WithSimd for Foretell<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (later, prediction) = (self.later, self.prediction);
        self.state.propagate(self.seconds, self.q, later);
        let t = self.space.to_control_points();
        let count = self.space.control_points();
        for (curve, points) in [
            (&later.positions, &mut prediction.control_points),
            (&later.velocities, &mut prediction.velocities_px_s),
        ] {
            points.resize(count, [0.0; D]);
            transform(t, curve, points);
        }
        let velocities = &mut prediction.velocity_covariance_px2_s2;
        for (covariance, numbers) in [
            (&later.of_positions, &mut prediction.covariance_px2),
            (&later.of_velocities, velocities),
        ] {
            congruence(t, covariance, self.half, self.whole, count);
            numbers.resize(count * count, 0.0);
            for (i, row) in numbers.chunks_exact_mut(count).enumerate() {
                row.copy_from_slice(self.whole.numbers(i, count));
            }
        }
    }
}

/// Converts `scale` times a covariance of control points to curve coordinates, and adds `least` to
/// each variance. Returns whether the result is positive definite.
pub(super) struct ReadCovariance<'a> {
    pub(super) covariance: &'a Rows,
    pub(super) space: &'a CurveSpace,
    pub(super) scale: f64,
    pub(super) least: f64,
    pub(super) half: &'a mut Rows,
    pub(super) work: &'a mut Rows,
    /// The result.
    pub(super) noise: &'a mut Rows,
}

impl WithSimd for ReadCovariance<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let (noise, work) = (self.noise, self.work);
        let count = self.space.control_points();
        congruence(
            self.space.to_curve(),
            self.covariance,
            self.half,
            noise,
            count,
        );
        for number in noise.vectors.as_flattened_mut() {
            *number *= self.scale;
        }
        for i in 0..count {
            noise.add(i, i, self.least);
        }
        work.reshape(count, noise.width);
        work.vectors.copy_from_slice(&noise.vectors);
        eliminate(work, count)
    }
}
