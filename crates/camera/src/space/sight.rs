//! The rays along which a rope's points lie.

use super::{SeenRope, dot, length};
use crate::camera::Camera;

/// A width is the mean over so many neighbors to each side.
const WIDTHS: usize = 4;

/// How a camera sees a point of a rope.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sight {
    /// The ray in the camera's frame, a millimetre ahead for each of depth.
    pub ray: [f64; 3],
    /// Its derivative by the pixel.
    pub by_pixel: [[f64; 2]; 2],
    /// Half of the rope's width by its depth: times that it is the radius.
    pub slim: f64,
}

/// The rays of a rope's points; `None` where the lens's model ends. `row` is room.
pub(crate) fn aim(
    camera: &Camera,
    rope: &SeenRope,
    row: &mut Vec<f64>,
    sights: &mut Vec<Sight>,
) -> Option<()> {
    sights.clear();
    for &pixel in rope.points {
        let (ray, by_pixel) = camera.ray(pixel.map(f64::from))?;
        sights.push(Sight {
            ray,
            by_pixel,
            slim: 0.0,
        });
    }
    let last = sights.len().checked_sub(1)?;
    for (i, width) in rope.widths_px.iter().enumerate() {
        let [from, to] = [i.saturating_sub(1), (i + 1).min(last)];
        let [a, b] = [from, to].map(|k| rope.points[k].map(f64::from));
        let way = [b[0] - a[0], b[1] - a[1]];
        let far = length(way[0], way[1]);
        let sight = &sights[i];
        // Half of the width in the picture, as a way in the plane a millimetre ahead; of it that counts which leaves the plane
        // of the ray and the rope.
        let half = match far > 0.0 {
            true => 0.5 * f64::from(*width) / far,
            false => 0.0,
        };
        let aside = sight
            .by_pixel
            .map(|by| half * (by[1] * way[0] - by[0] * way[1]));
        let [x, y] = [0, 1].map(|k| sights[to].ray[k] - sights[from].ray[k]);
        let ray = sight.ray;
        let square = [-y, x, ray[0] * y - ray[1] * x];
        let size = dot(square, square).sqrt();
        sights[i].slim = match size > 0.0 {
            true => (aside[0] * square[0] + aside[1] * square[1]).abs() / size,
            false => 0.0,
        };
    }
    // Widths err by themselves; a rope's does not change from one point to the next.
    let count = sights.len();
    row.clear();
    row.extend(sights.iter().map(|sight| sight.slim));
    let (mut sum, mut from, mut to) = (0.0, 0, 0);
    for (i, sight) in sights.iter_mut().enumerate() {
        let [first, last] = [i.saturating_sub(WIDTHS), (i + WIDTHS + 1).min(count)];
        sum += row[to..last].iter().sum::<f64>() - row[from..first].iter().sum::<f64>();
        (from, to) = (first, last);
        sight.slim = sum / (last - first) as f64;
    }
    Some(())
}
