//! Tests of `lariat-bench latency` and `compare` on the real binary: the output is complete and
//! nothing is left behind. No time is checked against a limit.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};
use tempfile::TempDir;

fn lariat_bench(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lariat-bench"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// Returns what the bench with this process ID has in shared memory, and its running processes.
fn left_of(bench: u32) -> Vec<String> {
    let names = |folder: &str| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned())
    };
    let domain = format!("LARIAT_DOMAIN=b{bench}");
    let lives = |id: &String| {
        let environment = fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
        environment
            .split(|&byte| byte == 0)
            .any(|entry| entry == domain.as_bytes())
    };
    let prefix = format!("lariat_b{bench}_");
    let shared = names("/dev/shm").filter(|name| name.starts_with(&prefix));
    let running = names("/proc")
        .filter(lives)
        .map(|id| format!("process {id}"));
    shared.chain(running).collect()
}

/// Waits for a condition. Fails the test after a minute.
fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !done() {
        assert!(Instant::now() < deadline, "never {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Checks that tags are closed in the reverse order of opening.
fn assert_well_formed(page: &str) {
    let mut open = Vec::new();
    let page = page.trim_start_matches("<!DOCTYPE html>");
    for tag in page.split('<').skip(1) {
        let tag = tag.split('>').next().expect("a tag ends");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "closed out of order");
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().expect("a tag has a name"));
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
}

#[test]
fn a_quick_bench_has_everything_and_leaves_nothing() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path().join("out");
    let bench = lariat_bench(&[
        "latency",
        "--quick",
        "--python",
        "/nonexistent/python",
        "--out",
    ])
    .arg(&out)
    .stdout(Stdio::piped())
    .stderr(Stdio::piped())
    .spawn()
    .expect("the binary runs");
    let id = bench.id();
    let done = bench.wait_with_output().expect("waited for");
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(
        done.status.success(),
        "{said}{}",
        String::from_utf8_lossy(&done.stderr)
    );
    assert!(left_of(id).is_empty(), "{:?}", left_of(id));
    assert!(!Path::new(&format!("/tmp/lariat-b{id}")).exists());
    for part in [
        "exposed → received",
        "floors",
        "others",
        "of it, µs",
        "to reach",
        "Unix sockets",
    ] {
        assert!(said.contains(part), "no {part} in {said}");
    }
    assert!(said.contains("/nonexistent/python cannot be run"), "{said}");

    let summary = fs::read(out.join("summary.json")).expect("a summary");
    let summary: Value = serde_json::from_slice(&summary).expect("JSON");
    assert_eq!(
        (&summary["kind"], &summary["schema"]),
        (&json!("lariat bench"), &json!(1))
    );
    let measured = summary["measured"].as_array().expect("a list");
    let find = |id: &str| measured.iter().find(|item| item["id"] == id);
    for id in [
        "floor.read.640x480",
        "floor.copy.640x480",
        "floor.wake.futex.one_core",
        "floor.wake.eventfd.one_core",
        "floor.timer",
        "floor.relay.free@120",
        "floor.relay.one_core@120",
        "chain.640x480@120",
        "chain.640x480@1000",
        "rival.threads",
        "rival.sockets",
    ] {
        let p50 = find(id).map(|item| item["figures"]["p50_us"]["median"].as_f64());
        assert!(
            p50.flatten().is_some_and(|us| us > 0.0),
            "{id} in {summary}"
        );
        assert!(out.join(format!("{id}.hgrm")).exists(), "{id}.hgrm");
    }
    for (id, figure) in [
        ("chain.640x480@120", "overhead_to_floor_p50"),
        ("chain.640x480@120", "cpu_percent"),
        ("chain.start", "start_ms"),
        ("chain.start", "resident_mb"),
        ("chain.idle", "idle_cpu_percent"),
    ] {
        let value = find(id).map(|item| &item["figures"][figure]["median"]);
        assert!(value.is_some_and(Value::is_number), "{figure} in {summary}");
    }
    for id in ["rival.zmq", "rival.zenoh", "rival.python_chain"] {
        assert!(
            find(id).is_some_and(|item| item["missing"].is_string()),
            "{id}"
        );
    }

    let page = fs::read_to_string(out.join("report.html")).expect("a report");
    assert_well_formed(&page);
    assert!(page.contains("<polyline") && page.contains("chain") && page.contains("kernel"));
    // The page opens offline: the only address in it is a namespace.
    let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    assert!(!page.contains("http") && !page.contains("src=") && !page.contains("href="));
}

#[test]
fn a_bench_that_is_stopped_or_killed_takes_everything_along() {
    // A killed bench leaves its temporary folder behind. It is inside this one.
    let folder = TempDir::new().expect("a folder");
    for signal in [Signal::INT, Signal::KILL] {
        let mut bench = lariat_bench(&[
            "latency",
            "--load",
            "--fps",
            "200",
            "--rounds",
            "1",
            "--python",
            "/nonexistent/python",
        ])
        .env("TMPDIR", folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
        let id = bench.id();
        wait_until("a channel", || {
            left_of(id).iter().any(|name| name.ends_with(".data"))
        });
        kill_process(Pid::from_child(&bench), signal).expect("it runs");
        let status = bench.wait().expect("waited for");
        assert!(!status.success());
        wait_until("gone", || {
            left_of(id).iter().all(|name| !name.starts_with("process"))
        });
        if signal == Signal::INT {
            let mut said = String::new();
            let stderr = bench.stderr.as_mut().expect("piped");
            std::io::Read::read_to_string(stderr, &mut said).expect("readable");
            assert!(said.contains("stopped by a signal"), "{said}");
            assert!(left_of(id).is_empty(), "{:?}", left_of(id));
        }
        // A killed bench cannot clean up. Its programs, or the next one in the domain, remove their
        // shared memory.
        for name in left_of(id) {
            let _ = fs::remove_file(Path::new("/dev/shm").join(name));
        }
        let _ = fs::remove_dir_all(format!("/tmp/lariat-b{id}"));
    }
}

/// Returns a bench's summary with these chain latencies in five rounds.
fn a_bench(p50_us: [f64; 5]) -> Value {
    let mut sorted = p50_us;
    sorted.sort_by(f64::total_cmp);
    let figure = |factor: f64| {
        json!({"median": factor * sorted[2], "low": factor * sorted[0], "high": factor * sorted[4],
               "rounds": p50_us.map(|us| factor * us)})
    };
    json!({
        "kind": "lariat bench", "schema": 1, "machine": {"cpu": "Example", "cores": 2},
        "measured": [
            {"id": "chain.640x480@120", "group": "chain", "figures": {"p50_us": figure(1.0)}},
            {"id": "chain.640x480@max", "group": "chain", "figures": {"rate_per_s": figure(10.0)}},
            {"id": "floor.timer", "group": "floor", "figures": {"p50_us": figure(0.1)}},
            // A percentile that only one round had enough frames for does not count.
            {"id": "chain.640x480@30", "group": "chain", "figures": {
                "p99_us": {"median": p50_us[0].powi(2), "low": 1.0, "high": 1.0, "rounds": [1.0]}}},
        ],
    })
}

fn compare(a: &Value, b: &Value) -> Output {
    let folder = TempDir::new().expect("a folder");
    let [before, now] = [("a.json", a), ("b.json", b)].map(|(name, summary)| {
        let path = folder.path().join(name);
        fs::write(&path, summary.to_string()).expect("written");
        path
    });
    lariat_bench(&["compare"])
        .arg(before)
        .arg(now)
        .output()
        .expect("the binary runs")
}

#[test]
fn worse_is_a_failure_and_better_is_none() {
    let (before, now) = (
        a_bench([100.0, 101.0, 99.0, 102.0, 98.0]),
        a_bench([150.0, 151.0, 149.0, 152.0, 148.0]),
    );
    let worse = compare(&before, &now);
    let said = String::from_utf8_lossy(&worse.stdout);
    assert_eq!(worse.status.code(), Some(1), "{said}");
    assert!(
        said.contains("chain.640x480@120: p50_us") && said.contains("+50 %"),
        "{said}"
    );
    // Figures of other systems are shown but do not count. A higher frame rate is better.
    assert!(
        said.contains("worse, not lariat") && said.contains("1 worse, 1 better"),
        "{said}"
    );
    let mut without_rate = [now.clone(), before.clone()];
    for summary in &mut without_rate {
        summary["measured"]
            .as_array_mut()
            .expect("a list")
            .remove(1);
    }
    let better = compare(&without_rate[0], &without_rate[1]);
    let said = String::from_utf8_lossy(&better.stdout);
    assert!(
        better.status.success() && said.contains("0 worse, 1 better"),
        "{said}"
    );
}

#[test]
fn what_is_within_the_noise_is_no_change() {
    let (before, now) = (
        a_bench([100.0, 120.0, 90.0, 110.0, 95.0]),
        a_bench([110.0, 130.0, 105.0, 120.0, 100.0]),
    );
    let same = compare(&before, &now);
    let said = String::from_utf8_lossy(&same.stdout);
    assert!(same.status.success(), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(
        said.starts_with("0 worse, 0 better, 2 within the noise"),
        "{said}"
    );
}

#[test]
fn single_runs_are_compared_by_their_own_distribution() {
    let run = |factor: f64| {
        let us = |us: f64| factor * us;
        let spread = json!({"p50": us(100.0), "p90": us(130.0), "p99": us(200.0), "p999": us(300.0), "max": us(400.0)});
        json!({
            "schema": 1, "machine": {"cpu": "Example", "cores": 2}, "latency_us": {"total": spread},
            "frames": {"published": 3000, "received": 3000, "lost": {"source": 0, "capture": 0}},
        })
    };
    let same = compare(&run(1.0), &run(1.02));
    assert!(
        same.status.success(),
        "{}",
        String::from_utf8_lossy(&same.stdout)
    );
    let worse = compare(&run(1.0), &run(1.5));
    let said = String::from_utf8_lossy(&worse.stdout);
    assert_eq!(worse.status.code(), Some(1), "{said}");
    assert!(said.contains("total: p50"), "{said}");
    let mixed = compare(&run(1.0), &a_bench([1.0; 5]));
    let said = String::from_utf8_lossy(&mixed.stderr);
    assert!(
        !mixed.status.success() && said.contains("compare two of one kind"),
        "{said}"
    );
}

#[test]
fn what_is_no_summary_is_named() {
    let missing = lariat_bench(&["compare", "/nonexistent/a", "/nonexistent/b"])
        .output()
        .expect("the binary runs");
    let said = String::from_utf8_lossy(&missing.stderr);
    assert!(
        !missing.status.success() && said.contains("/nonexistent/a cannot be read"),
        "{said}"
    );
    let nothing = compare(&json!({}), &json!({}));
    let said = String::from_utf8_lossy(&nothing.stderr);
    assert!(
        !nothing.status.success() && said.contains("is not a summary of lariat"),
        "{said}"
    );
}
