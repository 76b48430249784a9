//! Shows the rendered rope: `render DIR [SEED]` writes frames over 20 s as PNGs, and all of them on
//! one sheet. `render --time` prints the time per frame.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use image::{RgbImage, imageops};
use lariat_capture::{FrameSource, RenderOptions, Source, open};
use lariat_message::Centerlines;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.first().map(String::as_str) {
        Some("--time") => time(),
        Some(folder) => {
            let seed = arguments.get(1).map_or(Ok(1), |text| text.parse())?;
            sheet(Path::new(folder), seed)
        }
        None => Err("say where to write the frames, or --time".into()),
    }
}

fn rendered(options: RenderOptions) -> Result<Box<dyn FrameSource>, Box<dyn Error>> {
    Ok(open(&Source::Rendered(options))?)
}

/// Writes a file for every second of 20 s, and all of them at half the size on a sheet of 4 × 5.
fn sheet(folder: &Path, seed: u64) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let mut source = rendered(RenderOptions {
        seed,
        frame_interval_s: 1.0,
        frames: Some(20),
        ..RenderOptions::default()
    })?;
    let mut sheet = RgbImage::new(4 * 320, 5 * 240);
    while let Some(frame) = source.next()? {
        let mut picture = RgbImage::new(frame.width, frame.height);
        source.write(&mut picture);
        picture.save(folder.join(format!("{:02}.png", frame.sequence)))?;
        let small = imageops::thumbnail(&picture, 320, 240);
        let place = i64::try_from(frame.sequence - 1)?;
        imageops::replace(&mut sheet, &small, place % 4 * 320, place / 4 * 240);
    }
    let mut truth = Box::new(Centerlines::EMPTY);
    source.truth(&mut truth);
    println!("rope of {} px", truth.curves[0].length_px);
    sheet.save(folder.join("sheet.png"))?;
    Ok(())
}

/// Prints medians of 2000 frames, in microseconds.
fn time() -> Result<(), Box<dyn Error>> {
    let mut source = rendered(RenderOptions::default())?;
    let mut pixels = vec![0; source.largest_frame_bytes()];
    let mut truth = Box::new(Centerlines::EMPTY);
    let mut costs_us: [Vec<f64>; 3] = Default::default();
    for _ in 0..2000 {
        let start = Instant::now();
        source.next()?;
        let drawn = start.elapsed();
        source.write(&mut pixels);
        let written = start.elapsed();
        source.truth(&mut truth);
        let told = start.elapsed();
        for (costs_us, cost) in costs_us
            .iter_mut()
            .zip([drawn, written - drawn, told - written])
        {
            costs_us.push(cost.as_secs_f64() * 1e6);
        }
    }
    for (name, costs_us) in ["draw", "noise into the slot", "truth"]
        .iter()
        .zip(&mut costs_us)
    {
        costs_us.sort_by(f64::total_cmp);
        println!(
            "{name}: median {:.0} µs, 99th percentile {:.0} µs",
            costs_us[1000], costs_us[1980]
        );
    }
    Ok(())
}
