#![allow(unsafe_code)] // An allocator is unsafe by its trait.
//! Reading allocates for a chunk at most, not for a message.

mod made;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

use lariat_record::{Recording, Span};
use mcap::Compression;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

struct Counting;

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
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

/// One test, so that no other's allocations are counted.
#[test]
fn a_message_costs_no_allocation_once_warm() {
    // lz4's decoder is made anew for each chunk; what else there is, is kept.
    for (compression, per_chunk) in [
        (None, 0),
        (Some(Compression::Zstd), 0),
        (Some(Compression::Lz4), 2),
    ] {
        let (chunks, frames) = (6, 20);
        let recording = Recording::from_bytes(made::rig(compression, chunks, frames)).unwrap();
        let mut messages = recording.messages(Span::default()).unwrap();
        // Two chunks make it warm.
        let next = |messages: &mut lariat_record::Messages, count| {
            for _ in 0..count {
                assert!(messages.next().unwrap().is_some());
            }
        };
        next(&mut messages, 2 * frames * 5);
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        next(&mut messages, (chunks - 2) * frames * 5);
        let allocated = ALLOCATIONS.load(Ordering::Relaxed) - before;
        assert!(
            allocated <= (chunks - 2) * per_chunk,
            "{compression:?}: {allocated}"
        );
    }
}
