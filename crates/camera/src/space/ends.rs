//! Corrects the ends of a rope's axis, which differ from the ends of its outline.
//!
//! A rope is cut off square. If it rises or falls toward its end, the cut is seen as an ellipse.
//! The outline in a color image then continues beyond the axis by `r |cos ϑ|`, where ϑ is the angle
//! between the ray and the rope. The last points are moved closer together, so that the last one is
//! where the axis ends.

use super::{SpacePoint, between, dot};

/// Distance over which the rope's direction at its end is measured, in radii.
const BACK_RADII: f64 = 4.0;
/// Maximum length that is cut off, in radii. A rope that rises more steeply hides its own end.
const MOST_RADII: f64 = 3.0;
/// Length of the part of the rope in which points are moved, as a multiple of the length that is
/// cut off.
const OVER: f64 = 3.0;

/// Moves the visible ends to where the axis ends. `before` is working memory.
pub(crate) fn cut_ends(places: &mut [SpacePoint], seen: [bool; 2], before: &mut Vec<SpacePoint>) {
    let last = places.len() - 1;
    if seen[0] {
        cut(places, |i| i, before);
    }
    if seen[1] {
        cut(places, |i| last - i, before);
    }
}

/// Shortens one end. `at(i)` is the number of the `i`-th point from that end.
fn cut(places: &mut [SpacePoint], at: impl Fn(usize) -> usize, before: &mut Vec<SpacePoint>) {
    let radius = 0.5 * places[at(0)].width_mm;
    let end = places[at(0)].point;
    let count = places.len();
    let back = (0..count).find(|&i| far(places[at(i)].point, end) > BACK_RADII * radius);
    let Some(back) = back else {
        return;
    };
    let way = between(end, places[at(back)].point);
    let along = dot(way, end) / (dot(way, way) * dot(end, end)).sqrt();
    let sine = (1.0 - along * along).max(0.01).sqrt();
    let length = (radius * along.abs() / sine).min(MOST_RADII * radius);
    let reach = OVER * length;
    // The points that are moved. They also define the path along which they move.
    before.clear();
    let mut arc = 0.0;
    for i in 0..count {
        let place = places[at(i)];
        arc += before
            .last()
            .map_or(0.0, |last| far(place.point, last.point));
        before.push(place);
        if arc >= reach && before.len() > 1 {
            break;
        }
    }
    let (mut from, mut from_arc, mut arc) = (0, 0.0, 0.0);
    for i in 0..before.len() {
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
        places[at(i)] = mixed(&before[from], &before[from + 1], share);
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
        doubt_mm: mix(a.doubt_mm, b.doubt_mm),
        width_mm: mix(a.width_mm, b.width_mm),
    }
}

fn far(a: [f64; 3], b: [f64; 3]) -> f64 {
    let way = between(a, b);
    dot(way, way).sqrt()
}
