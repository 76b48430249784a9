//! Rays through the points of a rope.

use super::{SeenRope, dot};
use crate::camera::Camera;

/// Number of neighbors on each side over which a width is averaged.
const WIDTHS: usize = 4;

/// A camera's view of a point on a rope.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sight {
    /// Ray in the camera's frame, scaled to a depth of 1.
    pub ray: [f64; 3],
    /// Derivative of the ray by the pixel.
    pub by_pixel: [[f64; 2]; 2],
    /// Half of the rope's width divided by its depth. Multiplied by a depth, it is the radius.
    pub slim: f64,
}

/// Computes the rays of a rope's points; `None` beyond the lens model. `row` is working memory.
pub(crate) fn aim(
    camera: &Camera,
    rope: &SeenRope,
    row: &mut Vec<f64>,
    sights: &mut Vec<Sight>,
) -> Option<()> {
    sights.clear();
    for &pixel in rope.points {
        let [x, y] = pixel;
        let (ray, by_pixel) = camera.ray([f64::from(x), f64::from(y)])?;
        sights.push(Sight {
            ray,
            by_pixel,
            slim: 0.0,
        });
    }
    let count = sights.len();
    let last = count.checked_sub(1)?;
    let (points, widths) = (&rope.points[..count], &rope.widths_px[..count]);
    row.clear();
    row.extend((0..count).map(|i| {
        let [from, to] = [i.saturating_sub(1), (i + 1).min(last)];
        let (a, b, sight) = (points[from], points[to], &sights[i]);
        let way = [
            f64::from(b[0]) - f64::from(a[0]),
            f64::from(b[1]) - f64::from(a[1]),
        ];
        // Half of the width in the image, as a vector in the plane at depth 1. Only its component
        // normal to the plane of the ray and the rope counts. The product of both lengths saves a
        // division.
        let half = 0.5 * f64::from(widths[i]);
        let [by_x, by_y] = sight.by_pixel;
        let aside_x = half * (by_x[1] * way[0] - by_x[0] * way[1]);
        let aside_y = half * (by_y[1] * way[0] - by_y[0] * way[1]);
        let (start, end, ray) = (sights[from].ray, sights[to].ray, sight.ray);
        let (x, y) = (end[0] - start[0], end[1] - start[1]);
        let square = [-y, x, ray[0] * y - ray[1] * x];
        let size = ((way[0] * way[0] + way[1] * way[1]) * dot(square, square)).sqrt();
        match size > 0.0 {
            true => (aside_x * square[0] + aside_y * square[1]).abs() / size,
            false => 0.0,
        }
    }));
    // Widths have independent errors, but a rope's width does not change from one point to the
    // next.
    let mut sum = row[..WIDTHS.min(count)].iter().sum::<f64>();
    for (i, sight) in sights.iter_mut().enumerate() {
        let next = row.get(i + WIDTHS).copied();
        let past = i.checked_sub(WIDTHS + 1).map(|k| row[k]);
        sum += next.unwrap_or(0.0) - past.unwrap_or(0.0);
        let among = (i + WIDTHS + 1).min(count) - i.saturating_sub(WIDTHS);
        sight.slim = sum / among as f64;
    }
    Some(())
}
