//! Extends pieces at their ends, by steps along a slowly turning direction, to where the ribbon's
//! edges and color are found again.

use super::picture::Picture;
use super::pieces::{Fragment, Ground};
use super::{Color, Rib, distance, mix, unlikeness};
use crate::vec2::{self, Vec2};

/// Minimum length of a piece that is extended, in widths.
const LEAST_WIDTHS: f32 = 5.0;
/// Length of a step in pixels, and maximum number of steps.
const HOP_PX: f32 = 3.0;
const MOST: usize = 200;
/// Maximum number of ribs; with more, pieces are not extended.
pub(super) const MOST_TRACED: usize = 8192;
/// Maximum distance without finding anything, in widths and in pixels. If another piece may hide
/// the ribbon, each pixel counts only as `HIDDEN`.
const BLIND: (f32, f32) = (2.0, 12.0);
const HIDDEN: f32 = 0.3;
/// Distances to the side, and changes of width, that are tried, in pixels.
const ASIDE_PX: [f32; 7] = [-2.4, -1.6, -0.8, 0.0, 0.8, 1.6, 2.4];
const WIDER_PX: [f32; 3] = [-1.0, 0.0, 1.0];
/// Maximum difference of the mean color, and mean difference of the colors. Minimum difference at
/// the stronger edge, and the largest that counts.
const UNLIKE: (f32, f32) = (14.0, 22.0);
const EDGES: (f32, f32) = (20.0, 40.0);
/// Minimum worth of a place.
const WORTH: f32 = 10.0;
/// Maximum difference in color and maximum ratio of widths of another piece in which this one may
/// end.
const INTO: (f32, f32) = (20.0, 1.5);

/// State of a trace.
struct Walk {
    at: Vec2,
    along: Vec2,
    /// Curvature, in radians per pixel.
    turn: f32,
    width_px: f32,
    color: Color,
}

/// Extends all pieces. `traced` gets the ribs of all of them, including those that were found.
pub(super) fn run(
    picture: &Picture,
    ground: &mut Ground,
    (pieces, ribs): (&mut [Fragment], &[Rib]),
    traced: &mut Vec<Rib>,
) {
    traced.clear();
    for number in 0..pieces.len() {
        let piece = pieces[number];
        let own = &ribs[piece.from..piece.to];
        let from = traced.len();
        let is_long =
            traced.len() < MOST_TRACED && piece.length_px >= LEAST_WIDTHS * piece.width_px;
        if is_long {
            let turned = |i: usize| backward(own[own.len() - 1 - i.min(own.len() - 1)]);
            let begin = Walk::from_end(own.len(), piece.width_px, turned);
            walk(picture, ground, pieces, (number, begin), traced);
            // They were found from the inside out.
            traced[from..].reverse();
            traced[from..]
                .iter_mut()
                .for_each(|rib| *rib = backward(*rib));
        }
        let before = traced.len() - from;
        traced.extend_from_slice(own);
        if is_long {
            let begin = Walk::from_end(own.len(), piece.width_px, |i| own[i.min(own.len() - 1)]);
            walk(picture, ground, pieces, (number, begin), traced);
        }
        let after = traced.len() - from - before - own.len();
        ground.take(picture, &traced[from..], number);
        // Traced ribs count a third of their length, because their color was sought.
        let hops = (before + after) as f32;
        let piece = &mut pieces[number];
        (piece.from, piece.to) = (from, traced.len());
        piece.length_px += hops;
    }
}

/// The same rib, seen from the other side.
fn backward(rib: Rib) -> Rib {
    let [a, b] = rib.sides;
    Rib {
        along: vec2::scale(rib.along, -1.0),
        sides: [b, a],
        ..rib
    }
}

impl Walk {
    /// Starts at the last of some ribs.
    fn from_end(count: usize, width_px: f32, rib: impl Fn(usize) -> Rib) -> Self {
        let last = count - 1;
        let far = 4.min(last);
        let (end, inside, deep) = (
            rib(last),
            rib(last - far),
            rib(last.saturating_sub(2 * far)),
        );
        let way = vec2::sub(end.at, inside.at);
        let along = vec2::unit_or(way, end.along);
        let before = vec2::sub(inside.at, deep.at);
        let turn = match vec2::norm(before) {
            length_px if length_px > 4.0 => {
                let turn = vec2::cross(vec2::scale(before, 1.0 / length_px), along);
                turn.clamp(-0.5, 0.5) / (0.5 * (length_px + vec2::norm(way)))
            }
            _ => 0.0,
        };
        let colors = (0..=far).map(|i| rib(last - i).color);
        let share = 1.0 / (far + 1) as f32;
        Self {
            at: end.at,
            along,
            turn,
            width_px,
            color: colors.fold([0.0; 3], |sum: Color, color| {
                std::array::from_fn(|c| sum[c] + share * color[c])
            }),
        }
    }

    /// Turns by one step, and returns the place ahead.
    fn go(&mut self) -> Vec2 {
        let turned = vec2::along(self.along, vec2::normal(self.along), HOP_PX * self.turn);
        self.along = vec2::unit_or(turned, self.along);
        self.turn *= 0.97;
        vec2::along(self.at, self.along, HOP_PX)
    }

    /// Moves to a place that was found.
    fn turn_to(&mut self, found: &Rib) {
        let way = vec2::unit_or(vec2::sub(found.at, self.at), self.along);
        let along = vec2::add(vec2::scale(self.along, 0.65), vec2::scale(way, 0.35));
        let along = vec2::unit_or(along, self.along);
        self.turn = 0.9 * self.turn + 0.1 * vec2::cross(self.along, along) / HOP_PX;
        (self.at, self.along) = (found.at, along);
        self.width_px = 0.9 * self.width_px + 0.1 * found.width_px;
        self.color = mix(self.color, found.color, 0.1);
    }

    fn rib(&self, at: Vec2, sides: [Color; 2]) -> Rib {
        Rib {
            at,
            along: self.along,
            width_px: self.width_px,
            color: self.color,
            sides,
            quality: 0.0,
        }
    }
}

/// Walks on from the end of piece `number`, and adds the ribs that are found.
fn walk(
    picture: &Picture,
    ground: &Ground,
    pieces: &[Fragment],
    (number, mut walk): (usize, Walk),
    ribs: &mut Vec<Rib>,
) {
    let (mut good, mut blind_px) = (ribs.len(), 0.0);
    let (mut is_out, mut has_met) = (false, false);
    let mut sides = [[0.0; 3]; 2];
    for _ in 0..MOST {
        let ahead = walk.go();
        if picture
            .between(vec2::along(ahead, walk.along, 1.0))
            .is_none()
        {
            // Past the picture's border.
            ribs.push(walk.rib(vec2::along(walk.at, walk.along, 2.0 * HOP_PX), sides));
            good = ribs.len();
            break;
        }
        let there = ground.at(picture, ahead);
        is_out |= there != Some(number);
        let other = there.filter(|&other| is_out && other != number);
        let is_alike = other.is_some_and(|other| {
            unlikeness(pieces[other].color, walk.color) < INTO.0
                && pieces[other].wider(walk.width_px) < INTO.1
        });
        let found = (!is_alike).then(|| seek(picture, &walk, ahead)).flatten();
        if let Some(found) = found {
            walk.turn_to(&found);
            sides = found.sides;
            ribs.push(walk.rib(walk.at, sides));
            (good, blind_px, has_met) = (ribs.len(), 0.0, false);
            continue;
        }
        walk.at = ahead;
        ribs.push(walk.rib(ahead, sides));
        if is_alike && !has_met {
            // The ribbon ends here, or continues beyond.
            (good, blind_px, has_met) = (ribs.len(), 0.0, true);
        }
        blind_px += if other.is_some() { HIDDEN } else { 1.0 } * HOP_PX;
        if blind_px > (BLIND.0 * walk.width_px).max(BLIND.1) {
            break;
        }
    }
    ribs.truncate(good);
}

/// Finds the ribbon near a place, if it is there.
fn seek(picture: &Picture, walk: &Walk, ahead: Vec2) -> Option<Rib> {
    let normal = vec2::normal(walk.along);
    let (mut most, mut best) = (WORTH, None);
    for aside_px in ASIDE_PX {
        let at = vec2::along(ahead, normal, aside_px);
        for wider_px in WIDER_PX {
            let width_px = (walk.width_px + wider_px).max(3.0);
            let price = |worth: f32| worth - 2.0 * aside_px.abs() / 0.8 - 2.0 * wider_px.abs();
            // A candidate is dropped as soon as it cannot exceed the best one.
            let is_more = |worth: f32| price(worth) > most;
            if let Some((worth, rib)) = look(picture, walk, (at, normal, width_px), is_more) {
                (most, best) = (price(worth), Some(rib));
            }
        }
    }
    best
}

/// Worth of a ribbon of this width at a place, and its rib, if `is_more` accepts the worth. The
/// edges are tested first: few places have any, and the inside only reduces the worth.
fn look(
    picture: &Picture,
    walk: &Walk,
    (at, normal, width_px): (Vec2, Vec2, f32),
    is_more: impl Fn(f32) -> bool,
) -> Option<(f32, Rib)> {
    let beside = |off_px: f32| picture.between(vec2::along(at, normal, off_px));
    let half_px = 0.5 * width_px;
    let sides = [beside(half_px + 2.0)?, beside(-half_px - 2.0)?];
    let a = distance(sides[0], beside(half_px - 1.5)?).min(EDGES.1);
    let b = distance(sides[1], beside(1.5 - half_px)?).min(EDGES.1);
    let edges = a + b + 0.5 * a.min(b);
    if a.max(b) < EDGES.0 || !is_more(edges) {
        return None;
    }
    let (mut color, mut inside) = ([0.0; 3], [[0.0; 3]; 5]);
    for (i, own) in (-2i8..).zip(&mut inside) {
        *own = beside(0.25 * f32::from(i) * (width_px - 2.5).max(0.5))?;
        color = std::array::from_fn(|c: usize| color[c] + 0.2 * own[c]);
    }
    let unlike = unlikeness(color, walk.color);
    if unlike > UNLIKE.0 || !is_more(edges - 1.5 * unlike) {
        return None;
    }
    let spread = inside
        .iter()
        .fold(0.0, |sum, own| sum + 0.2 * unlikeness(*own, walk.color));
    let worth = edges - 1.5 * unlike - 0.5 * spread;
    if spread > UNLIKE.1 || !is_more(worth) {
        return None;
    }
    let rib = Rib {
        at,
        width_px,
        color,
        sides,
        ..Rib::default()
    };
    Some((worth, rib))
}
