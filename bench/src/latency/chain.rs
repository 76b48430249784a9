//! The chain itself: `lariat run` as a user starts it, and the figures of its own report.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use lariat_sink::Times;
use lariat_wire::{Domain, Receiver};
use serde_json::Value;

use super::figures::Outcome;
use super::guard::{Guarded, Placement, end_all};
use super::usage;
use super::workplace::Workplace;

/// Time limit for starting and for ending a chain.
const AROUND: Duration = Duration::from_secs(30);

/// One configuration of the chain.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setup {
    pub(super) size: [u32; 2],
    /// Frames per second. `None`: as fast as possible, without losses.
    pub(super) fps: Option<f64>,
    /// The user's flags for `lariat run`.
    pub(super) flags: Vec<String>,
    /// An additional flag of `lariat run`.
    pub(super) variant: Option<&'static str>,
    /// True if a spinning program keeps every core busy.
    pub(super) load: bool,
    /// True if a second chain runs at the same time.
    pub(super) second: bool,
}

impl Setup {
    /// Returns the arguments of `lariat run`.
    fn arguments(&self, rig: &str, time: Duration) -> Vec<String> {
        let [width, height] = self.size;
        let mut words = vec![
            format!("--size={width}x{height}"),
            format!("--duration={}s", time.as_secs_f64()),
            format!("--rig={rig}"),
        ];
        match self.fps {
            Some(fps) => words.push(format!("--fps={fps}")),
            None => words.extend(["--fps=max".to_owned(), "--lossless".to_owned()]),
        }
        words.extend(self.flags.iter().cloned());
        words.extend(self.variant.map(|flag| format!("--{flag}")));
        words
    }
}

/// Runs the chain for `time`.
pub(super) fn measure(workplace: &Workplace, setup: &Setup, time: Duration) -> Result<Outcome> {
    let mut beside = Vec::new();
    if setup.load {
        for &core in &workplace.cores {
            let placement = Placement {
                core: Some(core),
                fifo: false,
            };
            let mut command = workplace.part(placement, "spin");
            beside.push(Guarded::start(&mut command)?);
        }
    }
    if setup.second {
        let mut command = workplace.lariat(Placement::default());
        // Its time is longer than the first chain's, but it is stopped when the first chain ends.
        command
            .arg("run")
            .args(setup.arguments("beside", time + AROUND));
        beside.push(Guarded::start(&mut command)?);
        // Wait until it has started, because starting costs more than running.
        workplace.sleep(Duration::from_millis(500))?;
    }
    let out = workplace.path("chain");
    let mut command = workplace.lariat(Placement::default());
    command.arg("run").args(setup.arguments("bench", time));
    command.arg("--out").arg(&out);
    let measured = watch(workplace, &mut command, time, &out, "the chain");
    end_all(beside);
    measured
}

/// Runs a program that reports like a chain, and measures its CPU use.
pub(super) fn watch(
    workplace: &Workplace,
    command: &mut Command,
    time: Duration,
    out: &Path,
    what: &str,
) -> Result<Outcome> {
    let program = Guarded::start(command)?;
    let percent = cpu_percent(workplace, &[program.id()], time)?;
    workplace.finish(program, time + AROUND, what)?;
    let outcome = read(out, time, what);
    let _ = fs::remove_dir_all(out);
    let mut outcome = outcome?;
    outcome.figures.push(("cpu_percent", percent));
    Ok(outcome)
}

/// Returns the share of one core that programs and their children use, in percent. It is measured
/// over the middle of `time`, without their start.
pub(super) fn cpu_percent(workplace: &Workplace, programs: &[u32], time: Duration) -> Result<f64> {
    workplace.sleep(time / 2)?;
    let family = usage::family(programs);
    let (start, before_ns) = (Instant::now(), usage::on_core_ns(&family));
    workplace.sleep(time.mul_f64(0.45))?;
    let used_ns = usage::on_core_ns(&family).saturating_sub(before_ns);
    Ok(100.0 * used_ns as f64 / start.elapsed().as_nanos() as f64)
}

/// Reads the report that a chain wrote.
pub(super) fn read(out: &Path, time: Duration, what: &str) -> Result<Outcome> {
    let summary = fs::read_to_string(out.join("summary.json"))
        .with_context(|| format!("{what} left no report"))?;
    let summary: Value = serde_json::from_str(&summary)?;
    let received = summary["frames"]["received"].as_u64().unwrap_or(0);
    ensure!(received > 0, "{what} received no frame in {time:?}");
    let times = |row: &str| {
        let text = fs::read_to_string(out.join(format!("{row}.hgrm")))?;
        Times::from_hgrm(&text).with_context(|| format!("{what} left no {row}.hgrm"))
    };
    let mut outcome = Outcome::of_times(times("total")?);
    for (row, p50, p99) in [
        ("overhead", "overhead_p50_us", "overhead_p99_us"),
        ("links", "links_p50_us", "links_p99_us"),
        ("jitter", "jitter_p50_us", "jitter_p99_us"),
    ] {
        outcome.add_percentiles([(p50, 0.5), (p99, 0.99)], &times(row)?);
    }
    for (row, name) in [
        ("capture", "late_p50_us"),
        ("wait_extract", "wait_extract_p50_us"),
        ("extract", "extract_p50_us"),
        ("wait_fit", "wait_fit_p50_us"),
        ("fit", "fit_p50_us"),
        ("wait_sink", "wait_sink_p50_us"),
    ] {
        let us = summary["latency_us"][row]["p50"].as_f64();
        outcome.figures.extend(us.map(|us| (name, us)));
    }
    let lost = summary["frames"]["lost"].as_object();
    let lost = lost.map_or(0, |lost| lost.values().filter_map(Value::as_u64).sum());
    outcome.figures.push(("lost", lost as f64));
    outcome.figures.push(("frames", received as f64));
    let rate_per_s = received as f64 / time.as_secs_f64();
    outcome.figures.push(("rate_per_s", rate_per_s));
    Ok(outcome)
}

/// Measures the time from the command until a reader has the first descriptor, and the resident
/// memory half a second later.
pub(super) fn start(workplace: &Workplace, setup: &Setup) -> Result<Outcome> {
    let domain = Domain::named(&workplace.domain)?;
    let reader = Receiver::descriptors(&domain, &"bench".parse()?)?;
    let mut command = workplace.lariat(Placement::default());
    command.arg("run").args(setup.arguments("bench", AROUND));
    let begin = Instant::now();
    let program = Guarded::start(&mut command)?;
    let deadline = begin + AROUND;
    while reader.latest()?.is_none() {
        ensure!(!workplace.stop.asked(), "a signal stopped the measurement");
        ensure!(
            Instant::now() < deadline,
            "the chain sent no descriptor in {AROUND:?}"
        );
        reader.sleep(
            Some(deadline),
            Some(std::os::fd::AsFd::as_fd(&workplace.stop)),
        )?;
    }
    let start_ms = begin.elapsed().as_secs_f64() * 1e3;
    // The reader would share the pages that are counted, so it is dropped first.
    drop((reader, domain));
    workplace.sleep(Duration::from_millis(500))?;
    let resident_mb = usage::resident_mb(&usage::family(&[program.id()]));
    program.ask_to_end();
    workplace.finish(program, AROUND, "the chain")?;
    let mut outcome = Outcome::default();
    outcome.figures.push(("start_ms", start_ms));
    outcome
        .figures
        .extend(resident_mb.map(|mb| ("resident_mb", mb)));
    Ok(outcome)
}

/// Measures the CPU use of the three waiting stages while no frames arrive.
pub(super) fn idle(workplace: &Workplace, time: Duration) -> Result<Outcome> {
    let mut stages = Vec::new();
    for stage in ["sink", "fit", "extract"] {
        let mut command = workplace.lariat(Placement::default());
        command
            .args([stage, "--rig=idle"])
            .stderr(std::process::Stdio::null());
        stages.push(Guarded::start(&mut command)?);
    }
    // Wait until they have started.
    workplace.sleep(Duration::from_millis(500))?;
    let ids: Vec<u32> = stages.iter().map(Guarded::id).collect();
    let percent = cpu_percent(workplace, &ids, time)?;
    end_all(stages);
    let mut outcome = Outcome::default();
    outcome.figures.push(("idle_cpu_percent", percent));
    Ok(outcome)
}
