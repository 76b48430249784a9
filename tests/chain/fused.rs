//! `lariat run --fuse`: capture, extract and fit are threads of one process; everything else is
//! unchanged.

use rustix::process::Signal;

use crate::rig::{Bench, wait_until_gone};

#[test]
fn two_processes_do_the_work_of_four() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fuse", "--fps", "100", "--duration", "60"]);
    chain.wait_for_frames();
    let chain_id = chain.process.id() as i32;
    assert_eq!(chain.ids[..3], [chain_id; 3]);
    assert_ne!(chain.ids[3], chain_id);
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

#[test]
fn a_signal_ends_it_in_order_and_every_frame_is_accounted_for() {
    for signal in [Signal::INT, Signal::TERM] {
        let bench = Bench::new();
        let arguments = ["--fuse", "--fps", "max", "--duration", "60", "--out", "out"];
        let mut chain = bench.start(&arguments);
        chain.wait_for_frames();
        chain.signal_chain(signal);
        let ended = chain.end();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
        bench.assert_every_frame_is_accounted_for("out");
        bench.assert_nothing_is_left();
    }
}

#[test]
fn a_killed_process_takes_the_other_along() {
    for place in [0, 3] {
        let bench = Bench::new();
        let mut chain = bench.start(&["--fuse", "--fps", "100", "--duration", "60"]);
        let ids = chain.ids;
        chain.wait_for_frames();
        chain.signal_stage(place, Signal::KILL);
        assert!(!chain.end().status.success());
        ids.into_iter().for_each(wait_until_gone);
        bench.assert_nothing_is_left();
    }
}

#[test]
fn a_source_that_is_not_there_is_named_as_ever() {
    let bench = Bench::new();
    let said = |options: &[&str]| {
        let arguments = ["run", "--source", "none.png"];
        let output = bench.run(&[&arguments[..], options].concat());
        assert!(!output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert_eq!(said(&["--fuse"]), said(&[]));
    bench.assert_nothing_is_left();
}
