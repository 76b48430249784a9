#![allow(unsafe_code)] // An allocator is unsafe by its trait; this one counts and forwards.
//! The counting allocator, with which tests prove that code does not allocate. Every program that
//! links this crate uses it.
//!
//! Each thread has its own counters, so tests may run in parallel.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::OnceLock;

struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

thread_local! {
    // Constants without a destructor, which do not use the allocator themselves.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    static BYTES: Cell<u64> = const { Cell::new(0) };
    static HELD_BYTES: Cell<i64> = const { Cell::new(0) };
}

static WATCHER: OnceLock<fn(usize)> = OnceLock::new();

/// Returns how often this thread has requested memory; a block that grows counts again.
pub fn allocations() -> u64 {
    ALLOCATIONS.get()
}

/// Returns how many bytes this thread has requested.
pub fn bytes() -> u64 {
    BYTES.get()
}

/// Returns how many of these bytes this thread has not freed. The number is negative if it freed
/// memory of another thread.
pub fn held_bytes() -> i64 {
    HELD_BYTES.get()
}

/// Calls `watcher` for every allocation of every thread, with its size. The first watcher stays; it
/// must not allocate.
pub fn watch(watcher: fn(usize)) {
    WATCHER.get_or_init(|| watcher);
}

// SAFETY: every call is forwarded unchanged to the system's allocator, which fulfills the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        BYTES.set(BYTES.get() + layout.size() as u64);
        HELD_BYTES.set(HELD_BYTES.get() + layout.size() as i64);
        if let Some(watcher) = WATCHER.get() {
            watcher(layout.size());
        }
        // SAFETY: the caller fulfills the contract of `alloc`, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD_BYTES.set(HELD_BYTES.get() - layout.size() as i64);
        // SAFETY: `pointer` came from `System` with this layout, like all pointers of this
        // allocator.
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
