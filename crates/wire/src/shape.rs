//! A rope's curve for control laws: its points, tangents and curvature, their Jacobians with
//! respect to the control points, and their covariance.

mod covariance;
mod form;
mod growth;
mod inverse;
mod nearest;
mod rows;

pub use covariance::Covariance;
pub use form::NoShape;
pub(crate) use growth::Growth;
pub use nearest::Nearest;

use std::hint::black_box;
use std::ops::Deref;

use crate::{Descriptor, Descriptor3, MAX_CONTROL_POINTS, Place};
use form::{Form, Functions};
use inverse::Inverse;

/// The curve of a descriptor: `f(ρ)` in the message's unit, with ρ from 0 at the rope's first end
/// to 1 at its last.
///
/// It reads the descriptor in place and does not allocate. Outside 0 to 1, polynomials are
/// extrapolated, B-splines by their first and last pieces, and a Fourier series repeats.
///
/// ```
/// use lariat_wire::{Descriptor, Shape};
///
/// let mut rope = Descriptor::EMPTY;
/// (rope.degree, rope.count, rope.samples) = (2, 3, 120);
/// rope.control_points[..3].copy_from_slice(&[[0.0, 0.0], [50.0, 100.0], [100.0, 0.0]]);
/// let shape = Shape::of(&rope)?;
/// assert_eq!(shape.point_at(0.5), [50.0, 50.0]);
/// assert_eq!(shape.tangent_at(0.5), Some([1.0, 0.0]));
/// # Ok::<(), lariat_wire::NoShape>(())
/// ```
///
/// The curve of a rope in space is a `Shape<3>`, made by [`Shape::in_space`].
#[derive(Debug, Clone, Copy)]
pub struct Shape<'a, const D: usize = 2> {
    form: Form<'a>,
    control_points: &'a [[f64; D]],
    /// Upper triangle of each control point's symmetric covariance, row by row.
    covariances: &'a [f64],
    /// N, the number of fitted points.
    samples: usize,
    closed: bool,
}

impl<'a> Shape<'a, 2> {
    /// The curve of this descriptor.
    ///
    /// # Errors
    /// The descriptor has points or a center instead of a curve, or its numbers are inconsistent.
    pub fn of(descriptor: &'a Descriptor) -> Result<Self, NoShape> {
        // Read once, because a faulty writer may change shared memory at any time.
        let [count, samples] =
            [&descriptor.count, &descriptor.samples].map(|number| *black_box(number) as usize);
        let functions = Functions {
            basis: descriptor.basis(),
            degree: descriptor.degree as usize,
            weights: &descriptor.weights,
            knots: &descriptor.knots,
        };
        let covariances = descriptor.covariances.as_flattened();
        Self::made_of(
            functions,
            &descriptor.control_points,
            covariances,
            [count, samples],
        )
    }

    /// A shape with the same basis functions, but with these control points (the same number) and
    /// their covariances.
    pub(crate) fn moved(self, control_points: &'a [[f64; 2]], covariances: &'a [[f64; 3]]) -> Self {
        Self {
            control_points,
            covariances: covariances.as_flattened(),
            ..self
        }
    }

    /// Unit normal of the curve at `rho`: the tangent turned from the x axis towards the y axis. In
    /// an image, where y points down, it points to the right of the direction of travel. `None` if
    /// the tangent is undefined.
    pub fn normal_at(&self, rho: f64) -> Option<[f64; 2]> {
        self.tangent_at(rho).map(|[x, y]| [-y, x])
    }

    /// Signed curvature at `rho`: one over the radius, positive if the curve turns towards its
    /// [normal](Self::normal_at). `None` where the derivative vanishes.
    pub fn curvature_at(&self, rho: f64) -> Option<f64> {
        let [_, velocity, acceleration] = self.jet(rho);
        let speed = norm(velocity);
        let turning = velocity[0] * acceleration[1] - velocity[1] * acceleration[0];
        (speed > self.rounding()).then(|| turning / speed.powi(3))
    }

    /// Joint covariance of all control points.
    pub fn covariance(&self) -> Covariance<'a> {
        Covariance::of(*self)
    }

    /// Covariance of the point at `rho`: `[xx, xy, yy]`, in the unit squared.
    /// [`Covariance::is_exact`] tells whether it is exact.
    pub fn covariance_at(&self, rho: f64) -> [f64; 3] {
        self.covariance().of_point(rho)
    }
}

impl<'a> Shape<'a, 3> {
    /// The curve of a rope in space.
    ///
    /// # Errors
    /// The rope's position in space is unknown, or the descriptor is invalid as for [`Shape::of`].
    pub fn in_space(descriptor: &'a Descriptor3) -> Result<Self, NoShape> {
        // Read once, as in [`Shape::of`].
        let [count, samples] =
            [&descriptor.count, &descriptor.samples].map(|number| *black_box(number) as usize);
        let place = descriptor.place().ok_or(NoShape::Unreadable)?;
        if !matches!(place, Place::Known | Place::Before) || count == 0 {
            return Err(NoShape::Nowhere(place));
        }
        let functions = Functions {
            basis: descriptor.basis(),
            degree: descriptor.degree as usize,
            weights: &descriptor.weights,
            knots: &descriptor.knots,
        };
        let covariances = descriptor.covariances.as_flattened();
        Self::made_of(
            functions,
            &descriptor.control_points,
            covariances,
            [count, samples],
        )
    }

    /// Curvature at `rho`, 1/mm. `None` where the derivative vanishes.
    pub fn curvature_at(&self, rho: f64) -> Option<f64> {
        let [_, v, a] = self.jet(rho);
        let speed = norm(v);
        let turning = [1, 2, 0].map(|i| {
            let j = (i + 1) % 3;
            v[i] * a[j] - v[j] * a[i]
        });
        (speed > self.rounding()).then(|| norm(turning) / speed.powi(3))
    }
}

impl<'a, const D: usize> Shape<'a, D> {
    /// Creates a shape of `count` control points, fitted to `samples` points, from the whole arrays
    /// of a descriptor.
    fn made_of(
        functions: Functions<'a>,
        control_points: &'a [[f64; D]; MAX_CONTROL_POINTS],
        covariances: &'a [f64],
        [count, samples]: [usize; 2],
    ) -> Result<Self, NoShape> {
        let form = Form::of(functions, control_points, count, samples)?;
        let each = covariances.len() / MAX_CONTROL_POINTS;
        Ok(Self {
            form,
            control_points: &control_points[..count],
            covariances: &covariances[..count * each],
            samples,
            closed: matches!(form, Form::Fourier),
        })
    }

    /// The control points; for a closed rope, the coefficients of its Fourier series.
    pub fn control_points(&self) -> &'a [[f64; D]] {
        self.control_points
    }

    /// Returns whether the curve is closed.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The point at `rho`.
    pub fn point_at(&self, rho: f64) -> [f64; D] {
        let [point] = self.jet(rho);
        point
    }

    /// The nearest point of the curve to `point`, for ρ from 0 to 1.
    pub fn nearest(&self, point: [f64; D]) -> Nearest<D> {
        nearest::nearest(self, point)
    }

    /// `N` points of the curve at equal steps of ρ: from end to end, or once around a closed curve.
    pub fn points<const N: usize>(&self) -> [[f64; D]; N] {
        std::array::from_fn(|i| self.point_at(self.even_rho(i, N)))
    }

    /// The `i`-th of `count` equally spaced values of ρ: from 0 to 1, or from 0 to one step before
    /// 1 on a closed curve.
    pub fn even_rho(&self, i: usize, count: usize) -> f64 {
        match count {
            _ if self.closed => i as f64 / count as f64,
            0 | 1 => 0.0,
            _ => i as f64 / (count - 1) as f64,
        }
    }

    /// The derivative with respect to ρ at `rho`: `f′(ρ)`.
    pub fn derivative_at(&self, rho: f64) -> [f64; D] {
        let [_, velocity] = self.jet(rho);
        velocity
    }

    /// Unit tangent at `rho`. If the derivative vanishes, as in a cusp or with coincident control
    /// points, it is the direction in which the curve continues or, at its end, arrives. `None` if
    /// the curve is a point.
    pub fn tangent_at(&self, rho: f64) -> Option<[f64; D]> {
        let [_, velocity, acceleration] = self.jet(rho);
        let still = self.rounding();
        let speed = norm(velocity);
        if speed > still {
            return Some(velocity.map(|c| c / speed));
        }
        let turn = norm(acceleration);
        let sign = if rho >= 1.0 && !self.closed {
            -1.0
        } else {
            1.0
        };
        (turn > 2.0 * self.rate() * still).then(|| acceleration.map(|c| sign * c / turn))
    }

    /// Jacobian of the point at `rho` with respect to the control points: `∂f(ρ)/∂sⱼ`, one number
    /// per control point, the same for every axis. If the control points move by `ds`, the point
    /// moves by `Σⱼ Jⱼ dsⱼ`.
    pub fn jacobian_at(&self, rho: f64) -> Jacobian {
        let [values] = self.rows(rho);
        Jacobian {
            values,
            count: self.control_points.len(),
        }
    }

    fn rows<const K: usize>(&self, rho: f64) -> rows::Rows<K> {
        rows::rows(&self.form, self.control_points.len(), rho)
    }

    /// The point and its derivatives with respect to ρ.
    fn jet<const K: usize>(&self, rho: f64) -> [[f64; D]; K] {
        self.rows::<K>(rho).map(|row| {
            let mut sum = [0.0; D];
            for (value, point) in row.iter().zip(self.control_points) {
                for (sum, c) in sum.iter_mut().zip(point) {
                    *sum += value * c;
                }
            }
            sum
        })
    }

    /// Bound on the rounding error of a derivative.
    fn rounding(&self) -> f64 {
        let largest = self.control_points.iter().flatten();
        let largest = largest.fold(0.0f64, |size, c| size.max(c.abs()));
        let count = self.control_points.len() as f64;
        16.0 * f64::EPSILON * count * self.rate() * largest
    }

    /// Bound on the ratio of a derivative with respect to ρ to the size of the curve.
    fn rate(&self) -> f64 {
        let count = self.control_points.len() as f64;
        match self.form {
            Form::Bezier | Form::Rational { .. } => count,
            Form::Fourier => count * std::f64::consts::PI,
            Form::BSpline { degree, inner } => {
                let ends = [0.0].iter().chain(inner).zip(inner.iter().chain(&[1.0]));
                let pieces = ends.map(|(from, to)| to - from).filter(|l| *l > 0.0);
                degree as f64 / pieces.fold(1.0, f64::min)
            }
        }
    }
}

/// Jacobian of a point of a curve with respect to its control points: one number for each of them.
#[derive(Debug, Clone, Copy)]
pub struct Jacobian {
    values: [f64; MAX_CONTROL_POINTS],
    count: usize,
}

impl Deref for Jacobian {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

fn norm<const D: usize>(v: [f64; D]) -> f64 {
    v.iter().fold(0.0, |norm: f64, &c| norm.hypot(c))
}
