//! The chain without control loops, with many, and with many while one is stopped and one is
//! killed.

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::{Samples, Table};
use anyhow::{Context, Result, bail, ensure};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use super::part::Saw;
use super::{Args, Part, Place};

/// The readers next to the chain.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Beside {
    Nobody,
    Readers,
    /// One is stopped for the middle third, and one is killed in the middle.
    Troubled,
}

const ALL: [Beside; 3] = [Beside::Nobody, Beside::Readers, Beside::Troubled];

/// Result of a run, for the chain and for the undisturbed readers.
struct Shown {
    p50_us: f64,
    p99_us: f64,
    frames: u64,
    lost: u64,
    saw: Vec<Saw>,
}

/// Returns the table, after measuring all three cases in turn in each round.
pub(super) fn measure(place: &Place, args: &Args) -> Result<Table> {
    let mut runs: [Vec<Shown>; 3] = Default::default();
    for round in 0..args.rounds.max(1) {
        for (beside, runs) in ALL.into_iter().zip(&mut runs) {
            runs.push(run(place, args, beside, round)?);
        }
    }
    let mut table = Table::new(&[
        "beside the chain",
        "frames",
        "lost",
        "exposed → received µs: p50",
        "p99",
        "missed by readers",
        "fitted → in hand µs: p50",
        "p99, worst",
    ]);
    for (beside, runs) in ALL.into_iter().zip(&runs) {
        let median = |of: fn(&Shown) -> f64| runs.iter().map(of).collect::<Samples>().median();
        let saw = || runs.iter().flat_map(|run| &run.saw);
        let name = match beside {
            Beside::Nobody => "nobody".to_string(),
            Beside::Readers => format!("{} readers", args.readers),
            Beside::Troubled => format!("{}, one stopped, one killed", args.readers),
        };
        let mut cells = vec![
            name,
            runs.iter().map(|run| run.frames).sum::<u64>().to_string(),
            runs.iter().map(|run| run.lost).sum::<u64>().to_string(),
            format!("{:.0}", median(|run| run.p50_us)),
            format!("{:.0}", median(|run| run.p99_us)),
        ];
        if beside != Beside::Nobody {
            let middle: Samples = saw().map(|saw| saw.p50_us).collect();
            let worst: Samples = saw().map(|saw| saw.p99_us).collect();
            let (frames, missed) =
                saw().fold((0, 0), |(f, m), saw| (f + saw.frames, m + saw.missed));
            cells.push(format!("{missed} of {}", frames + missed));
            cells.push(format!("{:.0}", middle.median()));
            cells.push(format!("{:.0}", worst.percentile(1.0)));
        }
        table.push(cells);
    }
    Ok(table)
}

fn run(place: &Place, args: &Args, beside: Beside, round: usize) -> Result<Shown> {
    let readers = match beside {
        Beside::Nobody => 0,
        _ => args.readers,
    };
    let started = (0..readers).map(|_| place.start(&["read"]));
    let mut readers: Vec<Part> = started.collect::<Result<_>>()?;
    let out = place
        .folder
        .path()
        .join(format!("{round}-{}", beside as u8));
    let binary = crate::program::lariat()?;
    let mut chain = Command::new(&binary)
        .args([
            "run",
            "--fps",
            &args.fps.to_string(),
            "--duration",
            &args.seconds.to_string(),
            "--out",
        ])
        .arg(&out)
        .current_dir(place.folder.path())
        .env("LARIAT_DOMAIN", &place.domain)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| format!("`{}` cannot be run", binary.display()))?;
    if beside == Beside::Troubled {
        trouble(&mut readers, Duration::from_secs_f64(args.seconds))?;
    }
    let status = chain.wait()?;
    if !status.success() {
        let mut said = String::new();
        if let Some(mut stderr) = chain.stderr.take() {
            std::io::Read::read_to_string(&mut stderr, &mut said)?;
        }
        bail!("the chain went wrong: {}", said.trim());
    }
    let mut saw = Vec::new();
    for reader in readers {
        saw.push(serde_json::from_str(&reader.end()?).context("a reader left no figures")?);
    }
    shown(&out.join("summary.json"), saw)
}

/// Stops one reader for a third of the time and kills another. The others continue and are
/// evaluated.
fn trouble(readers: &mut Vec<Part>, time: Duration) -> Result<()> {
    let (Some(stopped), Some(mut killed)) = (readers.pop(), readers.pop()) else {
        bail!("two readers are wanted for that");
    };
    let id = Pid::from_child(&stopped.process);
    // These sleeps are part of the measurement's schedule. They wait for no event.
    std::thread::sleep(time / 3);
    kill_process(id, Signal::STOP)?;
    std::thread::sleep(time / 6);
    killed.process.kill()?;
    std::thread::sleep(time / 6);
    kill_process(id, Signal::CONT)?;
    Ok(())
}

fn shown(summary: &std::path::Path, saw: Vec<Saw>) -> Result<Shown> {
    let text =
        std::fs::read(summary).with_context(|| format!("cannot read {}", summary.display()))?;
    let summary: Value = serde_json::from_slice(&text)?;
    let number = |path: &str| {
        let number = summary.pointer(path).and_then(Value::as_f64);
        number.with_context(|| format!("summary.json lacks {path}"))
    };
    let lost =
        ["source", "capture", "extract", "fit"].map(|link| number(&format!("/frames/lost/{link}")));
    let mut sum = 0.0;
    for lost in lost {
        sum += lost?;
    }
    let shown = Shown {
        p50_us: number("/latency_us/total/p50")?,
        p99_us: number("/latency_us/total/p99")?,
        frames: number("/frames/received")? as u64,
        lost: sum as u64,
        saw,
    };
    ensure!(shown.frames > 0, "no frame came through the chain");
    Ok(shown)
}
