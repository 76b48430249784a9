#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! The points that a rope's curve was fitted to.

use std::ffi::c_int;
use std::ptr;

use lariat_wire::{Centerline, CenterlinePoints, Descriptor};

use crate::error::{Failure, LARIAT_ERROR_UNREADABLE, answer};
use crate::message::{lariat_centerline, lariat_descriptor};
use crate::reader::{lariat_reader, shown};
use crate::shape::{numbers, place};

/// Returns the centerline of a rope of the last frame read. `rope` is `fresh`, `partial`, `unsure`
/// or `last_known`, or one of the message's own. The centerline is valid as long as the rope is.
///
/// Returns NULL if the rope is NULL or not of that frame, or if the writer sends no points (lariat
/// run always does).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_centerline_of(
    reader: *const lariat_reader,
    rope: *const lariat_descriptor,
) -> *const lariat_centerline {
    let shown = shown(reader).ok();
    let Some(message) = shown.and_then(|shown| shown.reader.frame().message()) else {
        return ptr::null();
    };
    let rope: *const Descriptor = rope.cast();
    let mut pairs = message.curves().iter().zip(message.centerlines());
    let found = pairs.find(|(curve, points)| ptr::eq(*curve, rope) && points.count > 0);
    // The same layout; `message` checks it.
    found.map_or(ptr::null(), |(_, points)| ptr::from_ref(points).cast())
}

/// Writes the numbers that `work` computes from the line.
fn evaluate<const N: usize>(
    line: *const lariat_centerline,
    answered: *mut f64,
    work: impl FnOnce(Centerline) -> [f64; N],
) -> c_int {
    answer(|| {
        let place = place(answered, N)?;
        // SAFETY: C passes a centerline of its own, or one that a reader still holds. Its layout is
        // the same, as `message` checks, and every bit pattern is valid.
        let points = unsafe { line.cast::<CenterlinePoints>().as_ref() };
        let points = points.ok_or_else(|| Failure::null("the centerline"))?;
        let line = Centerline::of(points)
            .ok_or_else(|| Failure::new(LARIAT_ERROR_UNREADABLE, "the centerline has no points"))?;
        place.copy_from_slice(&work(line));
        Ok(0)
    })
}

/// Computes the point of the centerline at `rho`, on the straight line between its two neighbors.
/// `xy` has room for two numbers.
///
/// This function and the next return 0 or an error. On an error the numbers are NaN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_centerline_point_at(
    line: *const lariat_centerline,
    rho: f64,
    xy: *mut f64,
) -> c_int {
    evaluate(line, xy, |line| line.point_at(rho))
}

/// Finds the point of the centerline nearest to (x, y). `nearest` has room for four numbers: rho,
/// x, y and the distance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_centerline_nearest(
    line: *const lariat_centerline,
    x: f64,
    y: f64,
    nearest: *mut f64,
) -> c_int {
    evaluate(line, nearest, |line| numbers(line.nearest([x, y])))
}
