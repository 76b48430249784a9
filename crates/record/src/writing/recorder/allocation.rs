//! Once warm, recording a frame and all that belongs to it allocates nothing in the thread that reads channels.
#![allow(unsafe_code)] // A global allocator cannot be written without; it only counts and hands on.

use super::tests::{centerlines, drain_waiting, head, header, options};
use super::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is ending has no counter any more, and is not the one that is measured.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are handed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_frame_allocates_nothing_once_warm() {
    let (intake, outlet) = queue(16 << 20, 1 << 20);
    let thread = std::thread::spawn(|| Ending {
        written: Written::default(),
        fault: None,
    });
    let mut recorder = Recorder::new(intake, thread, &head(), options(16 << 20, false));
    let pixels = vec![0; 512 * 400];
    let shapes = Box::new(Descriptors::EMPTY);
    let before_any = ALLOCATIONS.get();
    let mut warm = 0;
    for count in 1..=60 {
        let (seen, truth) = (centerlines(count), centerlines(count));
        if count == 11 {
            warm = ALLOCATIONS.get();
        }
        let own = ALLOCATIONS.get();
        recorder.frame(&header(count), &pixels).unwrap();
        recorder.mask(&header(count), &pixels).unwrap();
        recorder.centerlines(&seen).unwrap();
        recorder.truth(&truth).unwrap();
        recorder.descriptors(&shapes).unwrap();
        recorder.losses(&Losses::default()).unwrap();
        // Three frames wait at a time.
        if count % 3 == 0 {
            drain_waiting(&outlet);
        }
        if count > 10 {
            assert_eq!(ALLOCATIONS.get(), own, "frame {count}");
        }
    }
    assert!(warm > before_any, "nothing is counted");
    assert_eq!(recorder.drops(), Drops::default());
}
