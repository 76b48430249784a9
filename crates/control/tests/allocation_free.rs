#![allow(unsafe_code)] // A counting allocator is an allocator.
//! A servo allocates nothing once made, whatever it is at.

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use lariat_control::{Doing, Observation, Options, Servo, Why};
use support::{World, linear};

struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: all is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_servo_allocates_nothing_from_exploring_to_arrival() {
    let mut world = World::new(linear, [[100.0, 50.0, 0.0], [0.0; 3]], 16);
    let target = linear(&[[220.0, 110.0, 0.3], [0.0; 3]]);
    let mut servo = Servo::new(Options::default(), &target).expect("good options");
    let mut allocated = 0;
    for turn in 0..2000 {
        let (exposed_ns, shape) = world.image();
        let before = COUNT.with(Cell::get);
        let command = if turn % 100 == 50 {
            servo.hold(Why::Lost, world.now_ns())
        } else {
            servo.see(Observation::new(&shape, exposed_ns), world.now_ns())
        };
        allocated += COUNT.with(Cell::get) - before;
        world.obey(&command);
        if command.doing == Doing::Arrived {
            assert_eq!(allocated, 0);
            return;
        }
    }
    panic!("it never arrives");
}
