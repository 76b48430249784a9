#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! A rope's curve in space, where the chain has a depth camera.

use std::ffi::c_int;
use std::ptr;
use std::time::Duration;

use lariat_wire::{Descriptor3, Nearest, NoSpace, Seen, Shape, Track};

use crate::error::{Failure, LARIAT_ERROR_NO_ROPE, answer};
use crate::message::lariat_descriptor3;
use crate::reader::{given, lariat_reader, shown};
use crate::rope::lariat_track;
use crate::shape::{Described, evaluate, jacobian, points};

/// Reads where ropes are in space, too, for lariat_in_space: of a chain with a depth camera. Up to 12 readers of a rig do.
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

/// Where the rope of this track is in space, in the frame that was looked at last. Whether that is where it is now stands in its
/// lariat_rope: ask what is known of it first. `*rope` points into shared memory, as the lariat_rope does, and stays as long.
///
/// Returns 0, or an error: LARIAT_ERROR_NO_SPACE where it is not known, with the reason; *rope is then NULL.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_in_space(
    reader: *const lariat_reader,
    track: lariat_track,
    rope: *mut *const lariat_descriptor3,
) -> c_int {
    answer(|| {
        // SAFETY: C gives a place for a pointer, or NULL.
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
        // The same layout, which `message` holds it to.
        *place = ptr::from_ref(rope.descriptor3()?).cast();
        Ok(0)
    })
}

impl Described<3> for lariat_descriptor3 {
    const NAME: &'static str = "the rope's descriptor in space";

    fn curve(&self) -> Result<Shape<'_, 3>, Failure> {
        // SAFETY: of the same layout as ours, which `message` holds it to, where every bit pattern is a value.
        let descriptor = unsafe { &*ptr::from_ref(self).cast::<Descriptor3>() };
        Ok(Shape::in_space(descriptor).map_err(NoSpace::NoShape)?)
    }
}

/// The point of the curve at `rho`: `xyz` is three numbers.
///
/// This and all that follow are in millimetres, and return 0, or an error; the answer is NaN then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_point3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    xyz: *mut f64,
) -> c_int {
    evaluate(rope, xyz, |curve| Some(curve.point_at(rho)))
}

/// The point of the curve that is nearest to (x, y, z): `nearest` is five numbers, its rho, its x, y and z, and how far it is away.
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

/// `count` points of the curve at even steps of rho, from its first end to its last, or once around a closed one: `xyz` is
/// `3 * count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_points3(
    rope: *const lariat_descriptor3,
    count: usize,
    xyz: *mut f64,
) -> c_int {
    points(rope, count, xyz)
}

/// The velocity by rho at `rho`: `xyz` is three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_derivative3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    xyz: *mut f64,
) -> c_int {
    evaluate(rope, xyz, |curve| Some(curve.derivative_at(rho)))
}

/// The direction in which the curve goes at `rho`, of length 1: `xyz` is three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_tangent3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    xyz: *mut f64,
) -> c_int {
    evaluate(rope, xyz, |curve| curve.tangent_at(rho))
}

/// One by the radius of the circle that the curve follows at `rho`, in 1/mm: one number.
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

/// How much the point at `rho` moves with each control point, the same for x, y and z: `values` is `rope->count` numbers (give room
/// for `LARIAT_MAX_CONTROL_POINTS` if another program may write the descriptor meanwhile). Of a rope without a curve they are not
/// written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_jacobian3_at(
    rope: *const lariat_descriptor3,
    rho: f64,
    values: *mut f64,
) -> c_int {
    jacobian(rope, rho, values)
}
