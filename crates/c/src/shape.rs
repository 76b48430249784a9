#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! A rope's curve for control laws.

use std::ffi::c_int;
use std::{ptr, slice};

use lariat_wire::{Descriptor, Nearest, Shape};

use crate::error::{Failure, LARIAT_ERROR_NO_DIRECTION, answer};
use crate::message::lariat_descriptor;

/// A rope's C descriptor, with a curve in `D` dimensions.
pub(crate) trait Described<const D: usize> {
    /// Name in the error for NULL.
    const NAME: &'static str;
    fn curve(&self) -> Result<Shape<'_, D>, Failure>;
}

impl Described<2> for lariat_descriptor {
    const NAME: &'static str = "the rope's descriptor";

    fn curve(&self) -> Result<Shape<'_>, Failure> {
        // SAFETY: the layout is the same, as `message` checks, and every bit pattern is valid.
        let descriptor = unsafe { &*ptr::from_ref(self).cast::<Descriptor>() };
        Ok(Shape::of(descriptor)?)
    }
}

/// The curve of a descriptor that may be NULL.
fn curve<'a, R: Described<D> + 'a, const D: usize>(
    rope: *const R,
) -> Result<Shape<'a, D>, Failure> {
    // SAFETY: C passes a descriptor of its own, or one that a reader still holds.
    let rope = unsafe { rope.as_ref() };
    rope.ok_or_else(|| Failure::null(R::NAME))?.curve()
}

/// Space for an answer, filled with NaN until the answer is known.
pub(crate) fn place<'a>(numbers: *mut f64, count: usize) -> Result<&'a mut [f64], Failure> {
    if numbers.is_null() {
        return Err(Failure::null("the place for the answer"));
    }
    // SAFETY: C passes space for as many numbers as the function's comment says, and it is not
    // NULL.
    let place = unsafe { slice::from_raw_parts_mut(numbers, count) };
    place.fill(f64::NAN);
    Ok(place)
}

/// Writes the numbers that `work` computes from the curve, or reports that its derivative vanishes
/// there.
pub(crate) fn evaluate<const N: usize, const D: usize>(
    rope: *const impl Described<D>,
    numbers: *mut f64,
    work: impl FnOnce(&Shape<D>) -> Option<[f64; N]>,
) -> c_int {
    answer(|| {
        let place = place(numbers, N)?;
        let found = work(&curve(rope)?).ok_or_else(|| {
            Failure::new(
                LARIAT_ERROR_NO_DIRECTION,
                "the curve has no direction there: its control points coincide",
            )
        })?;
        place.copy_from_slice(&found);
        Ok(0)
    })
}

/// Writes `count` points of the curve at equal steps.
pub(crate) fn points<const D: usize>(
    rope: *const impl Described<D>,
    count: usize,
    numbers: *mut f64,
) -> c_int {
    answer(|| {
        let place = place(numbers, D * count)?;
        let curve = curve(rope)?;
        for (i, point) in place.chunks_exact_mut(D).enumerate() {
            point.copy_from_slice(&curve.point_at(curve.even_rho(i, count)));
        }
        Ok(0)
    })
}

/// Writes the curve's Jacobian.
pub(crate) fn jacobian<const D: usize>(
    rope: *const impl Described<D>,
    rho: f64,
    values: *mut f64,
) -> c_int {
    answer(|| {
        let jacobian = curve(rope)?.jacobian_at(rho);
        place(values, jacobian.len())?.copy_from_slice(&jacobian);
        Ok(0)
    })
}

/// A nearest point in C's format.
pub(crate) fn numbers(nearest: Nearest) -> [f64; 4] {
    let [x, y] = nearest.point;
    [nearest.rho, x, y, nearest.distance]
}

/// Computes the point of the curve at `rho`. `xy` has room for two numbers.
///
/// This function and all that follow return 0 or an error. On an error the numbers are NaN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_point_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| Some(curve.point_at(rho)))
}

/// Finds the point of the curve nearest to (x, y). `nearest` has room for four numbers: rho, x, y
/// and the distance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_nearest(
    rope: *const lariat_descriptor,
    x: f64,
    y: f64,
    nearest: *mut f64,
) -> c_int {
    evaluate(rope, nearest, |curve| Some(numbers(curve.nearest([x, y]))))
}

/// Computes `count` points of the curve at equal steps of rho, from end to end, or once around a
/// closed curve. `xy` has room for `2 * count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_points(
    rope: *const lariat_descriptor,
    count: usize,
    xy: *mut f64,
) -> c_int {
    points(rope, count, xy)
}

/// Computes the derivative of the curve with respect to rho at `rho`. `xy` has room for two
/// numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_derivative_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| Some(curve.derivative_at(rho)))
}

/// Computes the unit tangent at `rho`. `xy` has room for two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_tangent_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| curve.tangent_at(rho))
}

/// Computes the unit normal at `rho`: the tangent turned from the x axis towards the y axis. `xy`
/// has room for two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_normal_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| curve.normal_at(rho))
}

/// Computes the signed curvature at `rho`: one over the radius, positive if the curve turns towards
/// its normal. `curvature` has room for one number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_curvature_at(
    rope: *const lariat_descriptor,
    rho: f64,
    curvature: *mut f64,
) -> c_int {
    evaluate(rope, curvature, |curve| {
        curve.curvature_at(rho).map(|bend| [bend])
    })
}

/// Computes the Jacobian of the point at `rho` with respect to the control points, the same for x
/// and y. `values` has room for `rope->count` numbers, or for `LARIAT_MAX_CONTROL_POINTS` if
/// another program may write the descriptor meanwhile. It is left unchanged if the rope lacks a
/// curve.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_jacobian_at(
    rope: *const lariat_descriptor,
    rho: f64,
    values: *mut f64,
) -> c_int {
    jacobian(rope, rho, values)
}

/// Computes the covariance of the point at `rho`, in the unit squared. `covariance` has room for
/// three numbers: xx, xy, yy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_covariance_at(
    rope: *const lariat_descriptor,
    rho: f64,
    covariance: *mut f64,
) -> c_int {
    evaluate(rope, covariance, |curve| Some(curve.covariance_at(rho)))
}

/// Computes the joint covariance of all control points, for the vector x0, y0, x1, y1, ..., row by
/// row. `matrix` has room for the square of `2 * rope->count` numbers, or of `2 *
/// LARIAT_MAX_CONTROL_POINTS` if another program may write the descriptor meanwhile.
///
/// Returns 1 if the matrix is exact up to rounding, as for plain least squares with or without a
/// filter. Returns 0 otherwise (ridge, pinned ends, weights, a plane, rational curves): each
/// control point's own covariance is then exact, and the correlations are those of the plain fit.
/// On an error it returns the error and writes nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_covariance(
    rope: *const lariat_descriptor,
    matrix: *mut f64,
) -> c_int {
    answer(|| {
        let covariance = curve(rope)?.covariance();
        covariance.write_to(place(matrix, covariance.size() * covariance.size())?);
        Ok(covariance.is_exact().into())
    })
}
