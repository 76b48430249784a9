//! The normal case, step by step, and the same film in every pixel format.

use anyhow::{Context, Result};
use lariat_bench::{Picture, Samples, Table, converted, micros, times};
use lariat_capture::RenderOptions;
use lariat_extract::{Mask, Options, PixelFormat, pick};

use crate::Effort;
use crate::case::{Case, Times, measure};

/// Frames of the film: 1.3 s.
const FRAMES: u64 = 40;
const FORMATS: [PixelFormat; 5] = [
    PixelFormat::Rgb8,
    PixelFormat::Bgr8,
    PixelFormat::Yuyv,
    PixelFormat::Nv12,
    PixelFormat::Gray8,
];

pub(crate) fn run(effort: &Effort) -> Result<()> {
    let film = effort.film(RenderOptions::default(), FRAMES)?;
    let mut cases = FORMATS
        .iter()
        .map(|&format| {
            let frames: Option<Vec<Picture>> = film.iter().map(|f| converted(f, format)).collect();
            let frames = frames.context("640×480 pixels can be converted into every format")?;
            Case::new(format!("{format:?}"), frames)
        })
        .collect::<Result<Vec<_>>>()?;
    // The same bytes as the first, the rope told by its colour instead of by its difference from the table.
    let told = film.iter().map(|f| converted(f, PixelFormat::Rgb8));
    let told: Vec<Picture> = told.collect::<Option<_>>().context("RGB stays RGB")?;
    let options = Options {
        mask: Mask::Hsv(pick(&told[0].image(), None)?.ranges),
        ..Options::default()
    };
    cases.push(Case::with("Rgb8, by HSV range", told, options)?);
    let turns = measure(&mut cases, effort.time(24.0));
    print_steps(&cases[0], film.len(), turns);
    print_formats(&cases);
    Ok(())
}

fn print_steps(case: &Case, frames: usize, turns: usize) {
    let read = case.read_ns.median();
    println!(
        "640×480 RGB, one rope 12 px wide, {frames} frames, {turns} turns\n\
         read: {} µs ({:.0} GB/s)\n",
        micros(read),
        case.bytes() / read
    );
    let mut table = Table::new(&["", "mask", "skeleton", "graph", "points", "whole", "p99"]);
    for (name, taken) in [("cold", &case.cold_ns), ("tracked", &case.tracked_ns)] {
        let figures = figures(taken);
        let cells = |show: &dyn Fn(f64) -> String| figures.iter().map(|&ns| show(ns)).collect();
        let row = |name: String, cells: Vec<String>| std::iter::once(name).chain(cells);
        table.push(row(format!("{name}, µs"), cells(&micros)));
        table.push(row("  ÷ read".into(), cells(&|ns| times(ns, read))));
    }
    println!("{table}");
}

/// Medians of the steps and of the whole, and the whole's 99th percentile.
fn figures(taken: &Times) -> Vec<f64> {
    let steps = taken.steps.iter().map(Samples::median);
    let whole = [taken.whole.median(), taken.whole.percentile(0.99)];
    steps.chain(whole).collect()
}

fn print_formats(cases: &[Case]) {
    let rgb = cases[0].cold_ns.whole.median();
    let mut table = Table::new(&[
        "format, 640×480",
        "read, µs",
        "cold, µs",
        "÷ read",
        "÷ RGB",
        "tracked, µs",
        "÷ read",
        "÷ RGB",
    ]);
    for case in cases {
        let [read, cold, tracked] =
            [&case.read_ns, &case.cold_ns.whole, &case.tracked_ns.whole].map(Samples::median);
        table.push([
            case.name.clone(),
            micros(read),
            micros(cold),
            times(cold, read),
            times(cold, rgb),
            micros(tracked),
            times(tracked, read),
            times(tracked, cases[0].tracked_ns.whole.median()),
        ]);
    }
    println!("{table}");
}
