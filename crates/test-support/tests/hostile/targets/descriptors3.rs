//! Messages about ropes in 3-D that a control loop receives.

use std::hint::black_box;
use std::time::Duration;

use lariat_wire::fields::Message as _;
use lariat_wire::{
    DESCRIPTORS, DESCRIPTORS3, Delivery, Descriptors, Descriptors3, Frame, MAX_CONTROL_POINTS,
    MAX_POINTS, Place as InSpace, Reader, Rope, Seen, Writer,
};

use super::descriptors;
use super::edit::edit_all;
use super::input::Input;
use super::rig::Place;

/// Writers of a rig, and a reader of 3-D messages.
struct Bench {
    writer: Writer<Descriptors>,
    in_space: Writer<Descriptors3>,
    reader: Reader,
    /// Dropped last.
    _place: Place,
}

impl Bench {
    fn new() -> Self {
        let place = Place::new();
        let (domain, rig) = (place.domain(), &place.rig);
        let mut reader = Reader::open_in(place.domain(), rig).expect("a reader");
        reader.follow_in_space().expect("a reader in space");
        let delivery = Delivery::NewestWins;
        let writer = Writer::<Descriptors>::create(&domain, rig, &DESCRIPTORS, &delivery);
        let in_space = Writer::<Descriptors3>::create(&domain, rig, &DESCRIPTORS3, &delivery);
        Self {
            writer: writer.expect("the rig's only writer"),
            in_space: in_space.expect("the rig's only writer in space"),
            reader,
            _place: place,
        }
    }
}

thread_local! {
    static BENCH: std::cell::RefCell<Bench> = std::cell::RefCell::new(Bench::new());
}

/// Sends a message of 3-D descriptors to a control loop, together with a valid 2-D one of the same
/// frame.
///
/// # Panics
/// Panics if an invariant does not hold.
pub fn descriptors3(bytes: &[u8]) {
    let mut input = Input(bytes);
    let beside = descriptors::sound(&mut input);
    let mut message = sound(&beside);
    edit_all(&mut *message, &mut input);
    BENCH.with_borrow_mut(|bench| {
        let mut slot = bench.in_space.slot().expect("a slot");
        *slot = *message;
        slot.send().expect("sent");
        let mut slot = bench.writer.slot().expect("a slot");
        *slot = *beside;
        slot.send().expect("sent");
        let frame = bench.reader.latest().expect("readable");
        assert!(frame.is_new());
        ask(frame);
        ask(frame.keep().frame());
        assert!(!message.fields().is_empty());
    });
}

/// The same ropes in 3-D.
fn sound(beside: &Descriptors) -> Box<Descriptors3> {
    let mut message = Box::new(Descriptors3::EMPTY);
    (message.trace, message.count) = (beside.trace, beside.count);
    for (to, from) in message.curves.iter_mut().zip(beside.curves()) {
        (to.track, to.status, to.basis, to.degree) =
            (from.track, from.status, from.basis, from.degree);
        (to.count, to.samples, to.filtered) = (from.count, from.samples, from.filtered);
        (to.place, to.measured) = (InSpace::Known as u32, 100);
        (to.weights, to.knots) = (from.weights, from.knots);
        for (to, [x, y]) in to.control_points.iter_mut().zip(from.control_points) {
            *to = [x, y, 500.0 + 0.1 * x];
        }
        to.covariances[..9].fill([0.5, 0.1, 0.0, 0.4, 0.0, 0.9]);
    }
    message
}

fn ask(frame: Frame) {
    for seen in frame.ropes(Duration::from_secs(1)) {
        match seen {
            Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) => ask_rope(&rope),
            Seen::Lost(last) | Seen::Stale(last) => ask_rope(&last.as_it_was()),
            Seen::Absent(why) => assert!(!why.to_string().is_empty()),
        }
    }
}

fn ask_rope(rope: &Rope) {
    if let Ok(descriptor) = rope.descriptor3() {
        assert!(descriptor.control_points().len() <= MAX_CONTROL_POINTS);
        assert!(descriptor.points().len() <= MAX_POINTS);
        assert_eq!(descriptor.points().len(), descriptor.sigmas().len());
        black_box((
            descriptor.velocities().len(),
            descriptor.inner_knots().len(),
        ));
    }
    let shape = match rope.in_space() {
        Ok(shape) => shape,
        Err(why) => {
            assert!(!why.to_string().is_empty());
            return;
        }
    };
    assert!((1..=MAX_CONTROL_POINTS).contains(&shape.control_points().len()));
    for rho in [f64::NAN, -1.0, 0.0, 0.3, 1.0, 7.0, f64::INFINITY] {
        black_box((
            shape.point_at(rho),
            shape.derivative_at(rho),
            shape.tangent_at(rho),
        ));
        black_box((shape.curvature_at(rho), shape.jacobian_at(rho).len()));
    }
    let nearest = shape.nearest([100.0, 200.0, 500.0]);
    assert!((0.0..=1.0).contains(&nearest.rho));
    black_box(shape.points::<20>());
}
