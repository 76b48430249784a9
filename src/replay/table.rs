//! A comparison as people read it.

use super::compare::Comparison;
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
    let _ = writeln!(
        text,
        "\n{:<40}{:>12}{:>12}{:>12}",
        "", "recorded", "now", "change"
    );
    let of = match *against {
        "truth" => "from the truth",
        _ => "from the recorded",
    };
    let columns = [recorded, now];
    let count = |n: u64| Some(n as f64);
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
            row(&mut text, &name, values, Kind::Distance);
        }
    }
    row(
        &mut text,
        "rms of the fit, mean",
        columns.map(|c| c.rms),
        Kind::Distance,
    );
    for (name, value) in [
        ("frames with descriptors", columns.map(|c| count(c.frames))),
        (
            "frames lost on the way",
            columns.map(|c| count(c.lost.total())),
        ),
        (
            "frames without a rope",
            columns.map(|c| count(c.frames_without_rope)),
        ),
        (
            "ropes told apart",
            columns.map(|c| count(c.ropes.len() as u64)),
        ),
        (
            "ropes seen whole, in all frames",
            columns.map(|c| count(c.ropes_ok)),
        ),
        (
            "ropes covered in part",
            columns.map(|c| count(c.ropes_partial)),
        ),
        (
            "ropes that may be none",
            columns.map(|c| count(c.ropes_doubtful)),
        ),
        ("ropes lost", columns.map(|c| count(c.ropes_lost))),
    ] {
        row(&mut text, name, value, Kind::Count);
    }
    for (name, value) in [
        ("extract p50, µs", columns.map(|c| c.extract_us.p50)),
        ("extract p99, µs", columns.map(|c| c.extract_us.p99)),
        ("fit p50, µs", columns.map(|c| c.fit_us.p50)),
        ("fit p99, µs", columns.map(|c| c.fit_us.p99)),
    ] {
        row(&mut text, name, value, Kind::Time);
    }
    text.push_str("(times: both settings on this machine, frame by frame in turns)\n");
    text
}

fn row(text: &mut String, name: &str, [recorded, now]: [Option<f64>; 2], kind: Kind) {
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
    let _ = writeln!(
        text,
        "{name:<40}{:>12}{:>12}{change:>12}",
        shown(recorded),
        shown(now)
    );
}
