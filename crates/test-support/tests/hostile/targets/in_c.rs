#![allow(unsafe_code)] // The functions of the C interface are called as C calls them.
//! All queries that a control loop in C or C++ may make, through the functions that `lariat.h`
//! declares. The buffers are as large as the header says, and nothing is written beyond them.

use std::ffi::{CString, c_int};
use std::ptr;
use std::sync::Mutex;

use lariat::{
    LARIAT_ERROR_FAULT, LARIAT_MAX_CONTROL_POINTS, LARIAT_MAX_ROPES, lariat_accept_coarse,
    lariat_age_ns, lariat_centerline, lariat_centerline_nearest, lariat_centerline_of,
    lariat_centerline_point_at, lariat_close, lariat_covariance, lariat_covariance_at,
    lariat_curvature_at, lariat_derivative_at, lariat_descriptor, lariat_error, lariat_jacobian_at,
    lariat_latest, lariat_message, lariat_nearest, lariat_normal_at, lariat_only_rope, lariat_open,
    lariat_point_at, lariat_points, lariat_predict, lariat_reader, lariat_rope, lariat_rope_at,
    lariat_rope_of_track, lariat_run, lariat_seen_text, lariat_tangent_at,
};

use super::curve::{POINTS, RHOS};
use super::rig::Place;

/// A value that nobody writes.
const UNTOUCHED: f64 = -7.25e77;
/// Numbers after each buffer that must remain unchanged.
const GUARD: usize = 8;
/// Maximum ages of an image.
const MAX_AGES_NS: [u64; 3] = [0, 1_000_000_000, u64::MAX];

/// A reader of the C interface.
pub(crate) struct Reader(*mut lariat_reader);

impl Reader {
    pub(crate) fn open(place: &Place) -> Self {
        /// One thread at a time, because the environment names the domain.
        static OPENING: Mutex<()> = Mutex::new(());
        let name = CString::new(place.rig.to_string()).expect("a plain name");
        let _alone = OPENING.lock();
        // SAFETY: only the standard library, which locks it, reads this process's environment.
        unsafe { std::env::set_var("LARIAT_DOMAIN", &place.name) };
        let mut reader = ptr::null_mut();
        // SAFETY: a terminated string, and a place for a pointer.
        let opened = unsafe { lariat_open(name.as_ptr(), &raw mut reader) };
        assert_eq!(opened, 0);
        Self(reader)
    }

    /// Reads the newest message, and makes all queries of it.
    pub(crate) fn ask(&self) {
        // SAFETY: the reader is open and is used by this thread alone. Its results are valid until
        // the next read, which comes later.
        unsafe {
            assert_eq!(lariat_latest(self.0), 1);
            lariat_accept_coarse(self.0, 1);
            assert!(lariat_age_ns(self.0) < u64::MAX && lariat_run(self.0) > 0);
            let mut rope = std::mem::zeroed::<lariat_rope>();
            let message = &*lariat_message(self.0);
            let meant = (message.count as usize).min(LARIAT_MAX_ROPES);
            for max_age_ns in MAX_AGES_NS {
                lariat_only_rope(self.0, max_age_ns, &raw mut rope);
                check(&rope);
                for index in [0, 1, 2, meant as u32, u32::MAX] {
                    lariat_rope_at(self.0, index, max_age_ns, &raw mut rope);
                    check(&rope);
                    let track = rope.track;
                    lariat_rope_of_track(self.0, track, max_age_ns, &raw mut rope);
                    check(&rope);
                    self.predict(&rope);
                }
            }
            // Lost and malformed ropes may be queried, too.
            for descriptor in &message.ropes[..meant] {
                ask_curve(descriptor);
                ask_line(lariat_centerline_of(self.0, descriptor));
            }
            for centerline in &message.centerlines[..meant] {
                ask_line(centerline);
            }
        }
    }

    fn predict(&self, rope: &lariat_rope) {
        // SAFETY: as above.
        unsafe {
            let mut ahead = std::mem::zeroed::<lariat_descriptor>();
            for t_ns in [0, rope.exposed_ns, rope.exposed_ns.saturating_add(1 << 28)] {
                answered(lariat_predict(self.0, rope.track, t_ns, &raw mut ahead));
                // As predicted, or without control points.
                into(2, |xy| lariat_point_at(&raw const ahead, 0.5, xy));
            }
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        // SAFETY: `open` made the pointer, and it is closed once.
        unsafe { lariat_close(self.0) };
    }
}

/// Checks that the state has a name, and that at most one pointer is set.
fn check(rope: &lariat_rope) {
    let pointers = [rope.fresh, rope.partial, rope.unsure, rope.last_known];
    let given = pointers.iter().filter(|pointer| !pointer.is_null());
    assert!(given.count() <= 1);
    assert!(!lariat_seen_text(rope.seen as c_int).is_null());
}

/// Checks that a function succeeds or fails with a message. A caught panic is a fault.
fn answered(code: c_int) {
    assert_ne!(code, LARIAT_ERROR_FAULT, "{:?}", {
        // SAFETY: a terminated string that is valid until the next error in this thread.
        unsafe { std::ffi::CStr::from_ptr(lariat_error()) }
    });
}

/// Has an answer written into a buffer of `count` numbers.
fn into(count: usize, write: impl FnOnce(*mut f64) -> c_int) {
    let mut place = vec![UNTOUCHED; count + GUARD];
    answered(write(place.as_mut_ptr()));
    assert!(place[count..].iter().all(|number| *number == UNTOUCHED));
}

fn ask_curve(rope: *const lariat_descriptor) {
    // SAFETY: a descriptor in a reader or in this function, and buffers as large as the header
    // says.
    unsafe {
        for rho in RHOS {
            into(2, |xy| lariat_point_at(rope, rho, xy));
            into(2, |xy| lariat_derivative_at(rope, rho, xy));
            into(2, |xy| lariat_tangent_at(rope, rho, xy));
            into(2, |xy| lariat_normal_at(rope, rho, xy));
            into(1, |bend| lariat_curvature_at(rope, rho, bend));
            into(3, |covariance| lariat_covariance_at(rope, rho, covariance));
            // If the rope has a curve, the count is within its bounds; otherwise nothing is
            // written.
            let count = ((*rope).count as usize).min(LARIAT_MAX_CONTROL_POINTS);
            into(count, |values| lariat_jacobian_at(rope, rho, values));
        }
        for [x, y] in POINTS {
            into(4, |nearest| lariat_nearest(rope, x, y, nearest));
        }
        for count in [0, 1, 7] {
            into(2 * count, |xy| lariat_points(rope, count, xy));
        }
        let size = 2 * ((*rope).count as usize).min(LARIAT_MAX_CONTROL_POINTS);
        into(size * size, |matrix| lariat_covariance(rope, matrix));
    }
}

/// `line` may be NULL.
fn ask_line(line: *const lariat_centerline) {
    // SAFETY: a centerline in a reader, or NULL, and buffers as large as the header says.
    unsafe {
        for rho in RHOS {
            into(2, |xy| lariat_centerline_point_at(line, rho, xy));
        }
        for [x, y] in POINTS {
            into(4, |nearest| lariat_centerline_nearest(line, x, y, nearest));
        }
    }
}
