//! A comparison as people read it.

use super::compare::Comparison;
use lariat_chain::layout::{self, Column, Table};
use std::fmt::Write;

/// How a row's numbers are written, and their change.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// Pixels: three decimals; the change in percent.
    Distance,
    /// Microseconds: one decimal; likewise.
    Time,
    /// Whole numbers; the change as such.
    Count,
}

/// The table.
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
    let count = |n: u64| Some(n as f64);
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
    for (name, values, kind) in [
        (
            "rms of the fit, mean",
            columns.map(|c| c.rms),
            Kind::Distance,
        ),
        (
            "frames with descriptors",
            columns.map(|c| count(c.frames)),
            Kind::Count,
        ),
        (
            "frames lost on the way",
            columns.map(|c| count(c.lost.total())),
            Kind::Count,
        ),
        (
            "frames without a rope",
            columns.map(|c| count(c.frames_without_rope)),
            Kind::Count,
        ),
        (
            "ropes told apart",
            columns.map(|c| count(c.ropes.len() as u64)),
            Kind::Count,
        ),
        (
            "ropes seen whole, in all frames",
            columns.map(|c| count(c.ropes_ok)),
            Kind::Count,
        ),
        (
            "ropes covered in part",
            columns.map(|c| count(c.ropes_partial)),
            Kind::Count,
        ),
        (
            "ropes that may be none",
            columns.map(|c| count(c.ropes_doubtful)),
            Kind::Count,
        ),
        (
            "ropes lost",
            columns.map(|c| count(c.ropes_lost)),
            Kind::Count,
        ),
        (
            "extract p50, µs",
            columns.map(|c| c.extract_us.p50),
            Kind::Time,
        ),
        (
            "extract p99, µs",
            columns.map(|c| c.extract_us.p99),
            Kind::Time,
        ),
        ("fit p50, µs", columns.map(|c| c.fit_us.p50), Kind::Time),
        ("fit p99, µs", columns.map(|c| c.fit_us.p99), Kind::Time),
    ] {
        rows.push(row(name, values, kind));
    }
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
