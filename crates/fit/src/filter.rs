//! Filters the shape of a rope over time: a constant-velocity Kalman filter on its control points.
//! It estimates position, velocity and their uncertainty at any time near the last shape.
//!
//! The state of each axis is `m` control points and their velocities. Between shapes they move by
//! white acceleration (Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and
//! Navigation*, 6.2.2, the continuous white noise acceleration model). A shape is a measurement of
//! the control points with the covariance of its fit. This covariance is the same for each axis, so
//! all axes share one state covariance.
//!
//! **Acceleration acts on the curve**, not on the control points: white acceleration of equal
//! strength in every direction of the space of curves, `Q ∝ (BᵀB)⁻¹`. With equal strength for each
//! control point (`Q ∝ I`), the result would depend on the basis. A change of shape that moves
//! control points far outside the curve by a hundred pixels, but the curve by only one, would
//! appear a hundred times less likely than any other. The filter would be more confident of the
//! curve than the measurement is, lag behind the change, and treat it as a jump. In the curve's
//! space, a fit of evenly weighted points also has `R ∝ (BᵀB)⁻¹`. Every change of shape is then
//! smoothed with the same gain, that of a filter for one point, and none lags behind another. A
//! part that is hidden in one shape continues with the velocity observed before.
//!
//! **Numerical accuracy.** All computations use curve coordinates ([`CurveSpace`]), where `Q` and
//! the usual `R` are multiples of the identity. In control points, the condition number of `Q` and
//! `R` is the square of `B`'s (2·10⁴ at order 8, far more at higher orders), and rounding would
//! dominate a prediction.

mod error;
mod options;
mod rows;
mod space;
mod state;
mod step;
mod vectorized;

pub use error::{CurveSpaceError, FilterError, PredictError, UpdateError};
pub use options::FilterOptions;
pub use space::CurveSpace;
pub use step::{FilterStep, Noise};

use crate::point::Point;
use rows::{LANES, Rows};
use space::transform;
use state::State;
use vectorized::{Foretell, ReadCovariance, TakeIn};

/// Control points of this size or larger are refused. The control points of a curve in the picture
/// may be far outside it. At high orders, they are farther by a factor of up to the condition
/// number of `B`.
const MAX_CONTROL_POINT_PX: f64 = 1e12;

/// Variances and covariances above this are refused. A direction with this variance is unknown,
/// whatever the size of the picture.
const MAX_VARIANCE_PX2: f64 = 1e18;

/// Minimum uncertainty of a shape, px. Points are transmitted as `f32`, whose step is 0.0005 px at
/// the far side of a large image, and a coordinate is a mean of several of them. This keeps a
/// covariance of zero (as many control points as points) positive definite.
const LEAST_NOISE_PX: f64 = 1e-4;

/// Maximum condition number of `B` at which a covariance is accurate enough. In curve coordinates,
/// its rounding errors grow by the square of that number. They may reach a hundredth of the
/// variances there.
fn covariance_limit() -> f64 {
    (0.01 / f64::EPSILON).sqrt()
}

/// Position and velocity of a rope at a time, with covariances.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Prediction<const D: usize> {
    /// The time, ns.
    pub t_ns: u64,
    /// The `m` control points, px.
    pub control_points: Vec<[f64; D]>,
    /// Their velocities, px/s: the control points of the curve of velocities.
    pub velocities_px_s: Vec<[f64; D]>,
    /// Covariance of the control points, the same for each axis: `m` × `m`, row by row, px².
    pub covariance_px2: Vec<f64>,
    /// Covariance of the velocities, in the same layout, px²/s².
    pub velocity_covariance_px2_s2: Vec<f64>,
}

/// The last shape used.
struct LastShape {
    t_ns: u64,
    space: CurveSpace,
    /// Largest normalized innovation squared that is not a jump.
    gate: f64,
}

/// A constant-velocity Kalman filter on the control points of one rope, in `D` dimensions.
///
/// ```
/// use lariat_fit::{CurveSpace, Filter, FilterOptions, Noise};
///
/// // A rope of two control points, its ends, that moves to the right at 100 px/s.
/// let space = CurveSpace::of_points(2)?;
/// let mut filter = Filter::<2>::new(2, FilterOptions::default())?;
/// for frame in 0..30 {
///     let x = frame as f64;
///     let noise = Noise::Even { variance_px2: 0.01 };
///     filter.update(frame * 10_000_000, &space, &[[x, 0.0], [x, 50.0]], noise)?;
/// }
/// let soon = filter.predict(300_000_000)?;
/// assert!((soon.control_points[1][0] - 30.0).abs() < 0.1);
/// assert!((soon.velocities_px_s[0][0] - 100.0).abs() < 10.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Filter<const D: usize> {
    options: FilterOptions,
    most: usize,
    arch: lariat_portable::Arch,
    seen: Option<LastShape>,
    state: State<D>,
    /// Scratch state at another time.
    ahead: State<D>,
    measured: Vec<[f64; D]>,
    noise: Rows,
    /// Scratch memory for a covariance in other coordinates, and for the intermediate product.
    other: Rows,
    half: Rows,
    work: Rows,
    prediction: Prediction<D>,
}

impl<const D: usize> Filter<D>
where
    [f64; D]: Point<D>,
{
    /// Creates a filter for shapes of at most `max_control_points` control points. It does not
    /// allocate afterwards.
    ///
    /// # Errors
    /// Fails for 0 or more than 32 control points, or if an option is out of its range.
    pub fn new(max_control_points: usize, options: FilterOptions) -> Result<Self, FilterError> {
        <[f64; D]>::make_filter(max_control_points, options)
    }

    /// Updates the filter with a shape: the control points at time `t_ns`, of curves in `space`,
    /// with the uncertainty `noise`. Returns whether the shape continued the previous ones or
    /// restarted the filter. Spaces are compared by identity: pass the same one, or clones of it,
    /// as long as the curves are the same.
    ///
    /// # Errors
    /// Fails if the time is not after the last one, if sizes disagree, or if numbers are not valid
    /// positions or covariances. The filter is then unchanged.
    pub fn update(
        &mut self,
        t_ns: u64,
        space: &CurveSpace,
        control_points: &[[f64; D]],
        noise: Noise<'_>,
    ) -> Result<FilterStep, UpdateError> {
        <[f64; D]>::take_in(self, t_ns, space, control_points, noise)
    }

    /// Predicts the rope at time `t_ns`: at the time of the last shape, after it, or a little
    /// before it. The result is valid until the next call.
    ///
    /// For a time before the last shape, the acceleration between the two times is treated as
    /// unknown, although later shapes contain information about it. The covariance is therefore
    /// conservative.
    ///
    /// # Errors
    /// Fails before the first shape, or if the time differs from the last one by more than
    /// [`FilterOptions::longest_gap_s`].
    pub fn predict(&mut self, t_ns: u64) -> Result<&Prediction<D>, PredictError> {
        <[f64; D]>::foretell(self, t_ns)
    }
}

impl<const D: usize> Filter<D> {
    /// Implements [`Filter::new`].
    pub(crate) fn make(
        max_control_points: usize,
        options: FilterOptions,
    ) -> Result<Self, FilterError> {
        let most = max_control_points;
        if !(1..=crate::options::MAX_ORDER + 1).contains(&most) {
            return Err(FilterError::ControlPoints { given: most });
        }
        options.check()?;
        let work_width = 4 * rows::vectors(most) + rows::vectors(D);
        Ok(Self {
            options,
            most,
            arch: lariat_portable::Arch::new(),
            seen: None,
            state: State::new(most),
            ahead: State::new(most),
            measured: vec![[0.0; D]; most],
            noise: Rows::square(most),
            other: Rows::square(most),
            half: Rows::square(most),
            work: Rows::new(most, work_width),
            prediction: Prediction {
                t_ns: 0,
                control_points: vec![[0.0; D]; most],
                velocities_px_s: vec![[0.0; D]; most],
                covariance_px2: vec![0.0; most * most],
                velocity_covariance_px2_s2: vec![0.0; most * most],
            },
        })
    }

    /// The options of the filter.
    pub fn options(&self) -> &FilterOptions {
        &self.options
    }

    /// Time of the last shape used, ns.
    pub fn last_ns(&self) -> Option<u64> {
        self.seen.as_ref().map(|seen| seen.t_ns)
    }

    /// Forgets the rope. The next shape is the first.
    pub fn forget(&mut self) {
        self.seen = None;
    }

    /// Implements [`Filter::update`].
    pub(crate) fn take_in(
        &mut self,
        t_ns: u64,
        space: &CurveSpace,
        control_points: &[[f64; D]],
        noise: Noise<'_>,
    ) -> Result<FilterStep, UpdateError> {
        self.check(t_ns, space, control_points)?;
        self.write_noise(space, noise)?;
        self.measured.resize(control_points.len(), [0.0; D]);
        transform(space.to_curve(), control_points, &mut self.measured);
        let step = match &self.seen {
            None => FilterStep::Began,
            Some(seen) if !seen.space.is(space) => FilterStep::OtherCurves,
            Some(seen) => {
                let seconds = (t_ns - seen.t_ns) as f64 * 1e-9;
                if seconds > self.options.longest_gap_s {
                    FilterStep::LongGap { seconds }
                } else {
                    let gate = seen.gate;
                    self.go_on(seconds, gate)
                }
            }
        };
        match &mut self.seen {
            Some(seen) if seen.space.is(space) => seen.t_ns = t_ns,
            seen => {
                *seen = Some(LastShape {
                    t_ns,
                    space: space.clone(),
                    gate: self.options.gate(control_points.len() * D),
                });
            }
        }
        if step.is_beginning() {
            let speed_variance = self.options.speed_px_s.powi(2);
            self.state
                .begin(&self.measured, &self.noise, speed_variance);
        }
        Ok(step)
    }

    /// Implements [`Filter::predict`].
    pub(crate) fn foretell(&mut self, t_ns: u64) -> Result<&Prediction<D>, PredictError> {
        let seen = self.seen.as_ref().ok_or(PredictError::NothingSeen)?;
        let distance_s = t_ns.abs_diff(seen.t_ns) as f64 * 1e-9;
        if distance_s > self.options.longest_gap_s {
            return Err(PredictError::TooFar {
                t_ns,
                distance_s,
                limit_s: self.options.longest_gap_s,
            });
        }
        let seconds = distance_s * if t_ns < seen.t_ns { -1.0 } else { 1.0 };
        self.prediction.t_ns = t_ns;
        self.arch.dispatch(Foretell {
            state: &self.state,
            seconds,
            q: self.options.spectral_density(),
            space: &seen.space,
            later: &mut self.ahead,
            half: &mut self.half,
            whole: &mut self.other,
            prediction: &mut self.prediction,
        });
        Ok(&self.prediction)
    }

    /// Predicts and applies the measurement, or leaves the state unchanged if the measurement is
    /// beyond the gate.
    fn go_on(&mut self, seconds: f64, gate: f64) -> FilterStep {
        let nis = self.arch.dispatch(TakeIn {
            state: &self.state,
            seconds,
            q: self.options.spectral_density(),
            measured: &self.measured,
            noise: &self.noise,
            gate,
            work: &mut self.work,
            later: &mut self.ahead,
        });
        match nis {
            Ok(nis) => {
                std::mem::swap(&mut self.state, &mut self.ahead);
                FilterStep::Updated { nis }
            }
            Err(nis) => FilterStep::Jumped { nis },
        }
    }

    /// Checks whether the shape can be used at all.
    fn check(
        &self,
        t_ns: u64,
        space: &CurveSpace,
        control_points: &[[f64; D]],
    ) -> Result<(), UpdateError> {
        if let Some(last_ns) = self.last_ns().filter(|&last_ns| t_ns <= last_ns) {
            return Err(UpdateError::NotLater { t_ns, last_ns });
        }
        let given = control_points.len();
        if given != space.control_points() {
            return Err(UpdateError::Count {
                given,
                expected: space.control_points(),
            });
        }
        if given > self.most {
            return Err(UpdateError::TooMany {
                given,
                most: self.most,
            });
        }
        let placed = |p: &[f64; D]| p.iter().all(|c| c.abs() < MAX_CONTROL_POINT_PX);
        match control_points.iter().position(|p| !placed(p)) {
            Some(index) => Err(UpdateError::NotAPoint {
                index,
                limit: MAX_CONTROL_POINT_PX,
            }),
            None => Ok(()),
        }
    }

    /// Writes the measurement's covariance in curve coordinates to `self.noise`, positive definite.
    fn write_noise(&mut self, space: &CurveSpace, noise: Noise<'_>) -> Result<(), UpdateError> {
        let count = space.control_points();
        let scale = self.options.noise_scale.powi(2);
        let least = LEAST_NOISE_PX * LEAST_NOISE_PX;
        match noise {
            Noise::Even { variance_px2 } => {
                check_variance(variance_px2, true)?;
                self.noise.reshape(count, rows::vectors(count));
                let variance = scale * variance_px2 * space.unit_variance() + least;
                for i in 0..count {
                    self.noise.set(i, i, variance);
                }
            }
            Noise::Covariance(covariance) => {
                self.read_covariance(space, covariance)?;
                let trace = covariance.iter().step_by(count + 1).sum::<f64>();
                // Rounding errors of the covariance limit its accuracy.
                let least = least + scale * space.rounding(trace);
                let positive = self.arch.dispatch(ReadCovariance {
                    covariance: &self.other,
                    space,
                    scale,
                    least,
                    half: &mut self.half,
                    work: &mut self.work,
                    noise: &mut self.noise,
                });
                if !positive {
                    return Err(UpdateError::NotPositive);
                }
            }
        }
        Ok(())
    }

    /// Copies a covariance of control points to `self.other`, if its numbers are valid.
    fn read_covariance(
        &mut self,
        space: &CurveSpace,
        covariance: &[f64],
    ) -> Result<(), UpdateError> {
        let count = space.control_points();
        if covariance.len() != count * count {
            return Err(UpdateError::CovarianceSize {
                given: covariance.len(),
                control_points: count,
            });
        }
        if space.condition() > covariance_limit() {
            return Err(UpdateError::LostInRounding {
                condition: space.condition(),
                limit: covariance_limit(),
            });
        }
        self.other.reshape(count, rows::vectors(count));
        for (i, row) in covariance.chunks_exact(count).enumerate() {
            for (j, &value) in row.iter().enumerate() {
                check_variance(value, i == j)?;
            }
            let start = i * self.other.width * LANES;
            let numbers = self.other.vectors.as_flattened_mut();
            numbers[start..start + count].copy_from_slice(row);
        }
        Ok(())
    }
}

fn check_variance(value: f64, is_variance: bool) -> Result<(), UpdateError> {
    let least = if is_variance { 0.0 } else { -MAX_VARIANCE_PX2 };
    // Also rejects NaN.
    if (least..=MAX_VARIANCE_PX2).contains(&value) {
        return Ok(());
    }
    Err(UpdateError::NotAVariance {
        value,
        limit: MAX_VARIANCE_PX2,
    })
}
