//! The plots: errors over time, and the influence of a value on success and time.

use lariat_plot::{Axis, Chart, LineStyle, Mark, Marker, PlotError, Spread, Stroke, draw};

use super::summary::{Quantiles, Summary};
use super::{Group, Harder, Row, Study, by_value};
use crate::servo::judge::{Outcome, REACHED_PX};

/// Points of a line over time: more than a page can show.
const TIMES: usize = 240;
/// Color of the default case.
const BLUE: usize = 0;

/// Plots the error of each rope of a row over time, and their median.
pub(super) fn errors(study: &Study, row: &Row) -> Result<String, PlotError> {
    let ends = row
        .outcomes
        .iter()
        .filter_map(|outcome| outcome.errors.last());
    let end_s = ends.map(|moment| moment.at_s).fold(0.0, f64::max);
    let times: Vec<f64> = (0..=TIMES)
        .map(|i| i as f64 / TIMES as f64 * end_s)
        .collect();
    let lines: Vec<Vec<f64>> = (row.outcomes.iter())
        .map(|outcome| times.iter().map(|&t| error_at(outcome, t)).collect())
        .collect();
    let all = lines.iter().flatten().copied();
    let step = step(end_s);
    let mut chart = Chart::new(
        Axis::linear("time, s", [0.0, end_s.max(step)], step),
        Axis::log_around(&study.in_unit("error, px"), all.chain([REACHED_PX])),
    );
    let over = |line: &[f64]| times.iter().zip(line).map(|(&t, &px)| [t, px]).collect();
    for line in &lines {
        let (color, points) = (BLUE, over(line));
        chart.marks.push(Mark::Thin { color, points });
    }
    let medians: Vec<f64> = (0..times.len())
        .map(|i| Quantiles::of(lines.iter().map(|line| line[i])).median)
        .collect();
    let look = LineStyle::nth(1).stroke(Stroke::Solid).marker(Marker::None);
    let name = format!("median of {} ropes", row.outcomes.len());
    chart.line(&name, look, over(&medians));
    let text = study.in_unit(&format!("{REACHED_PX} px"));
    chart.marks.push(Mark::Level {
        y: REACHED_PX,
        text,
    });
    draw("errors", &[chart], 1)
}

/// Returns the newest error at a time. NaN before the first.
fn error_at(outcome: &Outcome, at_s: f64) -> f64 {
    let seen = outcome.errors.partition_point(|m| m.at_s <= at_s);
    let newest = seen.checked_sub(1).map(|newest| &outcome.errors[newest]);
    newest.map_or(f64::NAN, |moment| moment.error_px)
}

/// Plots success and time of a group: over its values if it has them, otherwise by name.
pub(super) fn group(study: &Study, group: Group) -> Result<String, PlotError> {
    let rows = study.of(group);
    match by_value(&rows) {
        Some(values) => sweep(study, group, &values),
        None => names(&rows),
    }
}

fn sweep(study: &Study, group: Group, values: &[(f64, &Row)]) -> Result<String, PlotError> {
    let summaries: Vec<(f64, Summary)> = (values.iter())
        .map(|&(value, row)| (value, Summary::of(row)))
        .collect();
    let base = study.base().map(Summary::of);
    let numbers = values.iter().map(|&(value, _)| value);
    let x = if group.harder() == Harder::Upwards {
        // The axis includes 0.
        over_values(group.axis(), numbers.chain([0.0]))
    } else {
        over_values(group.axis(), numbers)
    };
    let medians = || summaries.iter().map(|(_, summary)| summary.time_s.median);
    let longest_s = medians()
        .chain(base.map(|base| base.time_s.median))
        .filter(|time| time.is_finite())
        .fold(0.0, f64::max);
    let high = if longest_s > 0.0 {
        1.2 * longest_s
    } else {
        1.0
    };
    let panels = [
        (
            "reached",
            Axis::linear("ropes, %", [0.0, 105.0], 25.0),
            percent as fn(&Summary) -> f64,
            ["", ""],
        ),
        (
            "median time to the target",
            Axis::linear("time, s", [0.0, high], step(high)),
            |summary| summary.time_s.median,
            ["as it is", "lariat's own"],
        ),
    ];
    let charts: Vec<Chart> = panels
        .into_iter()
        .map(|(title, y, of, [as_it_is, own])| {
            let mut chart = Chart::new(x.clone(), y).titled(title);
            chart.height_px = 220;
            if let Some(base) = &base {
                let text = as_it_is.to_owned();
                let y = of(base);
                if y.is_finite() {
                    chart.marks.push(Mark::Level { y, text });
                }
            }
            if let (Group::Latency, Some(x)) = (group, study.own_latency_ms) {
                let text = own.to_owned();
                chart.marks.push(Mark::Rule { x, text });
            }
            let points = summaries.iter().map(|(x, summary)| [*x, of(summary)]);
            chart.line("", LineStyle::nth(BLUE), points.collect());
            chart
        })
        .collect();
    draw("a sweep", &charts, 2)
}

fn percent(summary: &Summary) -> f64 {
    100.0 * summary.share()
}

/// Plots the times of the ropes that reached the target, for each row.
fn names(rows: &[&Row]) -> Result<String, PlotError> {
    let name = |row: &&Row| {
        let summary = Summary::of(row);
        format!("{} ({}/{})", row.name, summary.reached, summary.ropes)
    };
    let names: Vec<String> = rows.iter().map(name).collect();
    let spreads: Vec<Spread> = (rows.iter())
        .map(|row| Spread::of(row.outcomes.iter().filter_map(Outcome::reached_s)))
        .collect();
    let longest_s = spreads.iter().map(|spread| spread.p95).fold(0.0, f64::max);
    let high = if longest_s > 0.0 {
        1.1 * longest_s
    } else {
        1.0
    };
    let letters = names.iter().map(|name| name.chars().count()).max();
    let mut chart = Chart::new(
        Axis::linear("time to the target, s", [0.0, high], step(high)),
        Axis::names("", names),
    );
    chart.left_px = 24 + 7 * letters.unwrap_or(0) as i32;
    chart.height_px = 64 + 26 * rows.len() as i32;
    for (row, spread) in spreads.into_iter().enumerate() {
        chart.marks.push(Mark::Spread {
            row,
            shift: 0.0,
            look: LineStyle::nth(BLUE),
            spread,
        });
    }
    draw("a comparison", &[chart], 1)
}

/// Returns an axis for these values: logarithmic if their magnitudes differ and none is 0.
fn over_values(label: &str, values: impl Iterator<Item = f64> + Clone) -> Axis {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    if low > 0.0 && high / low >= 8.0 {
        return Axis::log(label, [low / 1.3, high * 1.3]);
    }
    let margin = if high > low { 0.05 * (high - low) } else { 1.0 };
    let step = step(high - low + 2.0 * margin);
    Axis::linear(label, [low - margin, high + margin], step)
}

/// Returns a round step that divides a range into four to nine parts.
fn step(range: f64) -> f64 {
    if !(range > 0.0 && range.is_finite()) {
        return 1.0;
    }
    let power = 10f64.powf((range / 4.0).log10().floor());
    let mantissa = range / 4.0 / power;
    let round = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|&m| m <= mantissa * (1.0 + 1e-9));
    round.unwrap_or(1.0) * power
}

#[test]
fn steps_are_round() {
    assert_eq!([8.0, 1.3, 105.0, 0.0].map(step), [2.0, 0.2, 20.0, 1.0]);
}
