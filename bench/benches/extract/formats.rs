//! The normal case step by step, and the same film in every pixel format.

use anyhow::{Context, Result};
use lariat_bench::{Picture, Table, converted, micros, multiple, times};
use lariat_capture::RenderOptions;
use lariat_extract::{Mask, Options, PixelFormat, pick};

use crate::Effort;
use crate::case::{Case, Times, WHOLE, measure};

/// Frames of the film (1.3 s).
const FRAMES: u64 = 40;
const FORMATS: [PixelFormat; 9] = [
    PixelFormat::Rgb8,
    PixelFormat::Bgr8,
    PixelFormat::Yuyv,
    PixelFormat::Uyvy,
    PixelFormat::Nv12,
    PixelFormat::Gray8,
    PixelFormat::Bgra8,
    PixelFormat::Gray16,
    PixelFormat::BayerRggb8,
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
    // The bytes of the first case again, but segmented by the rope's color instead of by difference
    // from the table.
    let told = film.iter().map(|f| converted(f, PixelFormat::Rgb8));
    let told: Vec<Picture> = told.collect::<Option<_>>().context("RGB stays RGB")?;
    let options = Options::default().mask(Mask::Hsv(pick(&told[0].image(), &[])?.ranges));
    cases.push(Case::with("Rgb8, by HSV range", told, options)?);
    let turns = measure(&mut cases, effort.time(24.0))?;
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
    let mut table = Table::new(&[
        "", "follow", "mask", "skeleton", "graph", "points", "whole", "p99",
    ]);
    for (name, taken) in [("cold", &case.cold), ("tracked", &case.tracked)] {
        let rows = [
            (
                format!("{name}, µs"),
                &taken.ns,
                micros as fn(f64) -> String,
            ),
            ("  ÷ read".into(), &taken.over_read, multiple),
        ];
        for (name, samples, show) in rows {
            let medians = samples.iter().map(|samples| show(samples.median()));
            let late = show(samples[WHOLE].percentile(0.99));
            table.push(std::iter::once(name).chain(medians).chain([late]));
        }
    }
    println!("{table}");
}

fn print_formats(cases: &[Case]) {
    let rgb = [&cases[0].cold, &cases[0].tracked].map(Times::whole_ns);
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
        let [cold, tracked] = [&case.cold, &case.tracked].map(Times::whole_ns);
        table.push([
            case.name.clone(),
            micros(case.read_ns.median()),
            micros(cold),
            multiple(case.cold.whole_over_read()),
            times(cold, rgb[0]),
            micros(tracked),
            multiple(case.tracked.whole_over_read()),
            times(tracked, rgb[1]),
        ]);
    }
    println!("{table}");
}
