//! Where a rope's axis ends, which is not where its outline does.
//!
//! A rope is cut off square. Where it rises or falls towards its end, the cut is seen as an ellipse, and the outline, which a colour
//! image shows, goes on beyond the axis by `r |cos ϑ|`, with ϑ the angle between the ray and the rope. The last points are
//! set closer to each other, so that the last one is where the axis ends.

use super::{SpacePoint, between, dot};

/// The rope's direction at its end is that of the way from so many radii before, and no way back is longer than this.
const BACK_RADII: f64 = 4.0;
/// It is shortened by no more than this many radii: what rises more steeply hides itself.
const MOST_RADII: f64 = 3.0;
/// Over how many times what is cut off the points are set closer.
const OVER: f64 = 3.0;

/// Moves the ends that are seen to where the axis ends. `before` is room.
pub(crate) fn cut_ends(places: &mut [SpacePoint], seen: [bool; 2], before: &mut Vec<SpacePoint>) {
    let [first, last] = seen;
    if first {
        cut(places, before);
    }
    if last {
        places.reverse();
        cut(places, before);
        places.reverse();
    }
}

/// Cuts off what is too much at the beginning.
fn cut(places: &mut [SpacePoint], before: &mut Vec<SpacePoint>) {
    let radius = 0.5 * places[0].width_mm;
    let end = places[0].point;
    let Some(back) = places
        .iter()
        .position(|place| far(place.point, end) > BACK_RADII * radius)
    else {
        return;
    };
    let way = between(end, places[back].point);
    let along = dot(way, end) / (dot(way, way) * dot(end, end)).sqrt();
    let sine = (1.0 - along * along).max(0.01).sqrt();
    let length = (radius * along.abs() / sine).min(MOST_RADII * radius);
    let reach = OVER * length;
    before.clear();
    before.extend_from_slice(places);
    let mut arc = 0.0;
    let (mut from, mut from_arc) = (0, 0.0);
    for i in 0..places.len() {
        if i > 0 {
            arc += far(before[i].point, before[i - 1].point);
        }
        if arc >= reach {
            break;
        }
        let wanted = length + arc * (reach - length) / reach;
        while from + 2 < before.len() {
            let step = far(before[from + 1].point, before[from].point);
            if from_arc + step >= wanted {
                break;
            }
            from += 1;
            from_arc += step;
        }
        let step = far(before[from + 1].point, before[from].point);
        let share = match step > 0.0 {
            true => ((wanted - from_arc) / step).clamp(0.0, 1.0),
            false => 0.0,
        };
        places[i] = mixed(&before[from], &before[from + 1], share);
    }
}

fn mixed(a: &SpacePoint, b: &SpacePoint, share: f64) -> SpacePoint {
    let mix = |a: f64, b: f64| a + share * (b - a);
    SpacePoint {
        point: [0, 1, 2].map(|k| mix(a.point[k], b.point[k])),
        by_pixel: [0, 1, 2].map(|k| [0, 1].map(|l| mix(a.by_pixel[k][l], b.by_pixel[k][l]))),
        ray: [0, 1, 2].map(|k| mix(a.ray[k], b.ray[k])),
        variance: mix(a.variance, b.variance),
        in_common: mix(a.in_common, b.in_common),
        is_measured: if share < 0.5 { a } else { b }.is_measured,
        doubt_px: mix(a.doubt_px, b.doubt_px),
        width_mm: mix(a.width_mm, b.width_mm),
    }
}

fn far(a: [f64; 3], b: [f64; 3]) -> f64 {
    let way = between(a, b);
    dot(way, way).sqrt()
}
