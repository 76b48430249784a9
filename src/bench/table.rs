//! The table: the chain and what it is held against, where its time goes, what is reached.

use std::fmt::Write;

use lariat_bench::Table;
use lariat_sink::Figure as Digits;

use super::figures::{Figure, Group, Item};
use super::plan::Plan;
use super::summary::Summary;

/// The table as text.
pub(super) fn table(plan: &Plan, summary: &Summary) -> String {
    let machine = &summary.machine;
    let unknown = "unknown processor".to_owned();
    let mut text = format!(
        "{}, {} cores, {}\nrounds: {} in {} s; each figure is the median of its rounds\n",
        machine.cpu.as_ref().unwrap_or(&unknown),
        machine.cores.unwrap_or(0),
        machine.kernel,
        summary.parameters["rounds"],
        summary.parameters["took_s"],
    );
    if cfg!(debug_assertions) {
        text += "! This lariat was built without optimization: `cargo build --release` for figures that count.\n";
    }
    let _ = write!(text, "\n{}", whole(plan));
    let _ = write!(text, "\n{}", pieces(plan));
    let _ = write!(text, "\n{}", footing(plan, summary));
    text
}

/// All that was timed: the whole way, its noise, and what the chain itself costs.
fn whole(plan: &Plan) -> Table {
    let mut table = Table::new(&[
        "exposed → received, µs",
        "p50",
        "±",
        "p99",
        "p99.9",
        "max",
        "overhead p50",
        "p99",
        "× floor p50",
        "p99",
    ]);
    for (group, title) in [
        (Group::Chain, "lariat"),
        (Group::Floor, "floors"),
        (Group::Rival, "others"),
    ] {
        table.push([title.to_owned()]);
        let timed = |item: &&Item| item.group == group && item.times.is_some();
        for item in plan.items.iter().filter(timed) {
            let cell = |name| Digits(item.median(name)).to_string();
            let mut row = vec![
                format!("  {}", item.title),
                cell("p50_us"),
                half_spread(item),
            ];
            row.extend(["p99_us", "p999_us", "max_us"].map(cell));
            if group != Group::Floor && item.figure("overhead_p50_us").is_some() {
                row.extend(["overhead_p50_us", "overhead_p99_us"].map(cell));
            }
            if group == Group::Chain {
                row.extend(["overhead_to_floor_p50", "overhead_to_floor_p99"].map(cell));
            }
            table.push(row);
        }
    }
    table
}

/// Half of the way from the least to the greatest median of a round.
fn half_spread(item: &Item) -> String {
    let rounds = |figure: &&Figure| figure.rounds.len() > 1;
    item.figure("p50_us").filter(rounds).map_or_else(
        || "–".to_owned(),
        |figure| {
            let (low, high) = figure.range();
            Digits(Some((high - low) / 2.0)).to_string()
        },
    )
}

/// Where the time of the chain goes, by medians, and what it loses and uses.
fn pieces(plan: &Plan) -> Table {
    let mut table = Table::new(&[
        "of it, µs (p50)",
        "late",
        "wait",
        "extract",
        "wait",
        "fit",
        "wait",
        "jitter p99",
        "lost",
        "of",
        "frames/s",
        "CPU %",
    ]);
    let has_stages = |item: &&Item| item.figure("extract_p50_us").is_some();
    for item in plan.items.iter().filter(has_stages) {
        let cell = |name| Digits(item.median(name)).to_string();
        let count = |name: &str| {
            let total = item
                .figure(name)
                .map(|figure| figure.rounds.iter().sum::<f64>());
            total.map_or_else(|| "–".to_owned(), |total| format!("{total:.0}"))
        };
        let mut row = vec![item.title.clone()];
        row.extend(
            [
                "late_p50_us",
                "wait_extract_p50_us",
                "extract_p50_us",
                "wait_fit_p50_us",
                "fit_p50_us",
                "wait_sink_p50_us",
                "jitter_p99_us",
            ]
            .map(cell),
        );
        row.extend([
            count("lost"),
            count("frames"),
            cell("rate_per_s"),
            cell("cpu_percent"),
        ]);
        table.push(row);
    }
    table
}

/// What is reached, what is missing, and how to read it.
fn footing(plan: &Plan, summary: &Summary) -> String {
    let mut table = Table::new(&["to reach"]);
    for target in &summary.targets {
        let verdict = if target.met { "met" } else { "not met" };
        table.push([
            target.name.clone(),
            target.figure.clone(),
            verdict.to_owned(),
        ]);
    }
    let mut text = table.to_string();
    if let Some(floor) = plan.relay_floor(Some(plan.base.1), "p50_us") {
        let _ = write!(
            text,
            "\noverhead: the whole way without the work of extract and fit. × floor: that, divided by four processes in the \
             arrangement that is best in the same percentile\n(\"{}\" for p50), round by round. ±: half of what lies \
             between the least and the greatest round. late: how long after a frame was due it was sent.\n",
            floor.title
        );
    }
    for item in plan
        .items
        .iter()
        .filter(|item| item.group == Group::Rival && item.missing.is_none())
    {
        let versions = if item.versions.is_empty() {
            String::new()
        } else {
            format!(" ({})", item.versions)
        };
        let _ = writeln!(text, "{}{versions}: {}.", item.title, item.note);
    }
    let mut said: Vec<&String> = Vec::new();
    for item in &plan.items {
        if let Some(why) = item.missing.as_ref().filter(|why| !said.contains(why)) {
            let _ = writeln!(text, "Not measured: {}, as {why}.", item.title);
            said.push(why);
        }
    }
    text
}
