#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! What a control law asks of a rope's curve.

use std::ffi::c_int;
use std::{ptr, slice};

use lariat_wire::{Descriptor, Nearest, Shape};

use crate::error::{Failure, LARIAT_ERROR_NO_DIRECTION, answer};
use crate::message::lariat_descriptor;

/// A rope's descriptor as C has it, of a curve in so many dimensions.
pub(crate) trait Described<const D: usize> {
    /// What is missing where it is NULL.
    const NAME: &'static str;
    fn curve(&self) -> Result<Shape<'_, D>, Failure>;
}

impl Described<2> for lariat_descriptor {
    const NAME: &'static str = "the rope's descriptor";

    fn curve(&self) -> Result<Shape<'_>, Failure> {
        // SAFETY: of the same layout as ours, which `message` holds it to, where every bit pattern is a value.
        let descriptor = unsafe { &*ptr::from_ref(self).cast::<Descriptor>() };
        Ok(Shape::of(descriptor)?)
    }
}

/// The curve of a descriptor that may be NULL.
fn curve<'a, R: Described<D> + 'a, const D: usize>(
    rope: *const R,
) -> Result<Shape<'a, D>, Failure> {
    // SAFETY: C gives a descriptor of its own, or one that a reader still holds.
    let rope = unsafe { rope.as_ref() };
    rope.ok_or_else(|| Failure::null(R::NAME))?.curve()
}

/// The place for an answer, filled with NaN until there is one.
pub(crate) fn place<'a>(numbers: *mut f64, count: usize) -> Result<&'a mut [f64], Failure> {
    if numbers.is_null() {
        return Err(Failure::null("the place for the answer"));
    }
    // SAFETY: C gives room for as many numbers as the function's comment says; NULL was told from it.
    let place = unsafe { slice::from_raw_parts_mut(numbers, count) };
    place.fill(f64::NAN);
    Ok(place)
}

/// Writes the numbers that `work` finds of the curve, if that does not stand still where it was asked.
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
                "the curve stands still there, and has no direction: its control points lie one upon the other",
            )
        })?;
        place.copy_from_slice(&found);
        Ok(0)
    })
}

/// Writes `count` points of the curve at even steps.
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

/// A nearest point as C has it.
pub(crate) fn numbers(nearest: Nearest) -> [f64; 4] {
    let [x, y] = nearest.point;
    [nearest.rho, x, y, nearest.distance]
}

/// The point of the curve at `rho`: `xy` is two numbers.
///
/// This and all that follow return 0, or an error; the answer is NaN then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_point_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| Some(curve.point_at(rho)))
}

/// The point of the curve that is nearest to (x, y): `nearest` is four numbers, its rho, its x and y, and how far it is away.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_nearest(
    rope: *const lariat_descriptor,
    x: f64,
    y: f64,
    nearest: *mut f64,
) -> c_int {
    evaluate(rope, nearest, |curve| Some(numbers(curve.nearest([x, y]))))
}

/// `count` points of the curve at even steps of rho, from its first end to its last, or once around a closed one: `xy` is
/// `2 * count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_points(
    rope: *const lariat_descriptor,
    count: usize,
    xy: *mut f64,
) -> c_int {
    points(rope, count, xy)
}

/// The velocity by rho at `rho`: `xy` is two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_derivative_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| Some(curve.derivative_at(rho)))
}

/// The direction in which the curve goes at `rho`, of length 1: `xy` is two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_tangent_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| curve.tangent_at(rho))
}

/// The direction across it, the tangent turned from the x axis towards the y axis: `xy` is two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_normal_at(
    rope: *const lariat_descriptor,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(rope, xy, |curve| curve.normal_at(rho))
}

/// One by the radius of the circle that the curve follows at `rho`, positive where it turns towards its normal: one number.
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

/// How much the point at `rho` moves with each control point, the same for x and y: `values` is `rope->count` numbers (give room
/// for `LARIAT_MAX_CONTROL_POINTS` if another program may write the descriptor meanwhile). Of a rope without a curve they are not
/// written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_jacobian_at(
    rope: *const lariat_descriptor,
    rho: f64,
    values: *mut f64,
) -> c_int {
    jacobian(rope, rho, values)
}

/// How uncertain the point at `rho` is, in the unit's square: `covariance` is three numbers, xx, xy, yy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_covariance_at(
    rope: *const lariat_descriptor,
    rho: f64,
    covariance: *mut f64,
) -> c_int {
    evaluate(rope, covariance, |curve| Some(curve.covariance_at(rho)))
}

/// How uncertain all control points are together: of the vector x0, y0, x1, y1, ..., row by row; `matrix` is the square of
/// `2 * rope->count` numbers (give room for `2 * LARIAT_MAX_CONTROL_POINTS` if another program may write the descriptor meanwhile).
///
/// Returns 1 if it is that of plain least squares or of its filter, and so right to rounding; 0 if not (ridge, pinned ends,
/// weights, a plane, rational curves): then each control point's own is right, and how two of them hang together is that of the
/// plain fit. Or an error; the answer is then not written.
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
