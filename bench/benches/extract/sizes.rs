//! Larger pictures: cold time grows with the number of pixels, tracked time with the rope's area.

use anyhow::Result;
use lariat_bench::{Table, micros, multiple};
use lariat_capture::RenderOptions;

use crate::Effort;
use crate::case::{Case, Times, measure};

/// Frames of each film (50 MB at the largest size).
const FRAMES: u64 = 8;
/// Width and height of the picture and width of the rope, px. The rope keeps its default width or
/// is scaled with the picture.
const SIZES: [(u32, u32, f64); 5] = [
    (640, 480, 12.0),
    (1280, 720, 12.0),
    (1280, 720, 18.0),
    (1920, 1080, 12.0),
    (1920, 1080, 27.0),
];

pub(crate) fn run(effort: &Effort) -> Result<()> {
    let mut cases = Vec::new();
    for (width, height, rope_px) in SIZES {
        let options = RenderOptions {
            width,
            height,
            rope_px,
            ..RenderOptions::default()
        };
        let film = effort.film(options, FRAMES)?;
        cases.push(Case::new(format!("{width}×{height}, {rope_px} px"), film)?);
    }
    measure(&mut cases, effort.time(14.0))?;
    let mut table = Table::new(&[
        "size and rope, RGB",
        "read, µs",
        "cold, µs",
        "÷ read",
        "ns/pixel",
        "tracked, µs",
        "÷ read",
        "ns/rope pixel",
    ]);
    for case in &cases {
        let [cold, tracked] = [&case.cold, &case.tracked].map(Times::whole_ns);
        table.push([
            case.name.clone(),
            micros(case.read_ns.median()),
            micros(cold),
            multiple(case.cold.whole_over_read()),
            format!("{:.3}", cold / case.pixels()),
            micros(tracked),
            multiple(case.tracked.whole_over_read()),
            format!("{:.2}", tracked / case.rope_px2.median().max(1.0)),
        ]);
    }
    println!("{table}");
    Ok(())
}
