//! A comparison as a table for people.

use super::compare::{Comparison, Figures};
use lariat_chain::layout::{self, Column, Table};
use std::fmt::Write;

/// Format of a row's numbers and of their change.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// Pixels: three decimals; the change in percent.
    Distance,
    /// Microseconds: one decimal; the change in percent.
    Time,
    /// Whole numbers; the change as a number.
    Count,
}

/// Reads the value of a row from a column. Rows of distances are formatted separately.
type Figure = fn(&Figures) -> Option<f64>;

#[rustfmt::skip]
const FIGURES: [(&str, Kind, Figure); 13] = [
    ("rms of the fit, mean", Kind::Distance, |c| c.rms),
    ("frames with descriptors", Kind::Count, |c| count(c.frames)),
    ("frames lost on the way", Kind::Count, |c| count(c.lost.total())),
    ("frames without a rope", Kind::Count, |c| count(c.frames_without_rope)),
    ("ropes told apart", Kind::Count, |c| count(c.ropes.len() as u64)),
    ("ropes seen whole, in all frames", Kind::Count, |c| count(c.ropes_ok)),
    ("ropes covered in part", Kind::Count, |c| count(c.ropes_partial)),
    ("doubtful ropes", Kind::Count, |c| count(c.ropes_doubtful)),
    ("ropes lost", Kind::Count, |c| count(c.ropes_lost)),
    ("extract p50, µs", Kind::Time, |c| c.extract_us.p50),
    ("extract p99, µs", Kind::Time, |c| c.extract_us.p99),
    ("fit p50, µs", Kind::Time, |c| c.fit_us.p50),
    ("fit p99, µs", Kind::Time, |c| c.fit_us.p99),
];

fn count(n: u64) -> Option<f64> {
    Some(n as f64)
}

/// Formats the table.
pub(super) fn text(comparison: &Comparison) -> String {
    let Comparison {
        against,
        frames,
        skipped,
        recorded,
        now,
    } = comparison;
    let mut text = format!("{frames} frames");
    if *skipped > 0 {
        let _ = write!(text, ", {skipped} more without an image or its mask");
    }
    let of = match *against {
        "truth" => "from the truth",
        _ => "from the recorded",
    };
    let columns = [recorded, now];
    let mut rows = Vec::new();
    for (name, distances) in [
        ("centerline", columns.map(|column| column.centerline_px)),
        ("curve", columns.map(|column| column.curve_px)),
    ] {
        for (figure, values) in [
            ("mean", distances.map(|d| d.mean)),
            ("p95", distances.map(|d| d.p95)),
            ("max", distances.map(|d| d.max)),
        ] {
            let name = format!("{name} {of}, {figure}, px");
            rows.push(row(&name, values, Kind::Distance));
        }
    }
    rows.extend(FIGURES.map(|(name, kind, figure)| row(name, columns.map(figure), kind)));
    let figures = ["recorded", "now", "change"].map(|heading| Column::figures(heading).wide(10));
    let columns = std::iter::once(Column::words("")).chain(figures).collect();
    format!(
        "{text}\n{}(times: both settings on this machine, frame by frame in turns)\n",
        Table::text(columns, &rows, layout::width())
    )
}

fn row(name: &str, [recorded, now]: [Option<f64>; 2], kind: Kind) -> Vec<String> {
    let shown = |value: Option<f64>| match (value, kind) {
        (None, _) => "-".to_owned(),
        (Some(value), Kind::Distance) => format!("{value:.3}"),
        (Some(value), Kind::Time) => format!("{value:.1}"),
        (Some(value), Kind::Count) => format!("{value}"),
    };
    let change = match (recorded, now, kind) {
        (Some(recorded), Some(now), Kind::Count) => match now - recorded {
            0.0 => "=".to_owned(),
            by => format!("{by:+}"),
        },
        (Some(recorded), Some(now), _) if recorded > 0.0 => {
            format!("{:+.1} %", 100.0 * (now / recorded - 1.0))
        }
        _ => String::new(),
    };
    vec![name.to_owned(), shown(recorded), shown(now), change]
}
