//! Once warm, a rendered frame costs no allocation: not to draw, not to write, not to tell the truth of.

// An allocator is unsafe by its trait; this one counts and passes everything on to the system's.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use lariat_capture::{RenderOptions, Source, open};
use lariat_wire::Centerlines;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise is the one that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
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
