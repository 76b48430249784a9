//! Handles tips on another strand, or just past it. If the image shows no end, the rope's usual
//! length decides.
//!
//! A tip that passes over or under a strand disappears in it. On the other side, it first comes out
//! as a stub too short to distinguish from a bump. But a rope does not shrink. The length that a
//! line lacks is added at the ends where the prior's shape continues. It is placed as in the prior,
//! moved along with the line, and only as far as the image shows rope or an occluder.

use crate::bitmap::bits::BitPlane;
use crate::centerline::line::{Line, Sample};
use crate::past::{Past, Rope};
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Length that makes no difference, in widths: the accuracy of measured tips.
pub(super) const LEAST_WIDTHS: f32 = 0.3;
/// Maximum excess length of a line, in widths, to be cut off. The excess continues along the strand
/// that the tip is on.
const MOST_OVER_WIDTHS: f32 = 3.0;
/// Maximum length out of sight: in widths, and as a share of the rope.
const MOST: (f32, f32) = (10.0, 0.3);
/// Length at the line's end that is also replaced, in widths. If the tip is on a strand, this
/// length may show that strand.
const REPLACED_WIDTHS: f32 = 0.75;
/// Length before the replaced part that gives the tip's direction, in widths.
const BACKED_WIDTHS: f32 = 2.0;
/// Number of places on the line that are compared with the rope.
const COMPARED: usize = 32;
/// Maximum mean distance of these places from the rope, in widths, in addition to the ropes' mean
/// movement.
const APART_WIDTHS: f32 = 0.6;
/// Step in which the line's place along the rope is sought, in widths.
const STEP_WIDTHS: f32 = 0.25;
/// Length of a tip that may show the table, in widths: its own edge.
const BARE_WIDTHS: f32 = 0.3;

/// Distance beyond an end at which the table must show for the end to be free, in widths.
const BEYOND_WIDTHS: f32 = 1.0;
/// Directions in which it must show, as cosine and sine relative to the rope's: ahead, and 35° and
/// 70° to both sides.
const AROUND: [(f32, f32); 5] = [
    (1.0, 0.0),
    (0.82, 0.57),
    (0.82, -0.57),
    (0.34, 0.94),
    (0.34, -0.94),
];

/// Place of a line along a rope of the prior.
struct Place<'a> {
    rope: &'a Rope,
    reversed: bool,
    /// Length that the line lacks, relative to the rope's usual length.
    room_px: f32,
    /// Part of that length that is missing before the line's first sample.
    before_px: f32,
}

/// Lengthens the line at the ends where a tip of its rope is out of sight. Returns the added length
/// at each end.
pub(crate) fn lengthen(line: &mut Line, past: &Past, [mask, occluder]: [&BitPlane; 2]) -> [f32; 2] {
    let Some(place) = place(line, past) else {
        return [0.0; 2];
    };
    let Place {
        rope,
        reversed,
        room_px,
        before_px,
    } = place;
    let slack_px = rope.width_px;
    let shares = [before_px, room_px - before_px];
    let mut added = [0.0; 2];
    let mut left_px = room_px;
    // The end that lacks more comes first.
    let first = usize::from(shares[1] > shares[0]);
    for end in [first, 1 - first] {
        let most_px = (shares[end] + slack_px).min(left_px);
        if most_px < LEAST_WIDTHS * rope.width_px {
            continue;
        }
        if end == 0 {
            line.samples.reverse();
        }
        // True if the rope's last point is at this end.
        let at_last = (end == 1) != reversed;
        added[end] = extend(line, rope, at_last, most_px, [mask, occluder]);
        if end == 0 {
            line.samples.reverse();
        }
        left_px -= added[end];
    }
    added
}

/// Finds the rope to which the line belongs and its place along it, if the line lacks some of the
/// rope's usual length. The place has the least mean distance. `None` if that is too large.
fn place<'a>(line: &Line, past: &'a Past) -> Option<Place<'a>> {
    if line.closed || line.border.contains(&true) || line.samples.len() < 8 {
        return None;
    }
    let length_px = line.length_px();
    let mut best: Option<(f32, Place)> = None;
    for rope in past.live().filter(|rope| !rope.closed && rope.state.whole) {
        let room_px = rope.usual_px - length_px;
        let most_px = (MOST.0 * rope.width_px).min(MOST.1 * rope.usual_px);
        if room_px < LEAST_WIDTHS * rope.width_px || room_px > most_px {
            continue;
        }
        let step_px = STEP_WIDTHS * rope.width_px;
        let steps = (room_px / step_px) as usize + 1;
        for reversed in [false, true] {
            for k in 0..=steps {
                let before_px = (k as f32 * step_px).min(room_px);
                let after_px = room_px - before_px;
                let from_px = if reversed { after_px } else { before_px };
                let apart = apart_widths(line, length_px, rope, from_px, reversed);
                if best.as_ref().is_none_or(|(least, _)| apart < *least) {
                    let place = Place {
                        rope,
                        reversed,
                        room_px,
                        before_px,
                    };
                    best = Some((apart, place));
                }
            }
        }
    }
    best.filter(|&(apart, _)| apart <= APART_WIDTHS + past.moved())
        .map(|(_, place)| place)
}

/// Mean distance of the line from the stretch of the rope that starts at `from_px`, in widths.
fn apart_widths(line: &Line, length_px: f32, rope: &Rope, from_px: f32, reversed: bool) -> f32 {
    let last = (line.samples.len() - 1) as f32;
    // The known length of the rope may differ from its usual length.
    let stretch = rope.length_px / rope.usual_px;
    let sum: f32 = (0..COMPARED)
        .map(|k| {
            let t = k as f32 / (COMPARED - 1) as f32;
            let u = if reversed { 1.0 - t } else { t };
            let at = line.samples[(u * last).round() as usize].at;
            vec2::distance(at, rope.at(stretch * (from_px + t * length_px)))
        })
        .sum();
    sum / COMPARED as f32 / rope.width_px
}

/// Lengthens the last end of the line by up to `most_px`, in the shape of the rope's end. Returns
/// the added length.
fn extend(
    line: &mut Line,
    rope: &Rope,
    at_last: bool,
    most_px: f32,
    [mask, occluder]: [&BitPlane; 2],
) -> f32 {
    let n = line.samples.len();
    let length_px = line.length_px();
    let step_px = length_px / (n - 1) as f32;
    let count = |px: f32| (px / step_px).round().max(1.0) as usize;
    let replaced = count(REPLACED_WIDTHS * rope.width_px);
    let backed = count(BACKED_WIDTHS * rope.width_px);
    if n < 2 * (replaced + backed) {
        return 0.0;
    }
    let kept = n - 1 - replaced;
    let (last, anchor) = (line.samples[n - 1], line.samples[kept].at);
    let out = vec2::sub(anchor, line.samples[kept - backed].at);
    // Samples of a tip that was extended are closer together than the others.
    let replaced_px = arc_px(&line.samples[kept..]);
    let tip_px = most_px + replaced_px;
    let known = |to_tip_px: f32| {
        rope.at(if at_last {
            rope.length_px - to_tip_px
        } else {
            to_tip_px
        })
    };
    let known_out = vec2::sub(known(tip_px), known(tip_px + backed as f32 * step_px));
    let turn = vec2::angle(known_out, out);
    let (sin, cos) = libm::sincosf(turn);
    let steps = count(tip_px);
    let (mut bare, mut good) = (0, 0);
    // New samples are appended first. Afterwards, either they or the replaced ones are removed.
    for k in 1..=steps {
        let to_tip_px = tip_px * (1.0 - k as f32 / steps as f32);
        let [x, y] = vec2::sub(known(to_tip_px), known(tip_px));
        let at = vec2::add(anchor, [cos * x - sin * y, sin * x + cos * y]);
        if mask.has(at) || occluder.has(at) {
            (bare, good) = (0, k);
        } else {
            bare += 1;
            if bare as f32 * step_px > BARE_WIDTHS * rope.width_px {
                break;
            }
        }
        line.samples.push(Sample { at, ..last });
    }
    let more_px = good as f32 / steps as f32 * tip_px - replaced_px;
    if more_px < LEAST_WIDTHS * rope.width_px {
        line.samples.truncate(n);
        return 0.0;
    }
    line.samples.truncate(n + good);
    line.samples.drain(kept + 1..n);
    more_px
}

/// Arc length along these samples.
fn arc_px(samples: &[Sample]) -> f32 {
    let steps = samples.windows(2);
    steps.map(|s| vec2::distance(s[0].at, s[1].at)).sum()
}

/// Returns whether the table shows beyond both ends of a curve.
pub(crate) fn are_free(curve: &Curve, mask: &BitPlane) -> bool {
    let points = &curve.points;
    let n = points.len();
    if curve.closed || n < 8 {
        return false;
    }
    let step_px = curve.length_px / (n - 1) as f32;
    let back = ((curve.width_px / step_px.max(0.1)) as usize).clamp(1, n / 4);
    [[0, back], [n - 1, n - 1 - back]]
        .iter()
        .all(|&[tip, inner]| is_free(points[tip], points[inner], curve.width_px, mask))
}

/// Returns whether the table shows around a tip. `inner` is a place before it.
fn is_free(tip: Vec2, inner: Vec2, width_px: f32, mask: &BitPlane) -> bool {
    let out = vec2::unit_or(vec2::sub(tip, inner), [1.0, 0.0]);
    AROUND.iter().all(|&(cos, sin)| {
        let way = [cos * out[0] - sin * out[1], sin * out[0] + cos * out[1]];
        !mask.has(vec2::along(tip, way, BEYOND_WIDTHS * width_px))
    })
}

/// Shortens a line that is longer than its rope, at the end that is on something, if the other end
/// is free. A rope that slides along itself shows this only at its free end.
pub(crate) fn shorten(line: &mut Line, past: &Past, [mask, occluder]: [&BitPlane; 2]) {
    let n = line.samples.len();
    if line.closed || line.border.contains(&true) || n < 8 {
        return;
    }
    let length_px = line.length_px();
    let step_px = (length_px / (n - 1) as f32).max(0.1);
    let known = past.live().find(|rope| {
        let excess_px = length_px - rope.usual_px;
        let range_px = LEAST_WIDTHS * rope.width_px..MOST_OVER_WIDTHS * rope.width_px;
        let apart = |reversed| apart_widths(line, length_px, rope, 0.0, reversed);
        let is_near =
            apart(false).min(apart(true)) <= APART_WIDTHS + MOST_OVER_WIDTHS + past.moved();
        !rope.closed && rope.state.whole && range_px.contains(&excess_px) && is_near
    });
    let Some(rope) = known else {
        return;
    };
    let back = ((rope.width_px / step_px) as usize).clamp(1, n / 4);
    let free = [[0, back], [n - 1, n - 1 - back]].map(|ends| {
        let [tip, inner] = ends.map(|i| line.samples[i].at);
        is_free(tip, inner, rope.width_px, mask) && !occluder.has(tip)
    });
    let count = ((length_px - rope.usual_px) / step_px).round() as usize;
    match free {
        [true, false] => line.samples.truncate(n - count.min(n / 4)),
        [false, true] => drop(line.samples.drain(..count.min(n / 4))),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::past::State;

    const WIDTH_PX: f32 = 6.0;

    /// A rope along y = 100 from x = 20 to 140.
    fn past() -> Past {
        let points: Vec<Vec2> = (0..=60).map(|i| [20.0 + 2.0 * i as f32, 100.0]).collect();
        let mut past = Past::default();
        past.add_covered(
            false,
            [120.0, WIDTH_PX, 120.0],
            &points,
            [None; 2],
            State::SEEN,
        );
        past
    }

    /// The line extracted now, a pixel lower.
    fn read(from: i32, to: i32) -> Line {
        let sample = |x| Sample {
            at: [x as f32, 101.0],
            weight: 1.0,
            width_px: WIDTH_PX,
            side: 0.0,
        };
        Line {
            samples: (from..=to).map(sample).collect(),
            closed: false,
            border: [false; 2],
        }
    }

    /// A rope along y = 100, and a strand across it. Each extends from its first x to just before
    /// its second.
    fn mask(rope: [usize; 2], strand: [usize; 2]) -> BitPlane {
        let mut mask = BitPlane::default();
        mask.resize(200, 200);
        for y in 0..200 {
            mask.fill(y, strand[0], strand[1], true);
        }
        for y in 98..=104 {
            mask.fill(y, rope[0], rope[1], true);
        }
        mask
    }

    #[test]
    fn a_tip_that_a_strand_hides_is_where_the_ropes_length_says() {
        for (from, to) in [(20, 120), (40, 140)] {
            let mut line = read(from, to);
            let strand = if from == 20 { [121, 160] } else { [0, 40] };
            let added = lengthen(
                &mut line,
                &past(),
                [&mask([20, 141], strand), &BitPlane::default()],
            );
            let (first, last) = (line.samples[0].at, line.samples[line.samples.len() - 1].at);
            assert!((added[0] + added[1] - 20.0).abs() < 1.5, "{added:?}");
            assert!((first[0] - 20.0).abs() < 1.5 && (last[0] - 140.0).abs() < 1.5);
            assert!((first[1] - 101.0).abs() < 0.5 && (last[1] - 101.0).abs() < 0.5);
        }
    }

    #[test]
    fn a_rope_whose_tip_is_hidden_is_as_long_as_usual_however_close_its_samples_lie_there() {
        let mut line = read(20, 116);
        let last = line.samples[line.samples.len() - 1];
        line.samples.extend((1..=8).map(|k| Sample {
            at: [116.0 + 0.5 * k as f32, 101.0],
            ..last
        }));
        let mask = mask([20, 141], [121, 160]);
        lengthen(&mut line, &past(), [&mask, &BitPlane::default()]);
        let length_px = line.length_px();
        assert!((length_px - 120.0).abs() < 0.1, "{length_px}");
    }

    #[test]
    fn a_tip_that_shows_is_where_it_shows() {
        let mut line = read(20, 120);
        let added = lengthen(
            &mut line,
            &past(),
            [&mask([20, 121], [190, 199]), &BitPlane::default()],
        );
        assert_eq!((added, line.samples.len()), ([0.0; 2], 101));
    }

    #[test]
    fn a_tip_under_an_occluder_is_where_the_ropes_length_says() {
        let mut line = read(20, 120);
        let added = lengthen(
            &mut line,
            &past(),
            [&mask([20, 121], [190, 199]), &mask([121, 160], [121, 160])],
        );
        assert!((added[1] - 20.0).abs() < 1.5, "{added:?}");
    }

    #[test]
    fn a_refitted_rope_that_is_too_long_ends_sooner_where_it_lies_upon_a_strand() {
        let mut line = read(20, 150);
        let mask = mask([20, 151], [140, 190]);
        shorten(&mut line, &past(), [&mask, &BitPlane::default()]);
        let (first, last) = (line.samples[0].at, line.samples[line.samples.len() - 1].at);
        assert!(first[0] == 20.0 && (last[0] - 140.0).abs() < 1.5);
    }

    #[test]
    fn a_line_that_lies_elsewhere_is_no_part_of_the_rope() {
        let mut line = read(20, 120);
        for sample in &mut line.samples {
            sample.at[1] += 30.0;
        }
        assert_eq!(place(&line, &past()).map(|place| place.room_px), None);
    }
}
