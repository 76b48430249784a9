//! Test of a measurement whose output is no longer read.

use std::process::{Command, Stdio};

#[test]
fn a_measurement_ends_quietly_where_nobody_reads_it_any_more() {
    let mut bench = Command::new(env!("CARGO_BIN_EXE_lariat-bench"))
        .args([
            "tracking", "--frames", "2", "--seeds", "1", "--size", "120x90",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it is built");
    drop(bench.stdout.take());
    let ended = bench.wait_with_output().expect("it ends");
    assert_eq!(ended.status.code(), Some(1));
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "");
}
