//! A fit allocates nothing, whichever the solver.
#![allow(unsafe_code)] // A global allocator cannot be written without; it only counts and hands on.

use lariat_fit::{Fitter, Options, Solver};
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

fn allocations() -> usize {
    ALLOCATIONS.with(Cell::get)
}

#[test]
fn the_counter_counts() {
    let before = allocations();
    std::hint::black_box(vec![0u8; 100]);
    assert_eq!(allocations() - before, 1);
}

#[test]
fn a_fit_allocates_nothing() {
    for solver in [Solver::Pinv, Solver::Cholesky, Solver::Qr] {
        for (order, points) in [(1, 2), (3, 33), (8, 120), (12, 256)] {
            let mut fitter = Fitter::new(Options {
                order,
                points,
                solver,
            })
            .unwrap();
            let rope: Vec<[f64; 2]> = (0..points)
                .map(|i| [3.0 * i as f64, 100.0 * (0.1 * i as f64).sin()])
                .collect();
            let before = allocations();
            for _ in 0..3 {
                std::hint::black_box(fitter.fit(&rope).unwrap());
            }
            assert_eq!(
                allocations(),
                before,
                "order {order}, {points} points, {solver}"
            );
        }
    }
}
