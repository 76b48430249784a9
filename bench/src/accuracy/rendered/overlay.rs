//! A drawn picture, enlarged, with the truth as a thin white line, the curves colored along ρ,
//! their ends, and the reported crossings.

use std::path::Path;

use anyhow::{Context, Result};
use image::RgbImage;
use lariat_drawn::scenes::Still;
use lariat_extract::Scene;

use crate::enlarged::Enlarged;

/// Magnification of the picture.
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
    let mut canvas = Enlarged::new(&picture, ZOOM);
    for (c, curve) in scene.curves.iter().enumerate() {
        let count = curve.points.len();
        let pairs = curve.points.iter().zip(curve.points.iter().cycle().skip(1));
        let pairs = pairs.take(if curve.closed { count } else { count - 1 });
        for (i, (from, to)) in pairs.enumerate() {
            let color = ramp(c, i as f32 / count as f32);
            canvas.line(&[from.map(f64::from), to.map(f64::from)], 3.0, color);
        }
    }
    for rope in &still.truth.ropes {
        canvas.line(&rope.points, 1.0, [255; 3]);
    }
    for curve in scene.curves.iter().filter(|curve| !curve.closed) {
        for (end, color) in [(0, [0, 255, 0]), (curve.points.len() - 1, [255, 0, 0])] {
            canvas.dots(&[curve.points[end].map(f64::from)], 9.0, color);
        }
    }
    for crossing in scene.crossings {
        canvas.dots(&[crossing.at.map(f64::from)], 7.0, [255, 0, 255]);
    }
    canvas.canvas.picture.save(path).with_context(unwritten)
}

/// Returns a color that runs from blue through green to yellow on the first curve, and from magenta
/// through red to orange on the next.
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
