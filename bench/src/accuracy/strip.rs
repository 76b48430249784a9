//! The pixels along a curve and where each lies against it: the geometry that drawing and coverage share.

use super::spline::Sample;

/// Where a pixel's centre lies against the stretch of a curve that was found for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) pixel: usize,
    /// From the curve, in pixels.
    pub(super) distance_px: f64,
    /// Half the width there, in pixels.
    pub(super) half_px: f64,
}

/// How a curve's ends reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ends {
    /// Cut off square, as a rope is.
    Flat,
    /// Whatever is within the width of the tip.
    Round,
}

/// Calls `hit` for the pixels within half a width + `margin_px` of the curve: once for each piece of the curve that
/// has the pixel abreast, so that a pixel may come several times.
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
    // A closed curve's last sample is its first: the piece before the first is the last one.
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
            // Casts of floats saturate, so that far outside is the border.
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

/// Whether a pixel, `from_joint` away from a joint, has left the piece from `before` to the joint: with that it lies in
/// the wedge on the outside of the bend.
fn is_past(before: [f64; 2], joint: [f64; 2], from_joint: [f64; 2]) -> bool {
    let came = [joint[0] - before[0], joint[1] - before[1]];
    came[0] * from_joint[0] + came[1] * from_joint[1] > 0.0
}
