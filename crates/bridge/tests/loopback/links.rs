//! Descriptors: they arrive as sent, losses are exact, either side may be killed, and several
//! machines may read.

use std::cell::Cell;
use std::thread;
use std::time::{Duration, Instant};

use lariat_sink::{Ledger, Lost};
use lariat_wire::{Descriptors, MAX_CURVES, MAX_POINTS, Reader, Receiver, Seen, now_ns};

use crate::relay::Weather;
use crate::rope;
use crate::sides::{Chain, PATIENCE, Place, Relayed, free_port, number, rig, said_bound_us, take};

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
        // Both sides share one clock here, so the error of a timestamp is known. The bound improves
        // with each answer, and grows no faster than clocks drift apart.
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
    // After an answer, everything that is sent is counted.
    let deadline = Instant::now() + PATIENCE;
    take(
        &reader,
        |_| {},
        || said_bound_us(&place.far).is_none() && Instant::now() < deadline,
    );
    // The bound is half of a round trip, however loaded the machine was. Later answers only improve
    // it.
    let bound_us = said_bound_us(&place.far).expect("an answer");
    let chain = Chain::start(&place);
    let (mut count, mut last) = (0, (0, 0));
    let mut ledger = Ledger::new(true);
    let mut see = |message: &Descriptors| {
        let at = (message.trace.fitted, message.trace.exposed_ns);
        assert!(at.0 > last.0 && at.1 > last.1, "{at:?} after {last:?}");
        let off_us = at.1.abs_diff(rope::written_ns(message)) as f64 * 1e-3;
        assert!(off_us < bound_us + 1000.0, "{off_us} ± {bound_us}");
        last = at;
        count += 1;
        ledger.received(&message.trace, now_ns());
    };
    let until = Instant::now() + Duration::from_secs(3);
    take(&reader, &mut see, || Instant::now() < until);
    // Messages in transit arrive, and an answer reports how many were sent.
    drop(chain);
    let until = Instant::now() + Duration::from_millis(300);
    take(&reader, see, || Instant::now() < until);
    let (far, near) = (sides.1.end(), sides.0.end());
    let [sent, received, lost] = ["lost; sent ", "received ", " lost "].map(|word| match word {
        "lost; sent " => number(&far, "cell: sent "),
        word => number(&far, word),
    });
    assert_eq!(sent, received + lost, "{far}");
    assert_eq!(received, count, "{far}");
    assert_eq!(sent, number(&near, "cell: sent "), "{near} {far}");
    assert!(lost > 0 && received > lost, "{far}");
    // A reader's own ledger agrees, except for losses after the last message that came.
    let bridge = lost + last.0 - sent;
    let expected = Lost {
        bridge,
        ..Lost::default()
    };
    assert_eq!(ledger.lost(), expected, "{near} {far}");
    drop((reader, domain));
}

#[test]
fn a_message_of_many_datagrams_comes_whole_or_is_lost_once() {
    let place = Place::new();
    let weather = Weather {
        lost_of_1000: 5,
        ..Weather::default()
    };
    let relay = Relayed::start(place.port, weather);
    let sides = (place.listen(&[]), place.connect(relay.port, &[]));
    let domain = place.far();
    let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
    let deadline = Instant::now() + PATIENCE;
    while said_bound_us(&place.far).is_none() {
        assert!(Instant::now() < deadline, "nobody answers");
        // Nothing signals a first answer, so the roster is polled.
        thread::sleep(Duration::from_millis(10));
    }
    let chain = Chain::of(&place, rope::write_many);
    let (mut count, mut last) = (0, 0);
    let mut expected = Box::new(Descriptors::EMPTY);
    let mut see = |message: &Descriptors| {
        rope::write_many(&mut expected, message.trace.fitted, 1);
        assert!(message.trace.fitted > last);
        last = message.trace.fitted;
        assert_eq!(message.curves().len(), MAX_CURVES);
        for (came, sent) in message.curves().iter().zip(expected.curves()) {
            assert_eq!(came.control_points(), sent.control_points());
            assert_eq!(came.covariances(), sent.covariances());
            assert_eq!(came.samples as usize, MAX_POINTS);
        }
        count += 1;
    };
    let until = Instant::now() + Duration::from_secs(3);
    take(&reader, &mut see, || Instant::now() < until);
    drop(chain);
    let until = Instant::now() + Duration::from_millis(300);
    take(&reader, see, || Instant::now() < until);
    let (far, near) = (sides.1.end(), sides.0.end());
    let [received, lost] = ["received ", " lost "].map(|word| number(&far, word));
    let sent = number(&far, "cell: sent ");
    assert_eq!((sent, received), (received + lost, count), "{near} {far}");
    assert_eq!(sent, number(&near, "cell: sent "), "{near} {far}");
    // Every message has about 60 datagrams, so every fourth message loses one. With one datagram
    // each, only one in 200 messages would be lost.
    assert!(20 * lost > sent && received > 0, "{far}");
    drop((reader, domain));
}

/// Waits until the reader sees what is wanted.
fn until(reader: &mut Reader, is_wanted: fn(&Seen) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let look_up = Instant::now() + Duration::from_millis(50);
        let frame = reader.wait(look_up).expect("a reader");
        let seen = frame.only_rope(Duration::from_millis(200));
        if is_wanted(&seen) {
            break;
        }
        assert!(Instant::now() < deadline, "{seen}");
    }
}

fn is_fresh(seen: &Seen) -> bool {
    matches!(seen, Seen::Fresh(_))
}

fn is_stale(seen: &Seen) -> bool {
    matches!(seen, Seen::Stale(_))
}

#[test]
fn who_moves_to_another_address_is_found_again() {
    let mut place = Place::new();
    let calm = Weather::default();
    let relay = Relayed::start(place.port, calm);
    let port = relay.port;
    let near = place.listen(&[]);
    let far = place.connect(port, &[]);
    let mut reader = Reader::open_in(place.far(), &rig()).expect("a reader");
    let chain = Chain::start(&place);
    until(&mut reader, is_fresh);
    drop(relay);
    until(&mut reader, is_stale);
    // For the camera's side, the other side now has another address.
    let relay = Relayed::at(port, place.port, calm);
    until(&mut reader, is_fresh);
    drop(relay);
    near.end();
    until(&mut reader, is_stale);
    // Now the camera's side has another address, under the same name.
    place.port = free_port();
    let near = place.listen(&[]);
    let relay = Relayed::at(port, place.port, calm);
    until(&mut reader, is_fresh);
    far.end();
    near.end();
    drop((reader, chain, relay));
}

#[test]
fn one_machine_reads_several_cameras() {
    let one = Place::new();
    let mut other = Place::new();
    (other.far, other.rig) = (one.far.clone(), "other".parse().expect("a name"));
    let places = [&one, &other];
    let sides = places.map(|of| (of.listen(&[]), of.connect(of.port, &[])));
    let domain = one.far();
    let readers = places.map(|of| Receiver::descriptors(&domain, &of.rig).expect("a reader"));
    let chains = (Chain::start(&one), Chain::of(&other, rope::write_many));
    for (reader, ropes) in readers.iter().zip([1, MAX_CURVES]) {
        let came = std::cell::Cell::new(0);
        let see = |message: &Descriptors| {
            assert_eq!(message.curves().len(), ropes);
            came.set(came.get() + 1);
        };
        take(reader, see, || came.get() < 20);
    }
    for (near, far) in sides {
        far.end();
        near.end();
    }
    drop((readers, domain, chains));
}

#[test]
fn either_side_may_be_killed_and_readers_go_on_by_themselves() {
    let place = Place::new();
    // The far side starts first.
    let mut far = place.connect(place.port, &[]);
    let mut reader = Reader::open_in(place.far(), &rig()).expect("a reader");
    let chain = Chain::start(&place);
    let mut near = place.listen(&[]);
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

#[test]
fn of_realtime_priority_what_carries_descriptors_is_on_one_core_and_what_makes_pictures_is_neither()
{
    let cores = rustix::thread::sched_getaffinity(None).expect("it runs");
    let place = Place::new();
    let near = place.listen(&["--realtime"]);
    let far = place.connect(place.port, &["--realtime", "--frames", "1"]);
    let domain = place.far();
    let reader = Receiver::descriptors(&domain, &rig()).expect("a reader");
    let chain = Chain::start(&place);
    let has_come = Cell::new(false);
    take(&reader, |_| has_come.set(true), || !has_come.get());
    for side in [&near, &far] {
        let threads = side.threads();
        for (name, is_realtime, allowed) in &threads {
            let expected = if *is_realtime {
                1
            } else {
                cores.count() as usize
            };
            assert_eq!(*allowed, expected, "{threads:?}");
            assert!(!*is_realtime || name != "pictures", "{threads:?}");
        }
        // A user who may have realtime priority for one thread may have it for all.
        let ordinary = threads.iter().filter(|(_, is_realtime, _)| !is_realtime);
        assert!(
            [1, threads.len()].contains(&ordinary.count()),
            "{threads:?}"
        );
        assert_eq!(threads.len(), 3);
    }
    drop((near.end(), far.end(), reader, domain, chain));
}
