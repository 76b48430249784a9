//! Draws the extracted curves over pictures: `overlay [--video] OUT_DIR IMAGE…`.
//!
//! Prints one line per image: curves, their lengths and widths, crossings, and the time of each
//! step. With `--video` the images are frames of one moving scene.

use std::path::Path;
use std::time::Instant;

use image::RgbImage;
use lariat_chain::canvas::Canvas;
use lariat_extract::{Extractor, Image, Options, PixelFormat, Scene};

/// Magnification of the picture.
const ZOOM: u32 = 2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let video = arguments.first().is_some_and(|a| a == "--video");
    arguments.drain(..usize::from(video));
    let [out, images @ ..] = &arguments[..] else {
        return Err("usage: overlay [--video] OUT_DIR IMAGE…".into());
    };
    std::fs::create_dir_all(out)?;
    let mut extractor = Extractor::new(Options::default())?;
    for path in images {
        let picture = image::load_from_memory(&std::fs::read(path)?)?.to_rgb8();
        let (width, height) = picture.dimensions();
        let (width, height) = (width as usize, height as usize);
        let view = Image::new(
            picture.as_raw(),
            width,
            height,
            3 * width,
            PixelFormat::Rgb8,
        )?;
        if !video {
            extractor.reset();
        }
        let mut times = Vec::new();
        let mut since = Instant::now();
        let scene = extractor.extract_observed(&view, &mut |_| {
            times.push(since.elapsed().as_micros());
            since = Instant::now();
        });
        let name = Path::new(path)
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        print!("{name} curves {} us {times:?}", scene.curves.len());
        for c in scene.curves {
            print!(
                " | {} {:?} {:.0}x{:.1}",
                c.track, c.status, c.length_px, c.width_px
            );
            print!(
                "{}{:?}",
                if c.closed { " closed" } else { "" },
                c.border.map(u8::from)
            );
        }
        print!(" | crossings {}", scene.crossings.len());
        for c in scene.crossings {
            print!(
                " ({:.0} {:.0} over {:.2} under {:.2} sure {:.2})",
                c.at[0], c.at[1], c.over_rho, c.under_rho, c.confidence
            );
        }
        println!();
        draw(&picture, &scene).save(Path::new(out).join(format!("{name}.png")))?;
    }
    Ok(())
}

fn draw(picture: &RgbImage, scene: &Scene) -> RgbImage {
    let (width, height) = picture.dimensions();
    let filter = image::imageops::FilterType::Nearest;
    let enlarged = image::imageops::resize(picture, ZOOM * width, ZOOM * height, filter);
    let mut canvas = Canvas::on(enlarged);
    let place = |at: [f32; 2]| at.map(|c| (f64::from(c) + 0.5) * f64::from(ZOOM) - 0.5);
    for (c, curve) in scene.curves.iter().enumerate() {
        for (i, pair) in curve.points.windows(2).enumerate() {
            let color = ramp(c, i as f32 / curve.points.len() as f32);
            let line = [pair[0], pair[1]].map(place);
            canvas.line(&line, 3.0).ink(color, 1.0);
        }
        if let (Some(&first), Some(&last)) = (curve.points.first(), curve.points.last()) {
            canvas.dots(&[place(first)], 9.0).ink([0, 255, 0], 1.0);
            canvas.dots(&[place(last)], 9.0).ink([255, 0, 0], 1.0);
        }
    }
    for crossing in scene.crossings {
        canvas.dots(&[place(crossing.at)], 5.0).ink([255; 3], 1.0);
    }
    canvas.picture
}

/// Returns a color that changes along the curve, so that the order through crossings is visible.
/// The first curve runs from blue through green to yellow, the next from magenta through red to
/// white.
fn ramp(curve: usize, rho: f32) -> [u8; 3] {
    let stops: [[f32; 3]; 3] = if curve.is_multiple_of(2) {
        [[0.0, 80.0, 255.0], [0.0, 255.0, 120.0], [255.0, 255.0, 0.0]]
    } else {
        [
            [255.0, 0.0, 255.0],
            [255.0, 60.0, 0.0],
            [255.0, 255.0, 255.0],
        ]
    };
    let (from, t) = if rho < 0.5 {
        (0, 2.0 * rho)
    } else {
        (1, 2.0 * rho - 1.0)
    };
    std::array::from_fn(|c| (stops[from][c] + t * (stops[from + 1][c] - stops[from][c])) as u8)
}
