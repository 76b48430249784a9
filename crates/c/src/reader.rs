#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! Opening, looking, waiting, closing.

use std::ffi::{CStr, c_char, c_int};
use std::os::fd::{AsFd, AsRawFd};
use std::ptr;
use std::time::{Duration, Instant};

use lariat_wire::{Motion, Reader, now_ns};

use crate::error::{Failure, LARIAT_ERROR_NAME, answer};
use crate::message::lariat_descriptors;

/// A control loop's end of a rig.
pub struct lariat_reader {
    pub(crate) reader: Reader,
}

/// Who may be NULL.
pub(crate) fn given<'a>(reader: *mut lariat_reader) -> Result<&'a mut lariat_reader, Failure> {
    // SAFETY: C gives what lariat_open made and lariat_close has not taken back, from one thread at a time, or NULL.
    unsafe { reader.as_mut() }.ok_or_else(|| Failure::null("the reader"))
}

/// Likewise, to be read only.
pub(crate) fn shown<'a>(reader: *const lariat_reader) -> Result<&'a lariat_reader, Failure> {
    // SAFETY: as above; nothing writes to it meanwhile, as one thread uses it at a time.
    unsafe { reader.as_ref() }.ok_or_else(|| Failure::null("the reader"))
}

/// What C wrote.
pub(crate) fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str, Failure> {
    if text.is_null() {
        return Err(Failure::null(what));
    }
    // SAFETY: C gives a string that ends with a NUL, and stays while the function runs.
    let text = unsafe { CStr::from_ptr(text) }.to_str();
    text.map_err(|_| Failure::new(LARIAT_ERROR_NAME, format!("{what} is no UTF-8")))
}

/// Opens a reader of a rig: "default", or what the chain was started with (--rig NAME). Whether it runs does not matter. Up to
/// 24 readers share a rig; one that is slow, stopped or killed disturbs neither the chain nor the others.
///
/// The reader of a --lossless chain is opened after the chain has started, and must look as often as frames come: that chain
/// waits for it.
///
/// Returns 0, or an error; *reader is then NULL.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_open(rig: *const c_char, reader: *mut *mut lariat_reader) -> c_int {
    answer(|| {
        // SAFETY: C gives a place for a pointer, or NULL.
        let place = unsafe { reader.as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the reader"))?;
        *place = ptr::null_mut();
        let reader = Reader::open(text(rig, "the rig's name")?)?;
        *place = Box::into_raw(Box::new(lariat_reader { reader }));
        Ok(0)
    })
}

/// Closes a reader. NULL is none. What its ropes point to is gone then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_close(reader: *mut lariat_reader) {
    answer(|| {
        if !reader.is_null() {
            // SAFETY: C gives what lariat_open made, once, and uses it no more.
            drop(unsafe { Box::from_raw(reader) });
        }
        Ok(0)
    });
}

/// Takes up the newest message, without waiting, and without a system call but in the one look that takes up the channel of a
/// chain that has just started.
///
/// Returns 1 if one came since the last look, 0 if not (the last one stays, and gets older), or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_latest(reader: *mut lariat_reader) -> c_int {
    answer(|| Ok(given(reader)?.reader.latest()?.is_new().into()))
}

/// Sleeps until a message comes that was not looked at yet, at most `timeout_ns`; a negative timeout is for ever. A signal
/// does not end it.
///
/// Returns as lariat_latest.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_wait(reader: *mut lariat_reader, timeout_ns: i64) -> c_int {
    /// No chain is waited for any longer at a time.
    const FOR_EVER: Duration = Duration::from_secs(3600);
    answer(|| {
        let reader = &mut given(reader)?.reader;
        let timeout = u64::try_from(timeout_ns).map(Duration::from_nanos);
        loop {
            // A deadline beyond what the clock can say is one that does not come.
            let deadline = Instant::now().checked_add(timeout.unwrap_or(FOR_EVER));
            let deadline = deadline.unwrap_or_else(|| Instant::now() + FOR_EVER);
            let is_new = reader.wait(deadline)?.is_new();
            if is_new || timeout.is_ok() {
                return Ok(is_new.into());
            }
        }
    })
}

/// A descriptor to put into a poll, epoll or select of one's own: it becomes readable when a message came. It belongs to the
/// reader: do not read from it, and do not close it.
///
/// The rule: lariat_before_poll before each sleep, lariat_latest after it.
///
/// Returns the descriptor, or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_fd(reader: *const lariat_reader) -> c_int {
    answer(|| Ok(shown(reader)?.reader.as_fd().as_raw_fd()))
}

/// Makes ready for a sleep on lariat_fd, and says how long it may be at most: `*timeout_ms` is poll's own argument, 0 if a
/// message waits already, -1 for as long as you like. It empties the bell, which would ring for ever otherwise; for 0.1 s after
/// a ring the sleep is limited, because the transport may lose one then.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_before_poll(
    reader: *mut lariat_reader,
    timeout_ms: *mut c_int,
) -> c_int {
    answer(|| {
        // SAFETY: C gives a place for a number, or NULL.
        let place = unsafe { timeout_ms.as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the timeout"))?;
        *place = 0;
        let longest = given(reader)?.reader.before_poll()?;
        // Of the order of 100.
        *place = longest.map_or(-1, |longest| longest.as_millis() as c_int);
        Ok(0)
    })
}

/// Lets lariat_wait look for messages for so long, with the core all to itself, before it sleeps. For a thread with a core of
/// its own: what comes meanwhile is in hand some microseconds earlier. From the start, 0.
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

/// Asks for short slices of a core for the calling thread, for a control loop that may not have realtime priority: when a message wakes
/// it, it need not wait for the end of another program's slice. Any user may; it needs Linux 6.12, and changes nothing on older ones.
/// Threads that it starts later have short ones too.
#[unsafe(no_mangle)]
pub extern "C" fn lariat_take_short_slices() {
    lariat_wire::take_short_slices();
}

/// Whether a coarse curve is LARIAT_FRESH, or LARIAT_PARTIAL, like another (1), for a loop that compares descriptors and needs no
/// point of the curve to lie on the rope; or LARIAT_UNSURE (0), as from the start.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_accept_coarse(reader: *mut lariat_reader, accept: c_int) -> c_int {
    answer(|| {
        given(reader)?.reader.accept_coarse(accept != 0);
        Ok(0)
    })
}

/// Sets the least confidence, 0 to 1, of a rope that is LARIAT_FRESH or LARIAT_PARTIAL; a rope with less is LARIAT_UNSURE. The
/// default is 0.5: below it the curve is more likely wrong than right. 0 accepts any.
///
/// Returns 0, or an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_min_confidence(reader: *mut lariat_reader, least: f32) -> c_int {
    answer(|| {
        given(reader)?.reader.min_confidence(least);
        Ok(0)
    })
}

/// How ropes are taken to move, for lariat_predict: the standard deviation of a point's acceleration along each axis, in
/// units/s² (`acceleration_px_s2` in the chain's settings), and how long one lasts, in s. From the start 1000 and 0.1, the
/// chain's own in pixels.
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

/// How long ago the image of the newest message that was looked at was taken; UINT64_MAX before the first.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_age_ns(reader: *const lariat_reader) -> u64 {
    let age = shown(reader).ok().and_then(|shown| shown.reader.age());
    age.map_or(u64::MAX, |age| age.as_nanos() as u64)
}

/// Which run of the chain that message is of, counted by this reader from 1; 0 before the first. When it changes, ropes are
/// numbered again, and basis, order and unit may be others.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_run(reader: *const lariat_reader) -> u64 {
    shown(reader).map_or(0, |shown| shown.reader.frame().run())
}

/// That message itself; NULL before the first. It says nothing of how old it is: for what is to be done with all of it, as
/// writing it down.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_message(reader: *const lariat_reader) -> *const lariat_descriptors {
    let shown = shown(reader).ok();
    let message = shown.and_then(|shown| shown.reader.frame().message());
    // The same layout, which `message` holds it to.
    message.map_or(ptr::null(), |message| ptr::from_ref(message).cast())
}

/// The clock of all times here: CLOCK_MONOTONIC.
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn lariat_now_ns() -> u64 {
    now_ns()
}
