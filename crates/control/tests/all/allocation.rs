//! A servo does not allocate after its construction, in any state.

use crate::support::{World, linear};
use lariat_control::{Doing, Observation, Options, Servo, Why};
use lariat_test_support::allocations;

#[test]
fn a_servo_allocates_nothing_from_exploring_to_arrival() {
    let mut world = World::new(linear, [[100.0, 50.0, 0.0], [0.0; 3]], 16);
    let target = linear(&[[220.0, 110.0, 0.3], [0.0; 3]]);
    let mut servo = Servo::new(Options::default(), &target).expect("good options");
    let mut allocated = 0;
    for turn in 0..2000 {
        let (exposed_ns, shape) = world.image();
        let before = allocations();
        let command = if turn % 100 == 50 {
            servo.hold(Why::Lost, world.now_ns())
        } else {
            servo.see(Observation::new(&shape, exposed_ns), world.now_ns())
        };
        allocated += allocations() - before;
        world.obey(&command);
        if command.doing == Doing::Arrived {
            assert_eq!(allocated, 0);
            return;
        }
    }
    panic!("it never arrives");
}
