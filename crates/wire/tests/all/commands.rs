//! Commands from a controller to the simulated robot.

use lariat_wire::*;

/// A domain that no other test run shares.
fn domain() -> Domain {
    Domain::named(&format!("k{}", std::process::id())).expect("a domain")
}

fn writer(domain: &Domain, rig: &Rig) -> Writer<Command> {
    Writer::<Command>::create(domain, rig, &COMMANDS, &Delivery::NewestWins).expect("a writer")
}

fn send(writer: &Writer<Command>, count: u64) {
    let mut slot = writer.slot().expect("a slot");
    *slot = Command {
        count,
        sent_ns: now_ns(),
        grippers: 1,
        velocities: [[count as f64, -2.0, 3.0, 0.1, 0.2, 0.5], [0.0; 6]],
        ..Command::default()
    };
    slot.send().expect("sent");
}

#[test]
fn commands_come_in_the_order_in_which_they_were_sent_and_eight_wait() {
    let rig: Rig = "order".parse().expect("a name");
    let reader = CommandReader::open(domain(), &rig).expect("a reader");
    assert_eq!(reader.next().expect("readable"), None);
    let domain = domain();
    let writer = writer(&domain, &rig);
    for count in 1..=11 {
        send(&writer, count);
    }
    let received: Vec<Command> = std::iter::from_fn(|| reader.next().expect("readable")).collect();
    let counts: Vec<u64> = received.iter().map(|command| command.count).collect();
    assert_eq!(counts, [4, 5, 6, 7, 8, 9, 10, 11]);
    assert_eq!(received[0].velocities(), [[4.0, -2.0, 3.0, 0.1, 0.2, 0.5]]);
    let state = domain.channel(&rig, "commands").expect("it is listed");
    let ends = state.ends.expect("of this release");
    let writer = ends.writer.expect("there");
    assert_eq!(
        (state.message.as_str(), writer.message_bytes),
        ("lariat.Command.v2", 128)
    );
    assert_eq!(ends.readers, [std::process::id()]);
}

#[test]
fn a_controller_that_was_restarted_is_heard_and_two_are_refused() {
    let rig: Rig = "again".parse().expect("a name");
    let reader = CommandReader::open(domain(), &rig).expect("a reader");
    let domain = domain();
    for count in [7, 1] {
        let writer = writer(&domain, &rig);
        let second = Writer::<Command>::create(&domain, &rig, &COMMANDS, &Delivery::NewestWins);
        assert!(matches!(second, Err(WireError::SecondWriter { .. })));
        send(&writer, count);
        assert_eq!(
            reader.next().expect("readable").map(|c| c.count),
            Some(count)
        );
    }
}

#[test]
fn a_reader_may_go_to_another_thread() {
    let rig: Rig = "thread".parse().expect("a name");
    let reader = CommandReader::open(domain(), &rig).expect("a reader");
    let domain = domain();
    let writer = writer(&domain, &rig);
    send(&writer, 3);
    let there = std::thread::spawn(move || reader.next().expect("readable").map(|c| c.count));
    assert_eq!(there.join().expect("no panic"), Some(3));
}
