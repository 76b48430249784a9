#![allow(unsafe_code)] // An allocator is unsafe by its trait; this one counts and passes everything on to the system's.
//! The counting allocator, by which tests show that something allocates nothing: every program that links this crate has it.
//!
//! Each thread counts its own, so that tests may run side by side.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::OnceLock;

struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

thread_local! {
    // Constants without a destructor: they take no memory from the allocator themselves.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    static BYTES: Cell<u64> = const { Cell::new(0) };
    static HELD_BYTES: Cell<i64> = const { Cell::new(0) };
}

static WATCHER: OnceLock<fn(usize)> = OnceLock::new();

/// How often this thread has asked for memory; a block that grows counts again.
pub fn allocations() -> u64 {
    ALLOCATIONS.get()
}

/// How many bytes this thread has asked for.
pub fn bytes() -> u64 {
    BYTES.get()
}

/// How many of them it has not given back: negative where it freed what another thread allocated.
pub fn held_bytes() -> i64 {
    HELD_BYTES.get()
}

/// Has every allocation of every thread told to `watcher`, with its size; the first one stays. It must not allocate.
pub fn watch(watcher: fn(usize)) {
    WATCHER.get_or_init(|| watcher);
}

// SAFETY: every call is passed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        BYTES.set(BYTES.get() + layout.size() as u64);
        HELD_BYTES.set(HELD_BYTES.get() + layout.size() as i64);
        if let Some(watcher) = WATCHER.get() {
            watcher(layout.size());
        }
        // SAFETY: the caller keeps `alloc`'s contract, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD_BYTES.set(HELD_BYTES.get() - layout.size() as i64);
        // SAFETY: `pointer` came from `System` with this layout, as all of ours do.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_counters_count() {
        let counts = || [allocations() as i64, bytes() as i64, held_bytes()];
        let before = counts();
        let mut block = std::hint::black_box(vec![0u8; 100]);
        assert_eq!(counts(), [before[0] + 1, before[1] + 100, before[2] + 100]);
        block.reserve_exact(200);
        assert_eq!(counts(), [before[0] + 2, before[1] + 400, before[2] + 300]);
        drop(block);
        assert_eq!(counts(), [before[0] + 2, before[1] + 400, before[2]]);
    }
}
