#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! Frames of a camera of the user's own.

use std::ffi::{c_char, c_int};
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lariat_wire::{Domain, FrameWriter, PixelFormat, Stamp, Waiting};

use crate::error::{Failure, LARIAT_ERROR_IMAGE, answer};
use crate::reader::text;

/// For lariat_writer_open: every frame is to reach every reader, for which lariat_writer_send waits, though no chain runs yet to
/// say so (`lariat run --lossless`).
pub const LARIAT_LOSSLESS: u32 = 1;

/// The writer of a rig's frames, whose chain was started with `lariat run --source external`. For one thread at a time.
pub struct lariat_writer {
    writer: FrameWriter,
    stop: Arc<AtomicBool>,
}

/// Who may be NULL.
fn given<'a>(writer: *mut lariat_writer) -> Result<&'a mut FrameWriter, Failure> {
    if writer.is_null() {
        return Err(Failure::null("the writer"));
    }
    // SAFETY: C gives what lariat_writer_open made and lariat_writer_close has not taken back, from one thread at a time. But for
    // lariat_writer_stop, which looks at the other field: so this is of the one alone.
    Ok(unsafe { &mut *ptr::addr_of_mut!((*writer).writer) })
}

/// The number of a pixel format: "rgb8", "bgr8", "gray8", "yuyv", "uyvy" or "nv12", or another that docs/messages.md lists.
///
/// Returns the number, or an error.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_pixel_format(name: *const c_char) -> c_int {
    answer(|| {
        let name = text(name, "the pixel format's name")?;
        let Some(format) = PixelFormat::from_name(name) else {
            let names = PixelFormat::ALL.map(PixelFormat::name).join(", ");
            let why = format!("Invalid pixel format '{name}': use one of {names}");
            return Err(Failure::new(LARIAT_ERROR_IMAGE, why));
        };
        Ok(format as c_int)
    })
}

/// Becomes the writer of a rig's frames: "default", or what the chain was started with (--rig NAME). The chain may be started
/// before or after it, and again; how: 0, which takes the chain as it is, or LARIAT_LOSSLESS. A rig has one writer: a second one is
/// refused, until the first has closed or its process is gone.
///
/// Returns 0, or an error; *writer is then NULL.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_writer_open(
    rig: *const c_char,
    how: u32,
    writer: *mut *mut lariat_writer,
) -> c_int {
    answer(|| {
        // SAFETY: C gives a place for a pointer, or NULL.
        let place = unsafe { writer.as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the writer"))?;
        *place = ptr::null_mut();
        let rig = text(rig, "the rig's name")?.parse()?;
        let stop = Arc::new(AtomicBool::new(false));
        let waiting = Waiting {
            lossless: (how & LARIAT_LOSSLESS != 0).then_some(true),
            stop: stop.clone(),
            meanwhile: None,
        };
        let writer = FrameWriter::open_in(Domain::open()?, &rig, waiting)?;
        *place = Box::into_raw(Box::new(lariat_writer { writer, stop }));
        Ok(0)
    })
}

/// Borrows the slot of the next frame in shared memory. `*pixels` is where it begins, rows one after the other without gaps: fill
/// it, and send it. It holds an earlier frame's pixels, and is yours until lariat_writer_send, the next loan or
/// lariat_writer_close.
///
/// Slots are made for the largest frame so far: the first one of a larger size takes some milliseconds longer.
///
/// Returns 0, or an error; *pixels is then NULL.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_writer_loan(
    writer: *mut lariat_writer,
    width: u32,
    height: u32,
    pixel_format: u32,
    pixels: *mut *mut u8,
) -> c_int {
    answer(|| {
        // SAFETY: C gives a place for a pointer, or NULL.
        let place = unsafe { pixels.as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the pixels"))?;
        *place = ptr::null_mut();
        let writer = given(writer)?;
        let Some(format) = PixelFormat::from_code(pixel_format) else {
            let why = format!(
                "Invalid pixel format {pixel_format}: use what lariat_pixel_format says of its name"
            );
            return Err(Failure::new(LARIAT_ERROR_IMAGE, why));
        };
        *place = writer.loan(width, height, format)?.as_mut_ptr();
        Ok(0)
    })
}

/// Sends the frame on loan, and wakes the chain. `exposed_ns`: when it was taken (lariat_now_ns), later than the one before; 0:
/// when its slot was borrowed. `sequence`: the camera's own number for it, higher than the one before: each that was left out
/// counts as a frame lost at the source; 0: the next one.
///
/// On a --lossless rig it waits for slow readers, until lariat_writer_stop.
///
/// Returns 0, 1 if the frame was lost because of lariat_writer_stop, or an error: the frame is then not sent, and not counted.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_writer_send(
    writer: *mut lariat_writer,
    exposed_ns: u64,
    sequence: u64,
) -> c_int {
    answer(|| {
        let stamp = Stamp {
            exposed_ns: (exposed_ns > 0).then_some(exposed_ns),
            sequence: (sequence > 0).then_some(sequence),
        };
        Ok((!given(writer)?.send(stamp)?).into())
    })
}

/// Sends a frame without an image: the camera has none to give just now. Sent some ten times a second for as long as that is so,
/// it has readers told that their ropes are lost from sight, and since when. (Of a writer that says nothing, and of one that is
/// gone, readers say LARIAT_STALE.)
///
/// Returns as lariat_writer_send.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_writer_send_blank(writer: *mut lariat_writer) -> c_int {
    answer(|| Ok((!given(writer)?.send_blank(Stamp::default())?).into()))
}

/// Has a lariat_writer_send that waits, or will, give up within seconds. From any thread, and from a signal's handler. It does
/// nothing to a writer that does not wait.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_writer_stop(writer: *const lariat_writer) {
    // Nothing here takes a lock, allocates or unwinds.
    // SAFETY: C gives what lariat_writer_open made, or NULL. Of the writer, which another thread may use now, only this flag is
    // touched, by a reference to the field alone.
    if !writer.is_null() {
        let stop = unsafe { &*ptr::addr_of!((*writer).stop) };
        stop.store(true, Ordering::Relaxed);
    }
}

/// Closes a writer. NULL is none. What was borrowed is gone then; what was sent is delivered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_writer_close(writer: *mut lariat_writer) {
    answer(|| {
        if !writer.is_null() {
            // SAFETY: C gives what lariat_writer_open made, once, and uses it no more.
            drop(unsafe { Box::from_raw(writer) });
        }
        Ok(0)
    });
}
