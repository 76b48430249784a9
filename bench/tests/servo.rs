//! Tests of `lariat-bench servo`: ropes are driven to their target by camera feedback through the
//! whole chain.

#[allow(dead_code, reason = "written for the chain's own tests")]
#[path = "../../tests/chain/rig.rs"]
mod rig;

use rig::Bench;
use rustix::process::Signal;

#[test]
fn five_ropes_reach_their_target_at_60_frames_a_second_and_are_filmed() {
    let bench = Bench::new();
    // The time limit is for a loaded machine. On an idle one, a rope takes 6 s.
    let output = bench.run(&["servo", "--seeds", "5", "--time", "40s", "--out", "report"]);
    let said = String::from_utf8_lossy(&output.stderr);
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{table}{said}");
    assert!(table.contains("5/5"), "{table}{said}");
    let report = |name: &str| std::fs::read(bench.path("report").join(name)).expect(name);
    assert!(report("servo.gif").starts_with(b"GIF89a"));
    assert_eq!(report("servo.txt"), output.stdout);
    let page = String::from_utf8(report("servo.html")).expect("text");
    assert!(page.contains("<svg") && page.contains("data:image/gif;base64,"));
    bench.assert_nothing_is_left();
}

#[test]
fn a_lifted_rope_is_driven_in_space_by_what_a_depth_camera_sees_and_is_filmed() {
    let bench = Bench::new();
    let slow = ["--fps", "15", "--time", "60s", "--gif", "lifted.gif"];
    let report = ["--out", "report"];
    let ropes = ["servo", "--lifted", "--target", "line", "--seeds", "1"];
    let output = bench.run(&[&ropes[..], &slow, &report].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{table}{said}");
    assert!(
        table.contains("1/1") && table.contains("mm"),
        "{table}{said}"
    );
    let film = std::fs::read(bench.path("lifted.gif")).expect("a film");
    assert!(film.starts_with(b"GIF89a"));
    // The camera's image, the rope from the side, and the error.
    let side = |at: usize| u16::from_le_bytes([film[at], film[at + 1]]);
    assert_eq!([side(6), side(8)], [320, 240 + 100 + 50]);
    let page = std::fs::read_to_string(bench.path("report/servo.html")).expect("a page");
    assert!(page.contains("the line is 5 mm"), "{page}");
    bench.assert_nothing_is_left();
    std::fs::write(bench.path("line.jsonl"), "{\"points\":[[1,2],[3,4]]}").expect("a file");
    let output = bench.run(&["servo", "--lifted", "--target", "line.jsonl"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let output = bench.run(&["servo", "--lifted", "--study", "latency"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("not a group of a study of a lifted rope"),
        "{said}"
    );
    assert_eq!(output.status.code(), Some(2), "{said}");
}

#[test]
fn what_is_no_target_is_refused_with_a_sentence() {
    let bench = Bench::new();
    for (target, text, code) in [
        ("w", None, 2),
        ("wave.jsonl", Some("{\"points\":[[1,2]]}"), 1),
        ("broken.jsonl", Some("{\"points\":"), 1),
    ] {
        if let Some(text) = text {
            std::fs::write(bench.path(target), text).expect("a file");
        }
        let output = bench.run(&["servo", "--target", target]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(target) && said.contains("points"), "{said}");
    }
    bench.assert_nothing_is_left();
}

#[test]
fn a_signal_ends_all_of_it() {
    let bench = Bench::new();
    let servo = bench
        .command(&["servo", "--target", "s"])
        .spawn()
        .expect("it runs");
    let id = servo.id();
    rig::wait_until_told_by_signals(id);
    // While the first rope is being driven.
    let domain = lariat_wire::Domain::named(&bench.domain).expect("a domain");
    let rig = "servo".parse().expect("a name");
    let reader = lariat_wire::Receiver::descriptors(&domain, &rig).expect("a reader");
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(30);
    assert!(
        reader
            .wait(deadline)
            .expect("it can be waited for")
            .is_some()
    );
    drop((reader, domain));
    rig::send(id as i32, Signal::INT);
    let ended = servo.wait_with_output().expect("it ends");
    assert_eq!(ended.status.code(), Some(1));
    bench.assert_nothing_is_left();
}
