//! Once warm, a rendered frame costs no allocation: not to draw, not to write, not to tell the truth of. A camera's JPEG
//! costs those of its decoder, which are few, for rows and not for images, and given back.

// An allocator is unsafe by its trait; this one counts and passes everything on to the system's.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use jpeg::{Coding, encode};
use lariat_capture::{Mjpeg, RenderOptions, Source, open};
use lariat_message::Centerlines;

mod jpeg;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    /// Bytes that were asked for, and those of them that were not given back.
    static BYTES: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        BYTES.set(BYTES.get() + layout.size());
        HELD.set(HELD.get().wrapping_add(layout.size()));
        // SAFETY: the caller's promise is the one that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.set(HELD.get().wrapping_sub(layout.size()));
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_rendered_frame_allocates_nothing_once_warm() {
    let mut source = open(&Source::Rendered(RenderOptions::default())).unwrap();
    let mut pixels = vec![0; source.largest_frame_bytes()];
    let mut truth = Box::new(Centerlines::EMPTY);
    let mut allocations = || {
        let before = ALLOCATIONS.get();
        for _ in 0..300 {
            source.next().unwrap();
            source.write(&mut pixels);
            source.truth(&mut truth);
            source.take_warning();
        }
        ALLOCATIONS.get() - before
    };
    assert_eq!(allocations(), 0);
    // The counter counts.
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(Box::new(before)));
    assert_eq!(ALLOCATIONS.get(), before + 1);
}

#[test]
fn a_cameras_jpeg_costs_its_decoders_rows_and_no_more() {
    let size = [640, 480];
    let rgb: Vec<u8> = (0..size[0] * size[1] * 3).map(|i| (i / 40) as u8).collect();
    let frame = encode(&rgb, size, &Coding::CAMERA).jpeg;
    let mut decoder = Mjpeg::new(640, 480);
    let mut pixels = vec![0; decoder.largest_frame_bytes()];
    let mut cost = |frames: u64| {
        let before = [ALLOCATIONS.get(), BYTES.get() as u64, HELD.get() as u64];
        for _ in 0..frames {
            decoder.decode(&frame, &mut pixels).unwrap();
        }
        let after = [ALLOCATIONS.get(), BYTES.get() as u64, HELD.get() as u64];
        [0, 1, 2].map(|k| after[k] - before[k])
    };
    let [allocations, bytes, held] = cost(1);
    assert_eq!(cost(50), [50 * allocations, 50 * bytes, 0]);
    assert_eq!(held, 0);
    assert!(allocations <= 20, "{allocations}");
    // Of the 921,600 that the image takes.
    assert!(bytes <= 80_000, "{bytes}");
}
