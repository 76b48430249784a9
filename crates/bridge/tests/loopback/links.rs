//! Descriptors: what comes is what was sent, losses are exact, each side may be killed, and several may read.

use std::time::{Duration, Instant};

use lariat_wire::{Descriptors, Reader, Receiver, Seen};

use crate::relay::Weather;
use crate::rope;
use crate::sides::{Chain, PATIENCE, Place, Relayed, number, rig, said_bound_us, take};

#[test]
fn what_comes_is_what_was_sent_with_stamps_right_to_the_stated_bound() {
    let place = Place::new();
    let sides = (place.listen(&[]), place.connect(place.port, &[]));
    let domain = place.far();
    let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
    let chain = Chain::start(&place);
    let (mut count, mut last) = (0, 0);
    let (mut bound_us, mut compared) = (None, 0);
    let mut expected = Box::new(Descriptors::EMPTY);
    let see = |message: &Descriptors| {
        let written_ns = rope::written_ns(message);
        rope::write(&mut expected, message.trace.fitted, written_ns);
        let ours = &mut expected.curves[0];
        assert_eq!(message.curves[0].control_points(), ours.control_points());
        assert_eq!(message.curves[0].covariances(), ours.covariances());
        assert_eq!(message.curves[0].inner_knots(), ours.inner_knots());
        let points = [message, &expected].map(|message| message.centerlines[0].points());
        for (came, sent) in points[0].iter().zip(points[1]) {
            assert!(came.iter().zip(sent).all(|(a, b)| (a - b).abs() < 0.01));
        }
        assert_eq!(points[0].len(), points[1].len());
        assert!(message.trace.fitted > last);
        last = message.trace.fitted;
        // One machine, one clock: what a stamp is off by is known. The bound gets better with each answer, and by no more worse than clocks drift apart.
        if let Some(bound_us) = bound_us {
            let off_us = message.trace.exposed_ns.abs_diff(written_ns) as f64 * 1e-3;
            assert!(off_us < bound_us + 1000.0, "{off_us} ± {bound_us}");
            compared += 1;
        }
        count += 1;
        bound_us = bound_us.or_else(|| said_bound_us(&place.far));
    };
    let until = Instant::now() + Duration::from_millis(1500);
    take(&reader, see, || Instant::now() < until);
    assert!(count > 1 && compared > 0, "{count} {compared}");
    let (said, near) = (sides.1.end(), sides.0.end());
    assert!(
        number(&near, "cell: sent ") >= number(&said, "received "),
        "{near} {said}"
    );
    drop((reader, domain, chain));
}

#[test]
fn losses_are_exact_and_nothing_goes_back_in_time_over_a_link_that_delays_loses_and_reorders() {
    let place = Place::new();
    let weather = Weather {
        delay: Duration::from_millis(20),
        jitter: Duration::from_millis(30),
        lost_of_1000: 20,
    };
    let relay = Relayed::start(place.port, weather);
    let sides = (place.listen(&[]), place.connect(relay.port, &[]));
    let domain = place.far();
    let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
    // Once there was an answer, all that is sent is known of.
    let deadline = Instant::now() + PATIENCE;
    take(
        &reader,
        |_| {},
        || said_bound_us(&place.far).is_none() && Instant::now() < deadline,
    );
    let chain = Chain::start(&place);
    let (mut count, mut last) = (0, (0, 0));
    let see = |message: &Descriptors| {
        let at = (message.trace.fitted, message.trace.exposed_ns);
        assert!(at.0 > last.0 && at.1 > last.1, "{at:?} after {last:?}");
        // Both ways take 50 ms at most, so that no stamp is off by more than half of the way there and back.
        assert!(at.1.abs_diff(rope::written_ns(message)) < 100_000_000);
        last = at;
        count += 1;
    };
    let until = Instant::now() + Duration::from_secs(3);
    take(&reader, see, || Instant::now() < until);
    // What is under way arrives, and an answer says how many there were.
    drop(chain);
    let until = Instant::now() + Duration::from_millis(300);
    take(&reader, |_| count += 1, || Instant::now() < until);
    let (far, near) = (sides.1.end(), sides.0.end());
    let [sent, received, lost] = ["lost; sent ", "received ", " lost "].map(|word| match word {
        "lost; sent " => number(&far, "cell: sent "),
        word => number(&far, word),
    });
    assert_eq!(sent, received + lost, "{far}");
    assert_eq!(received, count, "{far}");
    assert_eq!(sent, number(&near, "cell: sent "), "{near} {far}");
    assert!(lost > 0 && received > lost, "{far}");
    drop((reader, domain));
}

#[test]
fn either_side_may_be_killed_and_readers_go_on_by_themselves() {
    let place = Place::new();
    // The other side is there first.
    let mut far = place.connect(place.port, &[]);
    let mut reader = Reader::open_in(place.far(), &rig()).expect("a reader");
    let chain = Chain::start(&place);
    let mut near = place.listen(&[]);
    let max_age = Duration::from_millis(200);
    let until = |reader: &mut Reader, is_wanted: fn(&Seen) -> bool| {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let look_up = Instant::now() + Duration::from_millis(50);
            let seen = reader.wait(look_up).expect("a reader").only_rope(max_age);
            if is_wanted(&seen) {
                break;
            }
            assert!(Instant::now() < deadline, "{seen}");
        }
    };
    let is_fresh = |seen: &Seen| matches!(seen, Seen::Fresh(_));
    let is_stale = |seen: &Seen| matches!(seen, Seen::Stale(_));
    until(&mut reader, is_fresh);
    for _ in 0..2 {
        near.kill();
        until(&mut reader, is_stale);
        near = place.listen(&[]);
        until(&mut reader, is_fresh);
        far.kill();
        until(&mut reader, is_stale);
        far = place.connect(place.port, &[]);
        until(&mut reader, is_fresh);
    }
    far.end();
    near.end();
    drop((reader, chain));
}

#[test]
fn several_machines_read_one_camera() {
    let place = Place::new();
    let other = Place::new();
    let near = place.listen(&[]);
    let places = [&place, &other];
    let far = places.map(|of| of.connect(place.port, &[]));
    let domains = places.map(Place::far);
    let readers = domains
        .each_ref()
        .map(|domain| Receiver::descriptors(domain, &rig()).expect("a reader"));
    let chain = Chain::start(&place);
    for reader in &readers {
        let came = std::cell::Cell::new(0);
        take(reader, |_| came.set(came.get() + 1), || came.get() < 20);
    }
    for side in far {
        let said = side.end();
        assert!(!said.contains("two bridges"), "{said}");
    }
    near.end();
    drop((readers, domains, chain));
}
