//! The pixels along a curve and their position relative to it: geometry shared by drawing and
//! coverage.

use super::spline::Sample;

/// Position of a pixel's center relative to a nearby segment of a curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) pixel: usize,
    /// Distance from the curve, in pixels.
    pub(super) distance_px: f64,
    /// Half the width there, in pixels.
    pub(super) half_px: f64,
}

/// Shape of a curve's ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ends {
    /// Cut off square, like a rope.
    Flat,
    /// Rounded: includes everything within the width around the tip.
    Round,
}

/// Calls `hit` for the pixels within half a width + `margin_px` of the curve. It is called once for
/// each segment that the pixel is next to, so a pixel may occur several times.
pub(super) fn each(
    (width, height): (usize, usize),
    samples: &[Sample],
    margin_px: f64,
    ends: Ends,
    mut hit: impl FnMut(Hit),
) {
    let Some((&last, front)) = samples.split_last() else {
        return;
    };
    // A closed curve's last sample equals its first, so the last segment precedes the first.
    let first = samples[0].at;
    let is_closed = (last.at[0] - first[0]).hypot(last.at[1] - first[1]) < 1e-6;
    let mut before = front.last().filter(|_| is_closed).map(|s| s.at);
    for pair in samples.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let along = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
        let length2 = along[0] * along[0] + along[1] * along[1];
        if length2 == 0.0 {
            continue;
        }
        let came_from = before.replace(a.at);
        let reach = a.half_px.max(b.half_px) + margin_px;
        let span = |axis: usize, size: usize| {
            let low = a.at[axis].min(b.at[axis]) - reach;
            let high = a.at[axis].max(b.at[axis]) + reach;
            // Float casts saturate, so even coordinates far outside are clamped to the picture.
            low.ceil().max(0.0) as usize..((high.floor() + 1.0).max(0.0) as usize).min(size)
        };
        for y in span(1, height) {
            for x in span(0, width) {
                let from_a = [x as f64 - a.at[0], y as f64 - a.at[1]];
                let free = (from_a[0] * along[0] + from_a[1] * along[1]) / length2;
                let share = free.clamp(0.0, 1.0);
                let abreast = free == share
                    || ends == Ends::Round
                    || (free < 0.0 && came_from.is_some_and(|p| is_past(p, a.at, from_a)));
                let half_px = a.half_px + share * (b.half_px - a.half_px);
                let distance_px =
                    (from_a[0] - share * along[0]).hypot(from_a[1] - share * along[1]);
                if abreast && distance_px <= half_px + margin_px {
                    hit(Hit {
                        pixel: y * width + x,
                        distance_px,
                        half_px,
                    });
                }
            }
        }
    }
}

/// Returns whether a pixel at offset `from_joint` from a joint is past the end of the segment from
/// `before` to the joint. It is then in the wedge on the outside of the bend.
fn is_past(before: [f64; 2], joint: [f64; 2], from_joint: [f64; 2]) -> bool {
    let came = [joint[0] - before[0], joint[1] - before[1]];
    came[0] * from_joint[0] + came[1] * from_joint[1] > 0.0
}
