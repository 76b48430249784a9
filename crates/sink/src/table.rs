//! The table at the end of a run: the total latency, its steps in order, then losses, late frames
//! and errors.

use crate::error::Comparison;
use crate::figure::{Figure, Micros};
use crate::latency::Row;
use crate::report::Report;
use crate::step::Step;
use crate::summary::{Distances, Summary};
use std::fmt::{Formatter, Result, Write};

/// Total width of the columns of figures and the bar, in characters. With it, the table of
/// latencies is as wide as a usual terminal.
const FIGURES_AND_BAR: usize = 5 * 7 + BAR;
/// Width of the bar that stands for the total, if no figure has a unit.
const BAR: usize = 12;

/// Columns of a row of times.
const QUANTILES: [f64; 5] = [0.5, 0.9, 0.99, 0.999, 1.0];

pub(crate) fn write(report: &Report, f: &mut Formatter<'_>) -> Result {
    heading(report, f)?;
    latency(report, f)?;
    losses(report, f)?;
    deadline(report, f)?;
    errors(report, f)?;
    machine(report, f)?;
    notes(report, f)
}

fn heading(report: &Report, f: &mut Formatter<'_>) -> Result {
    let frames = &report.summary.frames;
    write!(f, "{} received", plural(frames.received, "frame"))?;
    if let Some([first, last]) = report.facts.span_ns.filter(|[first, last]| last > first) {
        let seconds = (last - first) as f64 / 1e9;
        let rate = (frames.received.saturating_sub(1)) as f64 / seconds;
        write!(
            f,
            " in {} s, {} frames/s",
            Figure(Some(seconds)),
            Figure(Some(rate))
        )?;
    }
    writeln!(
        f,
        "; {} with a curve; {} lost\n",
        frames.with_curve,
        frames.lost.total()
    )
}

fn latency(report: &Report, f: &mut Formatter<'_>) -> Result {
    let period_ns = report.facts.period_ns.filter(|period_ns| *period_ns > 0);
    let width = column_width(report, Step::ALL.map(Row::Way));
    // Very wide figures leave no room for a bar.
    let bar_width = FIGURES_AND_BAR.saturating_sub(QUANTILES.len() * width);
    write!(f, "{:<20}", "latency, µs")?;
    for column in ["p50", "p90", "p99", "p99.9", "max"] {
        write!(f, "{column:>width$}")?;
    }
    if period_ns.is_some() {
        write!(f, "  p50/period")?;
    }
    writeln!(f)?;
    let whole = median_us(report, Row::Way(Step::Received));
    for step in Step::ALL {
        let row = Row::Way(step);
        let indent = match step {
            Step::Received | Step::Fitted => "",
            step if step.is_wait() => "    ",
            _ => "  ",
        };
        let label = format!("{indent}{}", step.label());
        spread(report, row, &label, width, f)?;
        let median = median_us(report, row);
        if let (Some(period_ns), Some(median)) = (period_ns, median) {
            write!(f, "{:>10.2} %", 1e5 * median / period_ns as f64)?;
        }
        if let (Some(whole), Some(median)) = (whole, median) {
            bar(median / whole, bar_width, f)?;
        }
        writeln!(f)?;
    }
    limit(report, f)?;
    writeln!(f)
}

/// Writes what limits the chain: the part that takes most of the total, and the frame rate that the
/// slowest stage could reach.
fn limit(report: &Report, f: &mut Formatter<'_>) -> Result {
    let (Some(whole), Some(capture), Some(extract), Some(fit)) = (
        median_us(report, Row::Way(Step::Received)),
        median_us(report, Row::Way(Step::Capture)),
        median_us(report, Row::Way(Step::Extract)),
        median_us(report, Row::Way(Step::Fit)),
    ) else {
        return Ok(());
    };
    let (slowest, stage) = if fit > extract {
        (fit, "fit")
    } else {
        (extract, "extract")
    };
    let period = report.facts.period_ns.map(|ns| ns as f64 / 1e3);
    if let Some(period) = period.filter(|&period| slowest > period) {
        return writeln!(
            f,
            "what limits it: {stage} takes {} a frame, and one comes every {}",
            Micros(Some(slowest)).named(),
            Micros(Some(period)).named()
        );
    }
    let waits = [
        Row::Way(Step::WaitExtract),
        Row::Way(Step::WaitFit),
        Row::Way(Step::WaitSink),
    ];
    let waiting = waits.into_iter().filter_map(|row| median_us(report, row));
    // A paced frame is ready before it is due, so the time until it is sent is that of the wake-up.
    let sending = match period {
        Some(_) => "sending a frame after it was due",
        None => "capture",
    };
    let pieces = [
        (slowest, stage),
        (waiting.sum(), "waiting for the next stage"),
        (capture, sending),
    ];
    let most = pieces.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let (most, name) = most.unwrap_or(pieces[0]);
    writeln!(
        f,
        "what limits it: {name}, {} of {};\n{stage} could do {} frames/s",
        Micros(Some(most)).named(),
        Micros(Some(whole)).named(),
        Figure(Some(1e6 / slowest.max(0.001)))
    )
}

/// Writes a row: its label and five figures, each in a column of this width.
fn spread(report: &Report, row: Row, label: &str, width: usize, f: &mut Formatter<'_>) -> Result {
    write!(f, "{label:<20}")?;
    for quantile in QUANTILES {
        let us = report.latency.row(row).quantile_us(quantile);
        write!(f, "{:>width$}", Micros(us))?;
    }
    Ok(())
}

/// Returns the width of the columns of these rows. It leaves two spaces before the longest figure,
/// and is at least 7.
fn column_width(report: &Report, rows: impl IntoIterator<Item = Row>) -> usize {
    let longest = rows.into_iter().flat_map(|row| {
        let figures = QUANTILES.map(|q| Micros(report.latency.row(row).quantile_us(q)));
        figures.map(|figure| figure.to_string().chars().count())
    });
    let longest = longest.max().unwrap_or(0);
    (longest + 2).max(7)
}

fn median_us(report: &Report, row: Row) -> Option<f64> {
    report.latency.row(row).quantile_us(0.5)
}

/// Draws a bar with a resolution of an eighth of a character.
fn bar(share: f64, width: usize, f: &mut Formatter<'_>) -> Result {
    let eighths = (share.clamp(0.0, 1.0) * width as f64 * 8.0).round() as usize;
    if eighths > 0 {
        f.write_char(' ')?;
    }
    for _ in 0..eighths / 8 {
        f.write_char('█')?;
    }
    match eighths % 8 {
        0 => Ok(()),
        rest => f.write_char(['▏', '▎', '▍', '▌', '▋', '▊', '▉'][rest - 1]),
    }
}

/// Writes what each stage sent, and how much of it the next stage did not send on.
fn losses(report: &Report, f: &mut Formatter<'_>) -> Result {
    let frames = &report.summary.frames;
    let lost = &frames.lost;
    write!(f, "{:<20}", "frames")?;
    for stage in ["source", "capture", "extract", "fit", "received"] {
        write!(f, " {stage:>8}")?;
    }
    write!(f, "\n{:<20}", "  sent")?;
    let after_capture = lost.capture + lost.mask;
    let extracted = frames.published - after_capture;
    let fitted = extracted - lost.extract;
    let numbered = frames.published + lost.source;
    for count in [
        numbered,
        frames.published,
        extracted,
        fitted,
        frames.received,
    ] {
        write!(f, " {count:>8}")?;
    }
    write!(f, "\n{:<20}", "  lost after it")?;
    for count in [
        lost.source,
        after_capture,
        lost.extract,
        lost.bridge + lost.fit + lost.sink,
    ] {
        write!(f, " {count:>8}")?;
    }
    if lost.mask > 0 {
        write!(
            f,
            "\n{:<20} {:>8} {:>8}",
            "    mask too late", "", lost.mask
        )?;
    }
    let at_restart = frames.at_restart;
    if at_restart != crate::AtRestart::default() {
        write!(
            f,
            "\n{:<20} {:>8} {:>8} {:>8} {:>8}",
            "    at a restart", "", at_restart.capture, at_restart.extract, at_restart.fit
        )?;
    }
    if lost.bridge > 0 {
        write!(
            f,
            "\n{:<20} {:>8} {:>8} {:>8} {:>8}",
            "    over the bridge", "", "", "", lost.bridge
        )?;
    }
    if lost.sink > 0 {
        write!(
            f,
            "\n{:<20} {:>8} {:>8} {:>8} {:>8}",
            "    with a sink", "", "", "", lost.sink
        )?;
    }
    writeln!(f, "\n")
}

fn deadline(report: &Report, f: &mut Formatter<'_>) -> Result {
    let deadline = &report.summary.deadline;
    if let (Some(us), Some(missed)) = (deadline.us, deadline.missed) {
        let timed = report.latency.row(Row::Way(Step::Received)).count();
        writeln!(
            f,
            "{:<20} {us:>6} µs, missed by {missed} of {timed}",
            "deadline",
        )?;
    }
    let width = column_width(
        report,
        Step::ALL.map(Row::Way).into_iter().chain([Row::Jitter]),
    );
    spread(report, Row::Jitter, "period jitter, µs", width, f)?;
    writeln!(f, "\n")
}

fn errors(report: &Report, f: &mut Formatter<'_>) -> Result {
    if report.compared.centerline.frames == 0 && report.compared.curve.frames == 0 {
        return Ok(());
    }
    write!(f, "{:<20}", "error, px")?;
    for column in ["mean", "p95", "max"] {
        write!(f, " {column:>6}")?;
    }
    writeln!(f)?;
    for (comparison, label) in [
        (&report.compared.centerline, "  centerline"),
        (&report.compared.curve, "  curve"),
    ] {
        if comparison.frames > 0 {
            distances(comparison.nearest.distances(), label, f)?;
            writeln!(f, "   {}", plural(comparison.frames, "frame"))?;
            distances(
                comparison.point_by_point.distances(),
                "    at the same ρ",
                f,
            )?;
            writeln!(f)?;
        } else if label == "  curve" && report.compared.elsewhere {
            distances(Distances::default(), label, f)?;
            writeln!(f, "   not in the image's pixels, as the truth is")?;
        }
    }
    writeln!(f)
}

fn distances(distances: Distances, label: &str, f: &mut Formatter<'_>) -> Result {
    write!(f, "{label:<20}")?;
    for figure in [distances.mean, distances.p95, distances.max] {
        write!(f, " {:>6}", Figure(figure))?;
    }
    Ok(())
}

fn machine(report: &Report, f: &mut Formatter<'_>) -> Result {
    let machine = &report.summary.machine;
    let unknown = "unknown processor";
    let mut hardware = machine.cpu.as_deref().unwrap_or(unknown).to_owned();
    if let Some(cores) = machine.cores {
        hardware += &format!(", {}", plural(cores as u64, "core"));
    }
    if let Some(memory_mb) = machine.memory_mb {
        hardware += &format!(", {memory_mb} MB");
    }
    let mut kernel = machine.kernel.clone();
    if let Some(governor) = &machine.governor {
        kernel += &format!(", governor {governor}");
    }
    paragraph("machine", &hardware, 21, f)?;
    paragraph("", &kernel, 21, f)
}

/// Writes the notes that are needed to interpret the figures. Only those that apply are written.
fn notes(report: &Report, f: &mut Formatter<'_>) -> Result {
    let facts = &report.facts;
    let mut notes = Vec::new();
    if facts.finished.is_none() {
        notes.push(
            "The run had not ended when this was written: it is how it stood then.".to_owned(),
        );
    }
    if !facts.from_start {
        let from_elsewhere = (facts.finished).is_some_and(|sent| sent.before_first.is_some());
        let why = if from_elsewhere {
            "Another program wrote the frames: they are counted from the first one that came to this chain; its way is not timed."
        } else {
            "The sink came later than the chain: frames are counted from the first message, which is not timed."
        };
        notes.push(why.to_owned());
    }
    for (stage, times) in [
        ("capture", facts.restarts.capture),
        ("extract", facts.restarts.extract),
        ("fit", facts.restarts.fit),
    ] {
        if times > 0 {
            notes.push(format!("{stage} was restarted {}: what was lost meanwhile is counted as far as the counters show it.", plural(times, "time")));
        }
    }
    if facts.restarts.sink > 0 {
        let times = plural(facts.restarts.sink, "time");
        notes.push(format!("sink was restarted {times}, and went on counting: what came while it was away is lost with it, and the last second before is not timed."));
    }
    for (stage, count) in facts.finished.iter().flat_map(|sent| {
        [
            ("capture", sent.captured),
            ("extract", sent.extracted),
            ("fit", sent.fitted),
        ]
    }) {
        if count.is_none() {
            notes.push(format!("{stage} did not say how many frames it sent: the last ones count as lost before it, unless they were seen later."));
        }
    }
    if facts.blank > 0 {
        notes.push(format!(
            "{} held no image, as the camera gave none for a while: ropes were told to be lost, and nothing was timed.",
            plural(facts.blank, "frame")
        ));
    }
    notes.extend(depth_notes(&report.summary));
    if facts.stale > 0 {
        notes.push(format!(
            "{} came a second time or late and did not count.",
            plural(facts.stale, "message")
        ));
    }
    if report.latency.backwards() > 0 {
        notes.push(format!(
            "{} had a timestamp before the one it follows: that piece of the way counts as 0.",
            plural(report.latency.backwards(), "frame")
        ));
    }
    if report.latency.saturated() > 0 {
        notes.push(format!(
            "{} longer than 100 s: percentiles above that say 100 s.",
            plural(report.latency.saturated(), "time")
        ));
    }
    notes.extend(error_notes(&report.compared.centerline, "centerline"));
    notes.extend(error_notes(&report.compared.curve, "curve"));
    if report.compared.unknown_basis > 0 {
        notes.push(format!(
            "{} of a kind that this version does not know: not held against the truth.",
            plural(report.compared.unknown_basis, "curve")
        ));
    }
    if !notes.is_empty() {
        writeln!(f)?;
    }
    notes.iter().try_for_each(|note| paragraph("!", note, 2, f))
}

/// Returns notes on missing depth images.
fn depth_notes(summary: &Summary) -> impl Iterator<Item = String> {
    let depth = summary.depth.unwrap_or_default();
    let without = depth
        .frames_without
        .filter(|&count| count > 0)
        .map(|count| {
            format!(
                "{} had no depth image or second view: their ropes are described in the image only.",
                plural(count, "frame")
            )
        });
    let (lost, unpaired) = (depth.lost.unwrap_or(0), depth.unpaired.unwrap_or(0));
    let images = depth.images.filter(|_| lost + unpaired > 0).map(|images| {
        format!(
            "The depth camera gave {}; {unpaired} of them belonged to no frame; {lost} more were lost at the source.",
            plural(images, "image")
        )
    });
    without.into_iter().chain(images)
}

/// Writes a text after a label, in lines of at most 80 columns.
fn paragraph(label: &str, text: &str, indent: usize, f: &mut Formatter<'_>) -> Result {
    write!(f, "{label:<0$}", indent - 1)?;
    let mut column = indent - 1;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if column >= indent && column + 1 + length > 80 {
            write!(f, "\n{:1$}", "", indent - 1)?;
            column = indent - 1;
        }
        write!(f, " {word}")?;
        column += 1 + length;
    }
    writeln!(f)
}

fn error_notes(comparison: &Comparison, kind: &str) -> impl Iterator<Item = String> {
    let without = comparison.frames_without_curve;
    let ropes = comparison.ropes_without_curve;
    let invented = comparison.curves_of_nothing;
    [
        (without > 0).then(|| format!("{} with a rope had no {kind}.", plural(without, "frame"))),
        (ropes > without).then(|| format!("{} had no {kind} of its own.", plural(ropes, "rope"))),
        (invented > 0).then(|| format!("{} where there is no rope.", plural(invented, kind))),
    ]
    .into_iter()
    .flatten()
}

/// Formats a count and its noun: `1 frame`, `2 frames`.
fn plural(count: u64, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}
