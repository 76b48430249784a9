//! A drawn picture, enlarged, with the truth as a thin white line, the curves coloured along ρ, their ends, and the
//! reported crossings.

use std::path::Path;

use anyhow::{Context, Result};
use image::{Rgb, RgbImage, imageops};
use lariat_drawn::scenes::Still;
use lariat_extract::Scene;

/// How many times larger it is drawn.
const ZOOM: u32 = 3;

/// Writes a PNG.
///
/// # Errors
/// The file cannot be written.
pub(super) fn write(path: &Path, still: &Still, scene: &Scene) -> Result<()> {
    let unwritten = || format!("cannot write {}", path.display());
    let (width, height) = (still.width as u32, still.height as u32);
    let picture = RgbImage::from_raw(width, height, still.rgb.clone());
    let picture = picture.with_context(unwritten)?;
    let filter = imageops::FilterType::Nearest;
    let mut canvas = imageops::resize(&picture, ZOOM * width, ZOOM * height, filter);
    for (c, curve) in scene.curves.iter().enumerate() {
        let count = curve.points.len();
        let pairs = curve.points.iter().zip(curve.points.iter().cycle().skip(1));
        let pairs = pairs.take(if curve.closed { count } else { count - 1 });
        for (i, (from, to)) in pairs.enumerate() {
            let color = ramp(c, i as f32 / count as f32);
            stroke(
                &mut canvas,
                from.map(f64::from),
                to.map(f64::from),
                1,
                color,
            );
        }
    }
    for rope in &still.truth.ropes {
        for pair in rope.points.windows(2) {
            stroke(&mut canvas, pair[0], pair[1], 0, [255; 3]);
        }
    }
    for curve in scene.curves.iter().filter(|curve| !curve.closed) {
        for (end, color) in [(0, [0, 255, 0]), (curve.points.len() - 1, [255, 0, 0])] {
            dot(&mut canvas, curve.points[end].map(f64::from), 4, color);
        }
    }
    for crossing in scene.crossings {
        dot(&mut canvas, crossing.at.map(f64::from), 3, [255, 0, 255]);
    }
    canvas.save(path).with_context(unwritten)
}

/// From blue over green to yellow on the first curve, from magenta over red to orange on the next.
fn ramp(curve: usize, rho: f32) -> [u8; 3] {
    let stops: [[f32; 3]; 3] = if curve.is_multiple_of(2) {
        [[0.0, 80.0, 255.0], [0.0, 255.0, 120.0], [255.0, 255.0, 0.0]]
    } else {
        [[255.0, 0.0, 255.0], [255.0, 0.0, 60.0], [255.0, 160.0, 0.0]]
    };
    let (from, share) = if rho < 0.5 {
        (0, 2.0 * rho)
    } else {
        (1, 2.0 * rho - 1.0)
    };
    [0, 1, 2].map(|k| (stops[from][k] + share * (stops[from + 1][k] - stops[from][k])) as u8)
}

fn stroke(canvas: &mut RgbImage, from: [f64; 2], to: [f64; 2], radius: i64, color: [u8; 3]) {
    let longest = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
    let steps = (longest * f64::from(ZOOM)).ceil().max(1.0) as usize;
    for i in 0..=steps {
        let share = i as f64 / steps as f64;
        let at = [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
        dot(canvas, at, radius, color);
    }
}

fn dot(canvas: &mut RgbImage, at: [f64; 2], radius: i64, color: [u8; 3]) {
    // A pixel's centre is the middle of its square.
    let middle = at.map(|c| ((c + 0.5) * f64::from(ZOOM)) as i64);
    for y in middle[1] - radius..=middle[1] + radius {
        for x in middle[0] - radius..=middle[0] + radius {
            let is_in = (0..i64::from(canvas.width())).contains(&x)
                && (0..i64::from(canvas.height())).contains(&y);
            if is_in {
                canvas.put_pixel(x as u32, y as u32, Rgb(color));
            }
        }
    }
}
