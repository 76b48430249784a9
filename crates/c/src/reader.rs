#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! Opening, reading, waiting, closing.

use std::ffi::{CStr, c_char, c_int};
use std::os::fd::{AsFd, AsRawFd};
use std::ptr;
use std::time::{Duration, Instant};

use lariat_wire::{Motion, Reader, now_ns};

use crate::error::{Failure, LARIAT_ERROR_NAME, answer};
use crate::message::lariat_descriptors;

/// A control loop's connection to a rig.
pub struct lariat_reader {
    pub(crate) reader: Reader,
}

/// The reader behind a pointer that may be NULL.
pub(crate) fn given<'a>(reader: *mut lariat_reader) -> Result<&'a mut lariat_reader, Failure> {
    // SAFETY: C passes a pointer from lariat_open that is not closed, used by one thread at a time,
    // or NULL.
    unsafe { reader.as_mut() }.ok_or_else(|| Failure::null("the reader"))
}

/// The reader behind a pointer that may be NULL, for reading only.
pub(crate) fn shown<'a>(reader: *const lariat_reader) -> Result<&'a lariat_reader, Failure> {
    // SAFETY: as above; nothing writes to it meanwhile, because one thread uses it at a time.
    unsafe { reader.as_ref() }.ok_or_else(|| Failure::null("the reader"))
}

/// The text of a C string.
pub(crate) fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str, Failure> {
    if text.is_null() {
        return Err(Failure::null(what));
    }
    // SAFETY: C passes a string that ends with a NUL and is valid while the function runs.
    let text = unsafe { CStr::from_ptr(text) }.to_str();
    text.map_err(|_| Failure::new(LARIAT_ERROR_NAME, format!("{what} is no UTF-8")))
}

/// Opens a reader of a rig: "default", or the name given to the chain (--rig NAME). The chain need
/// not be running. Up to 24 readers share a rig; a slow, stopped or killed reader disturbs neither
/// the chain nor the others.
///
/// Open a reader of a --lossless chain after the chain has started, and read it as often as frames
/// arrive, because that chain waits for it.
///
/// Returns 0, or an error; *reader is then NULL.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_open(rig: *const c_char, reader: *mut *mut lariat_reader) -> c_int {
    answer(|| {
        // SAFETY: C passes space for a pointer, or NULL.
        let place = unsafe { reader.as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the reader"))?;
        *place = ptr::null_mut();
        let reader = Reader::open(text(rig, "the rig's name")?)?;
        *place = Box::into_raw(Box::new(lariat_reader { reader }));
        Ok(0)
    })
}

/// Closes a reader; NULL does nothing. Pointers to its ropes become invalid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_close(reader: *mut lariat_reader) {
    answer(|| {
        if !reader.is_null() {
            // SAFETY: C passes a pointer from lariat_open, once, and does not use it again.
            drop(unsafe { Box::from_raw(reader) });
        }
        Ok(0)
    });
}

/// Reads the newest message without waiting. It makes no system call, except when it connects to a
/// chain that has just started.
///
/// Returns 1 if the message is new, 0 if not (the last one stays and gets older), or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_latest(reader: *mut lariat_reader) -> c_int {
    answer(|| Ok(given(reader)?.reader.latest()?.is_new().into()))
}

/// Sleeps until a new message arrives, for at most `timeout_ns`; a negative timeout is unlimited. A
/// signal does not end the sleep.
///
/// Returns the same values as lariat_latest.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_wait(reader: *mut lariat_reader, timeout_ns: i64) -> c_int {
    /// Longest single wait.
    const FOR_EVER: Duration = Duration::from_secs(3600);
    answer(|| {
        let reader = &mut given(reader)?.reader;
        let timeout = u64::try_from(timeout_ns).map(Duration::from_nanos);
        loop {
            // A deadline beyond the clock's range never passes.
            let deadline = Instant::now().checked_add(timeout.unwrap_or(FOR_EVER));
            let deadline = deadline.unwrap_or_else(|| Instant::now() + FOR_EVER);
            let is_new = reader.wait(deadline)?.is_new();
            if is_new || timeout.is_ok() {
                return Ok(is_new.into());
            }
        }
    })
}

/// Returns a file descriptor for your own poll, epoll or select. It becomes readable when a message
/// arrives. It belongs to the reader: do not read from it or close it.
///
/// Call lariat_before_poll before each sleep and lariat_latest after it.
///
/// Returns the descriptor, or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_fd(reader: *const lariat_reader) -> c_int {
    answer(|| Ok(shown(reader)?.reader.as_fd().as_raw_fd()))
}

/// Prepares for a sleep on lariat_fd and computes its maximum duration. `*timeout_ms` is poll's own
/// argument: 0 if a message already waits, -1 if the sleep may be unlimited. This call drains the
/// notifications, because the descriptor would stay readable otherwise. For 0.1 s after a
/// notification the sleep is limited, because the transport may lose one in that time.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_before_poll(
    reader: *mut lariat_reader,
    timeout_ms: *mut c_int,
) -> c_int {
    answer(|| {
        // SAFETY: C passes space for a number, or NULL.
        let place = unsafe { timeout_ms.as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the timeout"))?;
        *place = 0;
        let longest = given(reader)?.reader.before_poll()?;
        // It is about 100.
        *place = longest.map_or(-1, |longest| longest.as_millis() as c_int);
        Ok(0)
    })
}

/// Lets lariat_wait spin for this time before it sleeps. A message that arrives in that time is
/// received some microseconds earlier. This is for a thread with its own core. The default is 0.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_look_for(reader: *mut lariat_reader, time_ns: u64) -> c_int {
    answer(|| {
        given(reader)?
            .reader
            .look_for(Duration::from_nanos(time_ns));
        Ok(0)
    })
}

/// Requests short time slices for the calling thread, for a control loop without realtime priority.
/// When a message wakes the thread, it need not wait until another program's slice ends. This needs
/// no privilege. It requires Linux 6.12 and does nothing on older kernels. Threads that this thread
/// starts later inherit the short slices.
#[unsafe(no_mangle)]
pub extern "C" fn lariat_take_short_slices() {
    lariat_wire::take_short_slices();
}

/// Sets whether a rope with a coarse curve can be LARIAT_FRESH or LARIAT_PARTIAL like any other
/// (1), or is LARIAT_UNSURE (0, the default). Use 1 in loops that compare descriptors and do not
/// need the curve to follow the rope.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_accept_coarse(reader: *mut lariat_reader, accept: c_int) -> c_int {
    answer(|| {
        given(reader)?.reader.accept_coarse(accept != 0);
        Ok(0)
    })
}

/// Sets the minimum confidence, 0 to 1, of a rope that is LARIAT_FRESH or LARIAT_PARTIAL. A rope
/// with a lower confidence is LARIAT_UNSURE. The default is 0.5, below which the curve is more
/// likely wrong than right. 0 accepts any confidence.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_min_confidence(reader: *mut lariat_reader, least: f32) -> c_int {
    answer(|| {
        given(reader)?.reader.min_confidence(least);
        Ok(0)
    })
}

/// Sets the motion model of ropes for lariat_predict: the standard deviation of a point's
/// acceleration along each axis, in units/s² (`acceleration_px_s2` in the chain's settings), and
/// its correlation time in s. The defaults are 1000 and 0.1, the chain's own in pixels.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_expect_motion(
    reader: *mut lariat_reader,
    acceleration: f64,
    lasts_s: f64,
) -> c_int {
    answer(|| {
        let motion = Motion {
            acceleration,
            lasts_s,
        };
        given(reader)?.reader.expect_motion(motion);
        Ok(0)
    })
}

/// Returns the age of the image of the newest message read; UINT64_MAX before the first.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_age_ns(reader: *const lariat_reader) -> u64 {
    let age = shown(reader).ok().and_then(|shown| shown.reader.age());
    age.map_or(u64::MAX, |age| age.as_nanos() as u64)
}

/// Returns the run of the chain that the message belongs to, counted by this reader from 1; 0
/// before the first message. When it changes, ropes are numbered again, and basis, order and unit
/// may differ.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_run(reader: *const lariat_reader) -> u64 {
    shown(reader).map_or(0, |shown| shown.reader.frame().run())
}

/// Returns the newest message itself; NULL before the first. It does not contain its age. It is for
/// programs that need all of its data, such as recorders.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_message(reader: *const lariat_reader) -> *const lariat_descriptors {
    let shown = shown(reader).ok();
    let message = shown.and_then(|shown| shown.reader.frame().message());
    // The same layout; `message` checks it.
    message.map_or(ptr::null(), |message| ptr::from_ref(message).cast())
}

/// Returns the current time of CLOCK_MONOTONIC, the clock of all times in this interface.
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn lariat_now_ns() -> u64 {
    now_ns()
}
