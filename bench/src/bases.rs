//! `lariat-bench bases`: runs the whole chain on the rendered rope with each basis and option,
//! and measures the distance of its curves from the true rope.

use std::path::Path;
use std::process::Command;

use crate::Table;
use anyhow::{Context, Result, bail};
use serde_json::Value;

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Number of frames of each run
    #[arg(long, value_name = "N", default_value_t = 600)]
    frames: u64,
}

/// The flags of each run.
const RUNS: [&[&str]; 22] = [
    &["--basis", "auto"],
    &["--basis", "auto", "--filter"],
    &["--control-points", "3"],
    &["--control-points", "5"],
    &["--control-points", "7"],
    &["--control-points", "9"],
    &["--control-points", "13"],
    &["--control-points", "17"],
    &["--control-points", "auto"],
    &["--basis", "bspline", "--control-points", "9"],
    &["--basis", "bspline", "--control-points", "13"],
    &["--basis", "bspline", "--control-points", "17"],
    &[
        "--basis",
        "bspline",
        "--control-points",
        "17",
        "--knots",
        "averaged",
    ],
    &["--basis", "bspline", "--control-points", "auto"],
    &["--basis", "rational", "--control-points", "9"],
    &["--basis", "points", "--control-points", "9"],
    &["--basis", "mass"],
    &["--control-points", "13", "--robust"],
    &["--control-points", "13", "--pin-ends"],
    &["--control-points", "13", "--ridge", "0.001"],
    &["--control-points", "13", "--rho", "measured"],
    &["--control-points", "13", "--filter"],
];

/// Runs the chain and prints the table.
///
/// # Errors
/// A run fails, or its summary cannot be read.
pub(crate) fn run(args: &Args) -> Result<()> {
    let mut table = Table::new(&[
        "flags",
        "frames",
        "curve px: mean",
        "p95",
        "max",
        "fit µs: p50",
        "p99",
    ]);
    for flags in RUNS {
        let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
        let summary = summary(args, flags, folder.path())?;
        let at = |path: &str| match summary.pointer(path) {
            Some(number) => number.to_string(),
            None => "-".to_owned(),
        };
        let px = |name: &str| match summary.pointer(&format!("/error_px/curve/{name}")) {
            Some(number) => format!("{:.3}", number.as_f64().unwrap_or(f64::NAN)),
            None => "-".to_owned(),
        };
        let us = |name: &str| at(&format!("/latency_us/fit/{name}"));
        table.push([
            flags.join(" "),
            at("/frames/with_curve"),
            px("mean"),
            px("p95"),
            px("max"),
            us("p50"),
            us("p99"),
        ]);
    }
    print!("{table}")?;
    Ok(())
}

fn summary(args: &Args, flags: &[&str], folder: &Path) -> Result<Value> {
    // The run has a folder of its own that contains no settings file.
    let binary = crate::program::lariat()?;
    let output = Command::new(&binary)
        .args(["run", "--fps", "max", "--lossless", "--frames"])
        .arg(args.frames.to_string())
        .arg("--out")
        .arg(folder)
        .args(flags)
        .current_dir(folder)
        .output()
        .with_context(|| format!("`{}` cannot be run", binary.display()))?;
    if !output.status.success() {
        bail!(
            "the chain with {} went wrong: {}",
            flags.join(" "),
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    let file = folder.join("summary.json");
    let text = std::fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
    Ok(serde_json::from_slice(&text)?)
}
