//! Unwritable outputs and invalid command lines are rejected before anything is measured.

#[allow(dead_code, reason = "written for the tests of the chain")]
#[path = "../../tests/chain/rig.rs"]
mod rig;

use rig::Bench;

#[test]
fn what_cannot_be_written_is_refused_at_once() {
    let bench = Bench::new();
    std::fs::write(bench.path("file"), "").expect("a file");
    for words in [
        ["servo", "--gif", "no/such.gif"],
        ["latency", "--out", "file"],
        ["paper", "--out", "file/report"],
    ] {
        let refused = bench.run(&words);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(1), "{words:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

#[test]
fn wrong_use_is_code_2() {
    let bench = Bench::new();
    for words in [&["latency", "--nonsense"][..], &["banana"], &[]] {
        assert_eq!(bench.run(words).status.code(), Some(2), "{words:?}");
    }
}
