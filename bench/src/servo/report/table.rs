//! The table: how often, how fast and how well ropes reached the target.

use super::summary::Summary;
use super::{Group, Study};
use crate::servo::judge::REACHED_PX;
use lariat_chain::layout::{self, Column, Table, wrapped};

/// Headings of the numbers, in the table's order. For lifted ropes, px becomes mm.
pub(super) const HEAD: [&str; 7] = [
    "reached",
    "time to 5 px, s",
    "p90",
    "overshoot, px",
    "worst",
    "final error, px",
    "worst",
];

/// Returns the table as text, with an explanation of its columns.
pub(crate) fn table(study: &Study) -> String {
    let title = format!("to the target {}", study.target);
    let figures = HEAD.map(|heading| Column::figures(wrapped(&study.in_unit(heading), 9)));
    let columns = std::iter::once(Column::words(title)).chain(figures);
    let mut lines = Vec::new();
    for (group, rows) in study.groups() {
        if group != Group::AsItIs {
            lines.push(vec![group.title().to_owned()]);
        }
        for row in rows {
            let indent = if group == Group::AsItIs { "" } else { "  " };
            let name = format!("{indent}{}", row.name);
            lines.push(
                std::iter::once(name)
                    .chain(cells(&Summary::of(row)))
                    .collect(),
            );
        }
    }
    let width = layout::width();
    let table = Table::text(columns.collect(), &lines, width);
    format!("{table}\n{}\n", wrapped(&study.in_unit(&meaning()), width))
}

/// Explains the columns.
pub(super) fn meaning() -> String {
    format!(
        "reached: ropes that are at the target in the end, at most {REACHED_PX} px from it on average. time: from the first \
         image until they\ncame there to stay, for half of all ropes and for nine tenths (–: fewer came). overshoot: how far \
         beyond {REACHED_PX} px they went again\nonce they had been there, median and worst. final error: mean distance from the \
         target in the end, median and worst."
    )
}

/// Returns a row's numbers in the order of [`HEAD`].
pub(super) fn cells(summary: &Summary) -> [String; 7] {
    let Summary {
        ropes,
        reached,
        time_s,
        overshoot_px,
        final_px,
    } = summary;
    [
        format!("{reached}/{ropes}"),
        fixed(time_s.median, 2),
        fixed(time_s.p90, 2),
        fixed(overshoot_px.median, 1),
        fixed(overshoot_px.worst, 1),
        fixed(final_px.median, 1),
        fixed(final_px.worst, 1),
    ]
}

/// Formats a number with this many decimals, or as a dash if it is not finite.
pub(super) fn fixed(number: f64, decimals: usize) -> String {
    if number.is_finite() {
        format!("{number:.decimals$}")
    } else {
        "–".to_owned()
    }
}
