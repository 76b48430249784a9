//! `summary.json` of a bench: every figure, round by round, under stable keys.

use std::collections::BTreeMap;

use lariat_sink::Machine;
use serde::Serialize;

use super::BenchArgs;
use super::figures::{Figure, Item};
use super::plan::Plan;
use super::targets::{Target, targets};

/// Identifies a file as the summary of a bench.
pub(crate) const KIND: &str = "lariat bench";

/// The whole measurement.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    kind: &'static str,
    /// Version of the keys.
    schema: u32,
    pub(super) machine: Machine,
    pub(super) parameters: BTreeMap<&'static str, String>,
    measured: Vec<Measured>,
    pub(super) targets: Vec<Target>,
}

#[derive(Debug, Serialize)]
struct Measured {
    id: String,
    group: &'static str,
    title: String,
    note: &'static str,
    #[serde(skip_serializing_if = "String::is_empty")]
    versions: String,
    /// The reason why figures are missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    missing: Option<String>,
    figures: BTreeMap<String, Merged>,
}

#[derive(Debug, Serialize)]
struct Merged {
    median: f64,
    low: f64,
    high: f64,
    rounds: Vec<f64>,
}

impl Summary {
    pub(super) fn new(plan: &Plan, args: &BenchArgs, rounds: u32, seconds: f64) -> Self {
        let ([width, height], fps) = plan.base;
        let flags = if args.flags.is_empty() {
            "none".to_owned()
        } else {
            args.flags.join(" ")
        };
        let parameters = BTreeMap::from([
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("rounds", rounds.to_string()),
            ("took_s", format!("{seconds:.0}")),
            ("compared_at", format!("{width}x{height}, {fps} frames/s")),
            ("flags_of_run", flags),
            ("load", args.load.to_string()),
            ("source", "rendered rope, seed 1".to_owned()),
            ("python", args.python.display().to_string()),
            (
                "build",
                if cfg!(debug_assertions) {
                    "debug"
                } else {
                    "release"
                }
                .to_owned(),
            ),
        ]);
        Self {
            kind: KIND,
            schema: 1,
            machine: Machine::this(),
            parameters,
            measured: plan.items.iter().map(measured).collect(),
            targets: targets(plan),
        }
    }
}

fn measured(item: &Item) -> Measured {
    let merged = |figure: &Figure| {
        let (low, high) = figure.range();
        let rounds = figure.rounds.iter().copied().map(short).collect();
        let merged = Merged {
            median: short(figure.median()),
            low: short(low),
            high: short(high),
            rounds,
        };
        (figure.name.clone(), merged)
    };
    Measured {
        id: item.id.clone(),
        group: item.group.name(),
        title: item.title.clone(),
        note: item.note,
        versions: item.versions.clone(),
        missing: item.missing.clone(),
        figures: item.figures.iter().map(merged).collect(),
    }
}

/// Rounds to a thousandth, which is finer than any measurement.
fn short(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}
