//! Handles ropes whose ends touch, and a rope whose own two ends touch. The image shows a single
//! rope or a ring there, and the prior overrules the image.

use crate::centerline::line::Line;
use crate::past::Past;
use crate::vec2::{self, Vec2};

/// Distance from a joint, on both sides, at which the ropes are identified, in widths.
const BESIDE_WIDTHS: f32 = 2.5;
/// Distance from an end of the line, in widths, within which a rope's end belongs there.
const OWN_WIDTHS: f32 = 3.0;

/// Length of a ring, relative to the open rope that it was. The rope's ends are next to each other,
/// or nearly meet.
const SAME_LENGTH: std::ops::Range<f32> = 0.5..1.06;

/// Cuts `line` where it runs over a rope's end into something else. The part cut off an open line
/// goes to `rest`, and a ring is opened. Returns whether there is a rest.
pub(crate) fn part(line: &mut Line, past: &Past, rest: &mut Line) -> bool {
    if line.closed && open_again(line, past) {
        return false;
    }
    let Some(i) = joint(line, past) else {
        return false;
    };
    if line.closed {
        line.samples.rotate_left(i);
        line.closed = false;
        return false;
    }
    rest.clear();
    rest.samples.extend(line.samples.drain(i..));
    rest.border = [false, line.border[1]];
    line.border[1] = false;
    true
}

/// Opens a ring where the prior has an open rope, whose ends are now next to or on each other. The
/// line then runs from the rope's start to its end, twice over the stretch where both ends are.
fn open_again(line: &mut Line, past: &Past) -> bool {
    let n = line.samples.len();
    let ring_px = line.length_px();
    if n < 8 || past.live().any(|rope| rope.closed) {
        return false;
    }
    let step_px = ring_px / n as f32;
    let nearest = |at: Vec2| {
        let apart = |i: &usize| vec2::distance(line.samples[*i].at, at);
        let i = (0..n).min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        Some((i, apart(&i)))
    };
    let found = past.live().find_map(|rope| {
        if !SAME_LENGTH.contains(&(ring_px / rope.length_px)) {
            return None;
        }
        let places = [0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0];
        let mut on = [0; 7];
        for (i, share) in on.iter_mut().zip(places) {
            let (place, apart_px) = nearest(rope.at(share * rope.length_px))?;
            if apart_px > past.reach_px(rope.width_px) {
                return None;
            }
            *i = place;
        }
        // True if the ring runs in the rope's direction. The way from the rope's first quarter to
        // its middle is then at most half the ring.
        let ahead = (on[3] + n - on[2]) % n <= n / 2;
        let way = |from: usize, to: usize| {
            let (from, to) = if ahead { (from, to) } else { (to, from) };
            (to + n - from) % n
        };
        // The line runs once around and on to the last point, or ends there just before a full
        // turn.
        let short = way(on[0], on[6]);
        let off = |count: usize| (count as f32 * step_px - rope.length_px).abs();
        let count = if off(short + n) < off(short) {
            short + n
        } else {
            short
        };
        Some((on[0], ahead, count.clamp(n / 2, 2 * n)))
    });
    let Some((first, ahead, count)) = found else {
        return false;
    };
    line.samples.rotate_left(first);
    if !ahead {
        line.samples[1..].reverse();
    }
    line.closed = false;
    for i in n..count {
        line.samples.push(line.samples[i - n]);
    }
    line.samples.truncate(count);
    true
}

/// Sample at which two ropes meet at the end of one. A known end must be near, and the prior must
/// deny that both sides of the sample are one strand.
fn joint(line: &Line, past: &Past) -> Option<usize> {
    let n = line.samples.len();
    if n < 8 {
        return None;
    }
    let step_px = (line.length_px() / n as f32).max(0.1);
    past.ends().find_map(|(end, width_px)| {
        let apart = |i: &usize| vec2::distance(line.samples[*i].at, end);
        let i = (0..n).min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        if apart(&i) > past.reach_px(width_px) {
            return None;
        }
        // A line much shorter than its rope is wide has no room for it.
        let beside = ((BESIDE_WIDTHS * width_px / step_px) as usize).clamp(2, n / 4);
        let own = ((OWN_WIDTHS * width_px / step_px) as usize).max(beside + 1);
        if !line.closed && (i < own || i + own >= n) {
            return None;
        }
        let at = |k: usize| line.samples[k % n].at;
        let (before, after) = (i + n - beside, i + n + beside);
        // Both directions lead to the joint.
        let toward = |from: usize, to: usize| vec2::sub(at(to), at(from));
        let traces = [
            past.recall(at(before), toward(before, before + beside / 2 + 1)),
            past.recall(at(after), toward(after, after - beside / 2 - 1)),
        ];
        let chord_px = vec2::distance(at(before), at(after));
        past.denies(&traces[0], &traces[1], chord_px).then_some(i)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centerline::line::Sample;
    use crate::vec2::Vec2;

    fn line(closed: bool) -> Line {
        let samples = (0..200)
            .map(|i| Sample {
                at: [20.0 + i as f32, 100.0],
                weight: 1.0,
                width_px: 6.0,
                side: 0.0,
            })
            .collect();
        Line {
            samples,
            closed,
            border: [false; 2],
        }
    }

    fn past(ropes: &[[f32; 2]]) -> Past {
        let mut past = Past::default();
        for &[from, to] in ropes {
            let points: Vec<Vec2> = (0..=40)
                .map(|i| [from + (to - from) * i as f32 / 40.0, 101.0])
                .collect();
            past.add(false, [to - from, 6.0], &points);
        }
        past
    }

    #[test]
    fn two_ropes_that_touch_by_their_ends_are_parted() {
        let (mut whole, mut rest) = (line(false), Line::default());
        assert!(part(
            &mut whole,
            &past(&[[20.0, 98.0], [104.0, 220.0]]),
            &mut rest
        ));
        assert!((whole.samples.len() as f32 - 80.0).abs() < 6.0);
        assert_eq!(whole.samples.len() + rest.samples.len(), 200);
    }

    #[test]
    fn one_rope_stays_one() {
        let (mut whole, mut rest) = (line(false), Line::default());
        assert!(!part(&mut whole, &past(&[[20.0, 220.0]]), &mut rest));
        // The rope has grown, as it comes out from under something.
        assert!(!part(&mut whole, &past(&[[20.0, 120.0]]), &mut rest));
        assert_eq!(whole.samples.len(), 200);
    }
}
