#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! Frames of a user's own camera.

use std::ffi::{c_char, c_int};
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lariat_wire::{Domain, FrameWriter, PixelFormat, Stamp, Waiting};

use crate::error::{Failure, LARIAT_ERROR_IMAGE, answer};
use crate::reader::text;

/// Flag of lariat_writer_open: every frame must reach every reader, and lariat_writer_send waits
/// for that. Needed only if the writer is opened before a chain of `lariat run --lossless`.
pub const LARIAT_LOSSLESS: u32 = 1;

/// The writer of the frames of a rig whose chain was started with `lariat run --source external`.
/// For one thread at a time.
pub struct lariat_writer {
    writer: FrameWriter,
    stop: Arc<AtomicBool>,
}

/// The writer behind a pointer that may be NULL.
fn given<'a>(writer: *mut lariat_writer) -> Result<&'a mut FrameWriter, Failure> {
    if writer.is_null() {
        return Err(Failure::null("the writer"));
    }
    // SAFETY: C passes a pointer from lariat_writer_open that is not closed, used by one thread at
    // a time. Only lariat_writer_stop may run concurrently, and it uses the other field, so this
    // reference covers only `writer`.
    Ok(unsafe { &mut *ptr::addr_of_mut!((*writer).writer) })
}

/// Finds the number of a pixel format: "rgb8", "bgr8", "gray8", "yuyv", "uyvy", "nv12", or another
/// one listed in docs/messages.md.
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

/// Opens the writer of a rig's frames. The rig is "default", or the name given to the chain (--rig
/// NAME). The chain may be started before or after it, and restarted. `how` is 0 to accept the
/// chain as it is, or LARIAT_LOSSLESS. A rig has one writer; a second one is refused until the
/// first has closed or its process has ended.
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
        // SAFETY: C passes space for a pointer, or NULL.
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

/// Borrows the slot of the next frame in shared memory. `*pixels` is its first byte, with rows
/// without gaps: fill it and send it. It still holds an earlier frame's pixels. It is yours until
/// lariat_writer_send, the next loan or lariat_writer_close.
///
/// Slots are as large as the largest frame yet, so the first frame of a larger size takes some
/// milliseconds longer.
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
        // SAFETY: C passes space for a pointer, or NULL.
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

/// Sends the frame on loan and wakes the chain.
///
/// `exposed_ns` is its exposure time (lariat_now_ns), later than that of the previous frame; 0
/// stands for the time when its slot was borrowed. `sequence` is the camera's own number of the
/// frame, higher than the previous number. Each number left out counts as a frame lost at the
/// source; 0 stands for the next number.
///
/// On a --lossless rig it waits for slow readers, until lariat_writer_stop is called.
///
/// Returns 0, or 1 if the frame was lost because of lariat_writer_stop, or an error. On an error
/// the frame is neither sent nor counted.
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

/// Sends a frame without an image, while the camera gives none. If such frames are sent about ten
/// times a second, readers learn that their ropes are lost, and since when. (If a writer sends
/// nothing or is gone, readers report LARIAT_STALE.)
///
/// Returns the same values as lariat_writer_send.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_writer_send_blank(writer: *mut lariat_writer) -> c_int {
    answer(|| Ok((!given(writer)?.send_blank(Stamp::default())?).into()))
}

/// Makes a current or later lariat_writer_send give up waiting within seconds. May be called from
/// any thread and from a signal handler. A writer that does not wait is unaffected.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_writer_stop(writer: *const lariat_writer) {
    // Nothing here takes a lock, allocates or unwinds.
    // SAFETY: C passes a pointer from lariat_writer_open, or NULL. Another thread may use the
    // writer now, so only this flag is accessed, by a reference to the field alone.
    if !writer.is_null() {
        let stop = unsafe { &*ptr::addr_of!((*writer).stop) };
        stop.store(true, Ordering::Relaxed);
    }
}

/// Closes a writer; NULL does nothing. A borrowed slot becomes invalid; sent frames are delivered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_writer_close(writer: *mut lariat_writer) {
    answer(|| {
        if !writer.is_null() {
            // SAFETY: C passes a pointer from lariat_writer_open, once, and does not use it again.
            drop(unsafe { Box::from_raw(writer) });
        }
        Ok(0)
    });
}
