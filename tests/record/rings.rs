//! The last seconds, kept in memory and written on request.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use lariat_wire::{Domain, Receiver, Rig};
use rustix::process::Signal;

use crate::recording::Recording;
use crate::rig::{Bench, send};

/// Waits until this many descriptors have been sent.
pub(crate) fn wait_for_descriptors(bench: &Bench, count: u64) {
    let domain = Domain::named(&bench.domain).unwrap();
    let reader = Receiver::descriptors(&domain, &Rig::default()).unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    let next = || {
        let message = reader.wait(deadline).unwrap().expect("a descriptor");
        message.trace.fitted
    };
    let first = next();
    while next() < first + count {}
}

/// Waits until a process is registered on the rig.
pub(crate) fn wait_until_announced(bench: &Bench, id: u32) {
    let deadline = Instant::now() + Duration::from_secs(30);
    let folder = format!("/tmp/lariat-{}/lariat-roster", bench.domain);
    let entry = format!("default.record.{id}");
    while std::fs::metadata(format!("{folder}/{entry}")).is_err() {
        assert!(Instant::now() < deadline, "the recorder did not come up");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A separate recorder, which ends with the test in any case.
pub(crate) struct Own(pub(crate) Child);

impl Own {
    pub(crate) fn start(bench: &Bench, flags: &[&str]) -> Self {
        let mut command = bench.command(&[&["record"], flags].concat());
        Self(
            command
                .stderr(Stdio::piped())
                .spawn()
                .expect("the binary runs"),
        )
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        // If the test succeeded, it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_last_seconds_are_written_by_signal_and_by_command_and_recording_goes_on() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60"]);
    chain.wait_for_frames();
    let nobody = bench.run(&["record", "--flush"]);
    assert!(!nobody.status.success());
    let said = String::from_utf8_lossy(&nobody.stderr);
    assert!(said.contains("no recorder of rig default keeps"), "{said}");
    let mut recorder = Own::start(&bench, &["--out", "last.mcap", "--ring", "500ms"]);
    wait_until_announced(&bench, recorder.0.id());
    let mut lines = BufReader::new(recorder.0.stderr.take().unwrap()).lines();
    let mut line = || lines.next().unwrap().unwrap();
    assert!(line().contains("keeping the last 0.5 s in memory, 512 MB at most"));
    let mut files = Vec::new();
    for by_signal in [true, false] {
        // More than the ring holds.
        wait_for_descriptors(&bench, 100);
        if by_signal {
            send(recorder.0.id() as i32, Signal::USR1);
        } else {
            assert!(bench.run(&["record", "--flush"]).status.success());
        }
        let said = line();
        assert!(said.contains("wrote the last 0."), "{said}");
        let name = said
            .split_whitespace()
            .find(|word| word.starts_with("last-"));
        files.push(name.unwrap().trim_end_matches(':').to_owned());
    }
    assert_ne!(files[0], files[1]);
    let recordings = [0, 1].map(|i| Recording::read(&bench.path(&files[i])));
    for recording in &recordings {
        assert!(recording.is_closed);
        // A loaded machine may make fewer than fifty images, so check the time that they span.
        let images = recording.of("image");
        let lasted_ns = images[images.len() - 1].log_ns - images[0].log_ns;
        assert!(lasted_ns <= 500_000_000, "{lasted_ns}");
        assert_eq!(recording.attachments[0].0, "lariat.toml");
    }
    let last = |recording: &Recording| recording.of("image").last().unwrap().log_ns;
    let first = recordings[1].of("image")[0].log_ns;
    assert!(last(&recordings[0]) < first, "they overlap");
    send(recorder.0.id() as i32, Signal::TERM);
    assert!(recorder.0.wait().unwrap().success());
    assert!(!bench.path("last.mcap").exists());
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}
