//! Fragments of known ropes among the lines, in their order along each rope.
//!
//! A finger on a loop leaves two ends that point the same way. A hand on a crossing leaves four,
//! frayed by its rim. Such ends hardly tell where each strand continues. But each fragment runs
//! along a stretch of the prior's rope, and a rope does not tear.

use crate::centerline::line::Line;
use crate::past::{Move, Past, Rope};
use crate::vec2;

/// Minimum length of a fragment, in widths. A shorter one cannot be placed.
const LEAST_WIDTHS: f32 = 2.5;
/// Range along the rope in which a fragment is sought, to both sides of the place that its middle
/// suggests, in widths.
const ALONG_WIDTHS: f32 = 2.0;
/// Step of that search, in widths.
const STEP_WIDTHS: f32 = 0.25;
/// Maximum mean distance of a fragment from the rope, in widths, in addition to the ropes' mean
/// movement.
const APART_WIDTHS: f32 = 1.0;
/// Maximum overlap of two fragments along a rope, in widths.
const DOUBLED_WIDTHS: f32 = 2.0;
/// Number of intervals between the places of a fragment whose movement is listed.
const MOVES: usize = 12;
/// Minimum length of a fragment whose common movement is discounted, in widths.
const LONG_WIDTHS: f32 = 8.0;
/// Weight of its common movement, relative to its remaining distance from the rope.
const SHIFTED: f32 = 0.35;
/// Number of places along a fragment that are compared with the rope.
const COMPARED: usize = 32;

/// A fragment of a rope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fragment {
    pub(super) line: usize,
    /// Index of the rope in the prior.
    pub(super) rope: u32,
    /// Start along the rope, in arc length.
    pub(super) from_px: f32,
    /// End along the rope, in arc length.
    pub(super) to_px: f32,
    /// True if the line runs against the rope.
    pub(super) reversed: bool,
    /// Mean distance from the rope, in its widths (see `apart_widths`).
    pub(super) off: f32,
}

/// Lists the fragments among `lines`, rope by rope and in their order along each. If two overlap by
/// more than `DOUBLED_WIDTHS`, drops the shorter.
pub(super) fn list(lines: &[Line], past: &Past, pieces: &mut Vec<Fragment>) {
    pieces.clear();
    let placed = lines.iter().enumerate();
    pieces.extend(placed.filter_map(|(l, line)| place(l, line, past)));
    pieces.sort_unstable_by(|a, b| {
        let by_rope = a.rope.cmp(&b.rope);
        by_rope.then(a.from_px.total_cmp(&b.from_px))
    });
    pieces.dedup_by(|piece, before| {
        let width_px = past.ropes()[piece.rope as usize].width_px;
        let is_doubled =
            piece.rope == before.rope && piece.from_px - before.to_px < -DOUBLED_WIDTHS * width_px;
        if is_doubled && piece.length_px() > before.length_px() {
            *before = *piece;
        }
        is_doubled
    });
}

impl Fragment {
    fn length_px(&self) -> f32 {
        self.to_px - self.from_px
    }

    /// Lists the movement of places on the fragment, which is `line`, from its start to its end.
    pub(super) fn list_moves(&self, line: &Line, past: &Past, moves: &mut Vec<Move>) {
        let rope = &past.ropes()[self.rope as usize];
        let last = line.samples.len() - 1;
        moves.extend((0..=MOVES).map(|k| {
            let t = k as f32 / MOVES as f32;
            let u = if self.reversed { 1.0 - t } else { t };
            let at = line.samples[(u * last as f32).round() as usize].at;
            let along_px = self.from_px + t * self.length_px();
            Move {
                rope: self.rope,
                along_px,
                by: vec2::sub(at, rope.at(along_px)),
            }
        }));
    }
}

/// Places a line along the open rope with the least mean distance. `None` if the line is too short
/// or that distance is too large.
fn place(l: usize, line: &Line, past: &Past) -> Option<Fragment> {
    let n = line.samples.len();
    if line.closed || n < 8 {
        return None;
    }
    let length_px = line.length_px();
    let (middle, beside) = (n / 2, (n / 8).max(1));
    let at = |i: usize| line.samples[i].at;
    let toward = vec2::sub(at(middle + beside), at(middle - beside));
    let mut best: Option<Fragment> = None;
    for trace in past.recall(at(middle), toward).iter() {
        let rope = &past.ropes()[trace.rope as usize];
        if rope.closed || length_px < LEAST_WIDTHS * rope.width_px {
            continue;
        }
        let steps = (ALONG_WIDTHS / STEP_WIDTHS) as i32;
        for step in -steps..=steps {
            let from_px =
                trace.along_px - 0.5 * length_px + STEP_WIDTHS * rope.width_px * step as f32;
            let off = apart_widths(line, length_px, rope, from_px, !trace.ahead);
            if best.is_none_or(|best| off < best.off) {
                best = Some(Fragment {
                    line: l,
                    rope: trace.rope,
                    from_px,
                    to_px: from_px + length_px,
                    reversed: !trace.ahead,
                    off,
                });
            }
        }
    }
    best.filter(|piece| piece.off <= APART_WIDTHS + past.moved())
}

/// Mean distance of a line from the stretch of the rope that starts at `from_px`, in widths. In a
/// long fragment, the common movement of all places has the weight `SHIFTED`.
fn apart_widths(line: &Line, length_px: f32, rope: &Rope, from_px: f32, reversed: bool) -> f32 {
    let last = (line.samples.len() - 1) as f32;
    let apart = |k: usize| {
        let t = k as f32 / (COMPARED - 1) as f32;
        let u = if reversed { 1.0 - t } else { t };
        let at = line.samples[(u * last).round() as usize].at;
        vec2::sub(at, rope.at(from_px + t * length_px))
    };
    let mean = |sum: f32| sum / COMPARED as f32 / rope.width_px;
    let sum = (0..COMPARED).map(apart).fold([0.0; 2], vec2::add);
    let shift = vec2::scale(sum, 1.0 / COMPARED as f32);
    let bent = (0..COMPARED).map(|k| vec2::distance(apart(k), shift)).sum();
    let moved = vec2::norm(shift) / rope.width_px;
    match length_px >= LONG_WIDTHS * rope.width_px {
        true => mean(bent) + SHIFTED * moved,
        false => mean((0..COMPARED).map(|k| vec2::norm(apart(k))).sum()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centerline::line::Sample;
    use crate::vec2::Vec2;

    fn line(from: Vec2, to: Vec2) -> Line {
        let count = vec2::distance(from, to) as usize;
        let at = |i| vec2::along(from, vec2::sub(to, from), i as f32 / count as f32);
        let sample = |i| Sample {
            at: at(i),
            weight: 1.0,
            width_px: 6.0,
            side: 0.0,
        };
        Line {
            samples: (0..=count).map(sample).collect(),
            closed: false,
            border: [false; 2],
        }
    }

    #[test]
    fn a_long_piece_may_have_moved_as_one_and_says_how_far() {
        let mut past = Past::default();
        let arc = |off: f32| {
            move |i: u8| {
                let (sin, cos) = libm::sincosf(0.02 * f32::from(i));
                [150.0 + 100.0 * cos + off, 150.0 + 100.0 * sin]
            }
        };
        let points: Vec<Vec2> = (0..=120).map(arc(0.0)).collect();
        past.add(false, [240.0, 6.0], &points);
        let sample = |at| Sample {
            at,
            weight: 1.0,
            width_px: 6.0,
            side: 0.0,
        };
        let moved = Line {
            samples: (20..=80).map(arc(15.0)).map(sample).collect(),
            closed: false,
            border: [false; 2],
        };
        past.check(moved.samples.iter().map(|s| s.at));
        let (mut pieces, mut moves) = (Vec::new(), Vec::new());
        list(std::slice::from_ref(&moved), &past, &mut pieces);
        assert!((pieces[0].from_px - 40.0).abs() < 4.0, "{:?}", pieces[0]);
        pieces[0].list_moves(&moved, &past, &mut moves);
        let is_near = |m: &Move| vec2::distance(m.by, [15.0, 0.0]) < 4.0;
        assert!(moves.iter().all(is_near), "{moves:?}");
    }

    #[test]
    fn the_pieces_of_a_rope_are_told_in_their_order_whichever_way_they_run() {
        let mut past = Past::default();
        let points: Vec<Vec2> = (0..=60).map(|i| [20.0 + 5.0 * i as f32, 100.0]).collect();
        past.add(false, [300.0, 6.0], &points);
        let lines = [
            line([300.0, 102.0], [220.0, 102.0]),
            line([30.0, 30.0], [130.0, 30.0]),
            line([20.0, 101.0], [160.0, 101.0]),
        ];
        let mut pieces = Vec::new();
        list(&lines, &past, &mut pieces);
        let found: Vec<_> = pieces.iter().map(|p| (p.line, p.reversed)).collect();
        assert_eq!(found, [(2, false), (0, true)]);
        assert!((pieces[1].from_px - 200.0).abs() < 2.0, "{:?}", pieces[1]);
    }
}
