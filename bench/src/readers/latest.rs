//! Cost of reading the latest message, in Rust and in C, in a tight loop and after a sleep, next to
//! the cost of the clock.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use crate::Table;
use anyhow::{Context, Result, ensure};
use lariat_wire::{Reader, Seen, now_ns};

use super::Place;
use super::counts::Counts;

/// Messages per second during the measurement.
const RATE: &str = "1000";
/// Maximum age of a message: longer than the measurement, so that none is too old.
const ANY_AGE: Duration = Duration::from_secs(3600);

/// Returns the table.
pub(super) fn measure(place: &Place, time: Duration) -> Result<Table> {
    let mut table = Table::new(&["a look, ns", "p50", "p99", "p99.9", "max", "looks"]);
    let writer = place.start(&["write", "--rate", RATE])?;
    let mut reader = place.reader()?;
    let first = reader.wait(Instant::now() + Duration::from_secs(20))?;
    ensure!(first.is_new(), "the writer's messages did not come");
    push(&mut table, "the clock alone", &clock(time / 4));
    for (name, counts) in look_on_and_on(&mut reader, time)? {
        push(&mut table, &format!("Rust: {name}"), &counts);
    }
    push(
        &mut table,
        "Rust: and the rope's middle",
        &whole(&mut reader, time)?,
    );
    push(
        &mut table,
        "Rust: after 1 ms of sleep",
        &after_sleeps(&mut reader, time)?,
    );
    match in_c(place, time) {
        Ok(text) => {
            for line in text.lines() {
                table.push(line.split('\t').map(String::from));
            }
        }
        Err(cause) => table.push([format!("C: not measured: {cause:#}")]),
    }
    writer.end()?;
    Ok(table)
}

fn push(table: &mut Table, name: &str, counts: &Counts) {
    let percentiles = [0.5, 0.99, 0.999, 1.0].map(|share| counts.percentile(share).to_string());
    let cells = [name.to_string()].into_iter().chain(percentiles);
    table.push(cells.chain([counts.count().to_string()]));
}

/// Measures the clock, whose cost is included in every time below.
fn clock(time: Duration) -> Counts {
    let mut counts = Counts::new();
    let end_ns = now_ns() + time.as_nanos() as u64;
    loop {
        let before_ns = now_ns();
        let after_ns = now_ns();
        counts.add(after_ns - before_ns);
        if after_ns >= end_ns {
            return counts;
        }
    }
}

/// Reads in a tight loop.
fn look_on_and_on(reader: &mut Reader, time: Duration) -> Result<[(&'static str, Counts); 2]> {
    let (mut same, mut new) = (Counts::new(), Counts::new());
    let end_ns = now_ns() + time.as_nanos() as u64;
    loop {
        let before_ns = now_ns();
        let is_new = reader.latest()?.is_new();
        let after_ns = now_ns();
        if is_new { &mut new } else { &mut same }.add(after_ns - before_ns);
        if after_ns >= end_ns {
            return Ok([("nothing new", same), ("a new message", new)]);
        }
    }
}

/// Reads the latest message, its rope and curve, and a point of it. Counts only reads of a new
/// message.
fn whole(reader: &mut Reader, time: Duration) -> Result<Counts> {
    let mut counts = Counts::new();
    let mut sum = 0.0;
    let end_ns = now_ns() + time.as_nanos() as u64;
    loop {
        let before_ns = now_ns();
        let frame = reader.latest()?;
        if let Seen::Fresh(rope) = frame.only_rope(ANY_AGE) {
            sum += rope.shape()?.point_at(0.5)[0];
        }
        let after_ns = now_ns();
        if frame.is_new() {
            counts.add(after_ns - before_ns);
        }
        if after_ns >= end_ns {
            std::hint::black_box(sum);
            return Ok(counts);
        }
    }
}

/// Reads after a sleep, like a controller with its own clock. The data has left the caches by then.
fn after_sleeps(reader: &mut Reader, time: Duration) -> Result<Counts> {
    let mut counts = Counts::new();
    let end_ns = now_ns() + time.as_nanos() as u64;
    loop {
        // The sleep is part of the measured case.
        std::thread::sleep(Duration::from_millis(1));
        let before_ns = now_ns();
        reader.latest()?;
        let after_ns = now_ns();
        counts.add(after_ns - before_ns);
        if after_ns >= end_ns {
            return Ok(counts);
        }
    }
}

/// Measures the same in a C program that is built here. Returns its rows, separated by tabs.
fn in_c(place: &Place, time: Duration) -> Result<String> {
    let this = std::env::current_exe().context("this program has no file")?;
    let built = this.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    ensure!(
        built.join("liblariat.so").exists(),
        "build the library first, by `cargo build --release -p lariat-c`"
    );
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/c");
    let prefix = place.folder.path().join("prefix");
    let program = place.folder.path().join("latest");
    done(
        Command::new(crates.join("install.sh"))
            .arg("--prefix")
            .arg(&prefix)
            .arg("--from")
            .arg(built),
    )?;
    done(
        Command::new("cc")
            .args(["-O2", "-Wall", "-o"])
            .arg(&program)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/readers/latest.c"))
            .arg(format!("-I{}", prefix.join("include").display()))
            .arg(format!("-L{}", prefix.join("lib").display()))
            .arg(format!("-Wl,-rpath,{}", prefix.join("lib").display()))
            .arg("-llariat"),
    )?;
    let seconds = time.as_secs_f64().to_string();
    done(
        Command::new(program)
            .arg(seconds)
            .env("LARIAT_DOMAIN", &place.domain),
    )
}

fn done(command: &mut Command) -> Result<String> {
    let output = command
        .output()
        .with_context(|| format!("{command:?} cannot be run"))?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    ensure!(output.status.success(), "{command:?}: {}", said.trim());
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
