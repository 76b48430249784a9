//! Targets and whether they are met.

use serde::Serialize;

use super::figures::{Figure, Item};
use super::plan::{Plan, SIZE, TIMER_FIFO};

/// A target and its figure.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Target {
    pub(super) name: String,
    pub(super) figure: String,
    pub(super) met: bool,
}

/// Returns the targets for which there is a measurement.
pub(super) fn targets(plan: &Plan) -> Vec<Target> {
    let [overhead, overhead_99] = over_floor(plan);
    let by_id = |id: &str| plan.items.iter().find(|item| item.id == id);
    [
        overhead,
        overhead_99,
        nothing_lost(plan),
        steady(plan),
        loaded(plan),
        by_id("chain.start")
            .and_then(|item| at_most(item, "resident_mb", 64.0, "resident, the whole chain", "MB")),
        by_id("chain.start")
            .and_then(|item| at_most(item, "start_ms", 300.0, "start to first descriptor", "ms")),
        // A tenth of a percent is the cost of waking ten times per second to check for work.
        by_id("chain.idle").and_then(|item| {
            at_most(
                item,
                "idle_cpu_percent",
                0.1,
                "CPU while no frames come",
                "%",
            )
        }),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Compares the better of the default and the real-time chain with the floor.
fn over_floor(plan: &Plan) -> [Option<Target>; 2] {
    let (size, fps) = plan.base;
    let base = |behind: &str| plan.chain_at(size, fps, behind);
    [
        ("overhead_to_floor_p50", "p50"),
        ("overhead_to_floor_p99", "p99"),
    ]
    .map(|(figure, quantile)| {
        let default = base("").and_then(|item| item.median(figure));
        let realtime = base(".realtime").and_then(|item| item.median(figure));
        let (figure, best) = either(default?, realtime, |ratio| format!("{ratio:.2} ×"));
        Some(Target {
            name: format!("overhead ≤ 1.5 × four processes of 64 bytes, {quantile}"),
            figure,
            met: best <= 1.5,
        })
    })
}

/// Returns the figures of a chain and, if this release has the flag, of the same chain with
/// `--realtime`. Also returns the lesser value.
fn either(plain: f64, realtime: Option<f64>, show: impl Fn(f64) -> String) -> (String, f64) {
    match realtime {
        None => (show(plain), plain),
        Some(other) => {
            let shown = format!("{}, with --realtime {}", show(plain), show(other));
            (shown, plain.min(other))
        }
    }
}

fn nothing_lost(plan: &Plan) -> Option<Target> {
    let lost = |behind: &str| {
        let figure = plan.chain_at(SIZE, 1000.0, behind)?.figure("lost")?;
        Some(figure.rounds.iter().sum::<f64>())
    };
    let (figure, best) = either(lost("")?, lost(".realtime"), |lost| format!("{lost} lost"));
    Some(Target {
        name: "640×480 at 1000 frames/s, nothing lost".to_owned(),
        figure,
        met: best == 0.0,
    })
}

fn steady(plan: &Plan) -> Option<Target> {
    let ratio = |behind: &str| {
        let item = plan.chain_at(SIZE, 1000.0, behind)?;
        Some(item.median("p999_us")? / item.median("p50_us")?)
    };
    let (mut figure, best) = either(ratio("")?, ratio(".realtime"), |ratio| {
        format!("{ratio:.1} ×")
    });
    // Occasional delays of the machine itself affect this figure too.
    let id = format!("floor.{TIMER_FIFO}");
    let timer = plan.items.iter().find(|item| item.id == id);
    if let Some(late_us) = timer.and_then(|item| item.median("p999_us")) {
        let late = lariat_sink::Figure(Some(late_us));
        figure += &format!("; a bare timer's p99.9 is {late} µs");
    }
    Some(Target {
        name: "the same, p99.9 ≤ 5 × p50".to_owned(),
        figure,
        met: best <= 5.0,
    })
}

/// Compares the chain at 1000 frames/s under load with the idle machine. Uses `--realtime` if this
/// release has it.
fn loaded(plan: &Plan) -> Option<Target> {
    let at = |behind: &str| plan.chain_at(SIZE, 1000.0, behind);
    let (load, idle, with) = match at(".realtime.load") {
        Some(load) => (load, at(".realtime")?, " --realtime"),
        None => (at(".load")?, at("")?, ""),
    };
    let ratio = load.median("p999_us")? / idle.median("p999_us")?;
    Some(Target {
        name: format!("the same{with}, every core busy: p99.9 ≤ 3 × the idle one"),
        figure: format!("{ratio:.1} ×"),
        met: ratio <= 3.0,
    })
}

fn at_most(item: &Item, figure: &str, most: f64, name: &str, unit: &str) -> Option<Target> {
    let value = item.figure(figure).map(Figure::median)?;
    Some(Target {
        name: format!("{name} ≤ {most} {unit}"),
        figure: format!("{} {unit}", lariat_sink::Figure(Some(value))),
        met: value <= most,
    })
}
