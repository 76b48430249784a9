#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! A rope's curve in space, for chains with a depth camera.

use std::ffi::c_int;
use std::ptr;
use std::time::Duration;

use lariat_wire::{Descriptor3, Nearest, NoSpace, Seen, Shape, Track};

use crate::error::{Failure, LARIAT_ERROR_NO_ROPE, answer};
use crate::message::lariat_descriptor3;
use crate::reader::{given, lariat_reader, shown};
use crate::rope::lariat_track;
use crate::shape::{Described, evaluate, jacobian, points};

/// Makes the reader also read the shapes in space, for lariat_in_space, from a chain with a depth
/// camera. Up to 12 readers of a rig can do this.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_follow_in_space(reader: *mut lariat_reader) -> c_int {
    answer(|| {
        given(reader)?.reader.follow_in_space()?;
        Ok(0)
    })
}

/// Finds the rope of this track in space, in the last frame read. Its lariat_rope tells whether
/// this is its current position, so check the lariat_rope first. Like the pointers in lariat_rope,
/// `*rope` points into shared memory and is valid as long as they are.
///
/// Returns 0, or an error; *rope is then NULL. If the position is unknown, the error is
/// LARIAT_ERROR_NO_SPACE, and lariat_error says why.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_in_space(
    reader: *const lariat_reader,
    track: lariat_track,
    rope: *mut *const lariat_descriptor3,
) -> c_int {
    answer(|| {
        // SAFETY: C passes space for a pointer, or NULL.
        let place = unsafe { rope.as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the rope in space"))?;
        *place = ptr::null();
        let track = Track::new(track.run, track.number);
        let rope = match shown(reader)?.reader.frame().rope(track, Duration::MAX) {
            Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) => rope,
            Seen::Lost(last) | Seen::Stale(last) => last.as_it_was(),
            Seen::Absent(why) => return Err(Failure::new(LARIAT_ERROR_NO_ROPE, why.to_string())),
        };
        rope.in_space()?;
        // The same layout; `message` checks it.
        *place = ptr::from_ref(rope.descriptor3()?).cast();
        Ok(0)
    })
}

impl Described<3> for lariat_descriptor3 {
    const NAME: &'static str = "the rope's descriptor in space";

    fn curve(&self) -> Result<Shape<'_, 3>, Failure> {
        // SAFETY: the layout is the same, as `message` checks, and every bit pattern is valid.
        let descriptor = unsafe { &*ptr::from_ref(self).cast::<Descriptor3>() };
        Ok(Shape::in_space(descriptor).map_err(NoSpace::NoShape)?)
    }
}

/// Computes the point of the curve at `rho`. `xyz` has room for three numbers.
///
/// This function and all that follow use millimeters and return 0 or an error. On an error the
/// numbers are NaN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_point3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    xyz: *mut f64,
) -> c_int {
    evaluate(rope, xyz, |curve| Some(curve.point_at(rho)))
}

/// Finds the point of the curve nearest to (x, y, z). `nearest` has room for five numbers: rho, x,
/// y, z and the distance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_nearest3(
    rope: *const lariat_descriptor3,
    x: f64,
    y: f64,
    z: f64,
    nearest: *mut f64,
) -> c_int {
    evaluate(rope, nearest, |curve| {
        let Nearest {
            rho,
            point: [x, y, z],
            distance,
            ..
        } = curve.nearest([x, y, z]);
        Some([rho, x, y, z, distance])
    })
}

/// Computes `count` points of the curve at equal steps of rho, from end to end, or once around a
/// closed curve. `xyz` has room for `3 * count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_points3(
    rope: *const lariat_descriptor3,
    count: usize,
    xyz: *mut f64,
) -> c_int {
    points(rope, count, xyz)
}

/// Computes the derivative of the curve with respect to rho at `rho`. `xyz` has room for three
/// numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_derivative3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    xyz: *mut f64,
) -> c_int {
    evaluate(rope, xyz, |curve| Some(curve.derivative_at(rho)))
}

/// Computes the unit tangent at `rho`. `xyz` has room for three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_tangent3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    xyz: *mut f64,
) -> c_int {
    evaluate(rope, xyz, |curve| curve.tangent_at(rho))
}

/// Computes the curvature at `rho` in 1/mm: one over the radius. `curvature` has room for one
/// number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_curvature3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    curvature: *mut f64,
) -> c_int {
    evaluate(rope, curvature, |curve| {
        curve.curvature_at(rho).map(|bend| [bend])
    })
}

/// Computes the Jacobian of the point at `rho` with respect to the control points, the same for x,
/// y and z. `values` has room for `rope->count` numbers, or for `LARIAT_MAX_CONTROL_POINTS` if
/// another program may write the descriptor meanwhile. It is left unchanged if the rope lacks a
/// curve.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_jacobian3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    values: *mut f64,
) -> c_int {
    jacobian(rope, rho, values)
}
