//! The table: the chain and the systems it is compared with, the parts of its latency, and the
//! targets.

use std::fmt::Write;

use lariat_sink::{Figure as Digits, Micros};

use lariat_chain::layout::{self, Column, Table, hanging};

use super::figures::{Figure, Group, Item};
use super::plan::Plan;
use super::summary::Summary;

/// Returns the table as text.
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

/// Returns all timed items: the total latency, its noise, and the chain's own overhead.
fn whole(plan: &Plan) -> String {
    let columns = vec![
        Column::words("exposed → received, µs"),
        Column::figures("p50"),
        Column::figures("±"),
        Column::figures("p99"),
        Column::figures("p99.9").rank(1),
        Column::figures("max").rank(2),
        Column::figures("overhead\np50"),
        Column::figures("p99"),
        Column::figures("× floor\np50"),
        Column::figures("p99"),
    ];
    let mut rows = Vec::new();
    for (group, title) in [
        (Group::Chain, "lariat"),
        (Group::Floor, "floors"),
        (Group::Rival, "others"),
    ] {
        rows.push(vec![title.to_owned()]);
        let timed = |item: &&Item| item.group == group && item.times.is_some();
        for item in plan.items.iter().filter(timed) {
            let cell = |name| Digits(item.median(name)).to_string();
            let time = |name| Micros(item.median(name)).to_string();
            let mut row = vec![
                format!("  {}", item.title),
                time("p50_us"),
                half_spread(item),
            ];
            row.extend(["p99_us", "p999_us", "max_us"].map(time));
            if group != Group::Floor && item.figure("overhead_p50_us").is_some() {
                row.extend(["overhead_p50_us", "overhead_p99_us"].map(time));
            }
            if group == Group::Chain {
                row.extend(["overhead_to_floor_p50", "overhead_to_floor_p99"].map(cell));
            }
            rows.push(row);
        }
    }
    Table::text(columns, &rows, layout::width())
}

/// Returns half the range of the rounds' medians.
fn half_spread(item: &Item) -> String {
    let rounds = |figure: &&Figure| figure.rounds.len() > 1;
    item.figure("p50_us").filter(rounds).map_or_else(
        || "–".to_owned(),
        |figure| {
            let (low, high) = figure.range();
            Micros(Some((high - low) / 2.0)).to_string()
        },
    )
}

/// Returns the median times of the chain's parts, its losses and its resource use.
fn pieces(plan: &Plan) -> String {
    let columns = vec![
        Column::words("of it, µs (p50)"),
        Column::figures("late"),
        Column::figures("wait"),
        Column::figures("extract"),
        Column::figures("wait"),
        Column::figures("fit"),
        Column::figures("wait"),
        Column::figures("jitter\np99").rank(1),
        Column::figures("lost"),
        Column::figures("of").rank(3),
        Column::figures("frames\n/s"),
        Column::figures("CPU\n%").rank(2),
    ];
    let mut rows = Vec::new();
    let has_stages = |item: &&Item| item.figure("extract_p50_us").is_some();
    for item in plan.items.iter().filter(has_stages) {
        let cell = |name| Digits(item.median(name)).to_string();
        let time = |name| Micros(item.median(name)).to_string();
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
            .map(time),
        );
        row.extend([
            count("lost"),
            count("frames"),
            cell("rate_per_s"),
            cell("cpu_percent"),
        ]);
        rows.push(row);
    }
    Table::text(columns, &rows, layout::width())
}

/// Returns the targets, missing items, and notes on how to read the table.
fn footing(plan: &Plan, summary: &Summary) -> String {
    let width = layout::width();
    let mut text = String::from("to reach\n");
    let say = |text: &mut String, sentence: &str| {
        let _ = writeln!(text, "{}", hanging(sentence, 2, width));
    };
    for target in &summary.targets {
        let verdict = if target.met { "met" } else { "not met" };
        say(
            &mut text,
            &format!("  {verdict}: {}: {}", target.name, target.figure),
        );
    }
    if let Some(floor) = plan.relay_floor(Some(plan.base.1), "p50_us") {
        let sentence = format!(
            "overhead: the whole way without the work of extract and fit. × floor: that, divided by four processes in the \
             arrangement that is best in the same percentile (\"{}\" for p50), round by round. ±: half of what lies \
             between the least and the greatest round. late: how long after a frame was due it was sent.",
            floor.title
        );
        text.push('\n');
        say(&mut text, &sentence);
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
        say(
            &mut text,
            &format!("{}{versions}: {}.", item.title, item.note),
        );
    }
    let mut said: Vec<&String> = Vec::new();
    for item in &plan.items {
        if let Some(why) = item.missing.as_ref().filter(|why| !said.contains(why)) {
            say(
                &mut text,
                &format!("Not measured: {}, as {why}.", item.title),
            );
            said.push(why);
        }
    }
    text
}
