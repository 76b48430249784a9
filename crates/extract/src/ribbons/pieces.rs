//! Makes pieces of ribbon from chains, the best first. Each piece gets only what no better piece
//! has taken. Pieces that are only ground, or shadow next to a better piece, are left out.

use super::chains::{Chain, Chainer};
use super::picture::Picture;
use super::spans::Span;
use super::{Rib, is_shade, unlikeness};
use crate::statistics;
use crate::vec2::{self, Vec2};

/// Maximum number of pieces.
pub(super) const MOST: usize = 250;
/// Minimum length of a piece, in pixels and in widths, and its minimum number of ribs.
const SHORTEST: (f32, f32, usize) = (16.0, 1.5, 3);
/// Maximum number of ribs of all pieces together.
pub(super) const MOST_RIBS: usize = 8192;
/// Distance from an edge at which an adjacent ribbon begins, and its maximum width, in pixels.
const BESIDE_PX: f32 = 3.0;
const ACROSS_PX: usize = 80;
/// A piece is ground if more than the share `BESIDE` of its ribs are next to other pieces, and more
/// than the share `GROUND` of those ribs look like ground.
const BESIDE: f32 = 0.4;
const GROUND: f32 = 0.5;

/// Ribs that follow each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fragment {
    /// Range of its ribs among all.
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) length_px: f32,
    pub(super) width_px: f32,
    pub(super) color: super::Color,
}

impl Fragment {
    /// A piece of these ribs, which begin at index `from` among all.
    pub(super) fn of(ribs: &[Rib], from: usize, widths: &mut Vec<f32>) -> Self {
        widths.clear();
        widths.extend(ribs.iter().map(|rib| rib.width_px));
        let share = 1.0 / ribs.len() as f32;
        let color = ribs.iter().fold([0.0; 3], |sum: super::Color, rib| {
            std::array::from_fn(|c| sum[c] + share * rib.color[c])
        });
        let steps = ribs
            .windows(2)
            .map(|pair| vec2::distance(pair[0].at, pair[1].at));
        Self {
            from,
            to: from + ribs.len(),
            length_px: steps.sum(),
            width_px: statistics::median(widths),
            color,
        }
    }

    /// Ratio of the larger of the two widths to the smaller.
    pub(super) fn wider(&self, other: f32) -> f32 {
        (self.width_px / other).max(other / self.width_px)
    }
}

/// The piece that has taken each pixel, as its number from 1.
#[derive(Debug, Default)]
pub(super) struct Ground {
    taken: Vec<u16>,
    widths: Vec<f32>,
}

impl Ground {
    /// Reserves the buffers for a picture of this many pixels.
    pub(super) fn reserve(&mut self, pixels: usize) {
        self.taken.reserve(pixels);
        self.widths.reserve(MOST_RIBS);
    }

    /// The piece that has taken the pixel at a place, if any.
    pub(super) fn at(&self, picture: &Picture, at: Vec2) -> Option<usize> {
        let taken = self.taken[picture.index(at)?];
        (taken > 0).then(|| usize::from(taken) - 1)
    }

    /// Returns whether the pixel is taken.
    pub(super) fn is_taken(&self, index: usize) -> bool {
        self.taken[index] > 0
    }

    /// Gives a piece the free pixels between its ribs.
    pub(super) fn take(&mut self, picture: &Picture, ribs: &[Rib], piece: usize) {
        for pair in ribs.windows(2) {
            let steps = vec2::distance(pair[0].at, pair[1].at).max(1.0) as usize + 1;
            for i in 0..=steps {
                let share = i as f32 / steps as f32;
                let half_px =
                    0.5 * (pair[0].width_px + share * (pair[1].width_px - pair[0].width_px));
                let middle = vec2::along(pair[0].at, vec2::sub(pair[1].at, pair[0].at), share);
                let normal = vec2::normal(pair[0].along);
                let place = |off_px: f32| vec2::along(middle, normal, off_px);
                let is_inside = [-half_px, half_px]
                    .iter()
                    .all(|&off_px| picture.index(place(off_px)).is_some());
                let mut off_px = -half_px;
                while off_px <= half_px {
                    let index = match is_inside {
                        true => Some(picture.index_inside(place(off_px))),
                        false => picture.index(place(off_px)),
                    };
                    if let Some(index) = index
                        && self.taken[index] == 0
                    {
                        self.taken[index] = piece as u16 + 1;
                    }
                    off_px += 0.7;
                }
            }
        }
    }
}

/// Makes pieces of the chains.
pub(super) fn take(
    picture: &Picture,
    chainer: &Chainer,
    ground: &mut Ground,
    (pieces, ribs): (&mut Vec<Fragment>, &mut Vec<Rib>),
) {
    ground.taken.clear();
    ground.taken.resize(picture.width * picture.height, 0);
    pieces.clear();
    ribs.clear();
    for chain in &chainer.chains {
        let spans = &chainer.links[chain.from..chain.to];
        let is_free = |i: usize| !is_covered(picture, ground, chain, &spans[i]);
        let mut i = 0;
        // The free parts of the chain may be several pieces.
        let mut runs = [(0, 0); 8];
        let mut count = 0;
        while i < spans.len() && count < runs.len() {
            if !is_free(i) {
                i += 1;
                continue;
            }
            let first = i;
            // A single span that is taken does not split a run.
            while i + 1 < spans.len() && (is_free(i + 1) || i + 2 < spans.len() && is_free(i + 2)) {
                i += 1;
            }
            // Add one span on each side, so that pieces meet.
            runs[count] = (first.saturating_sub(1), (i + 2).min(spans.len()));
            count += 1;
            i += 1;
        }
        for &(first, last) in &runs[..count] {
            if pieces.len() == MOST || ribs.len() > MOST_RIBS - spans.len() {
                return;
            }
            let from = ribs.len();
            lay(chain, &spans[first..last], ribs);
            let piece = Fragment::of(&ribs[from..], from, &mut ground.widths);
            let own = &ribs[from..];
            let is_short = own.len() < SHORTEST.2
                || piece.length_px < SHORTEST.0.max(SHORTEST.1 * piece.width_px);
            if is_short || is_ground(picture, ground, own) {
                ribs.truncate(from);
                continue;
            }
            ground.take(picture, own, pieces.len());
            pieces.push(piece);
        }
    }
}

/// Returns whether at least half of a span is taken.
fn is_covered(picture: &Picture, ground: &Ground, chain: &Chain, span: &Span) -> bool {
    let (mut all, mut taken) = (0, 0);
    let mut at = span.from;
    while at <= span.to {
        all += 1;
        taken += u32::from(ground.at(picture, place(chain, span, at)).is_some());
        at += 1.0;
    }
    2 * taken >= all
}

/// A place on a span's line.
fn place(chain: &Chain, span: &Span, at: f32) -> Vec2 {
    match chain.is_down {
        true => [at, span.line_px()],
        false => [span.line_px(), at],
    }
}

/// Adds the ribs of some spans of a chain.
fn lay(chain: &Chain, spans: &[Span], ribs: &mut Vec<Rib>) {
    let middle = |i: usize| place(chain, &spans[i], spans[i].middle());
    for (i, span) in spans.iter().enumerate() {
        let (before, after) = (i.saturating_sub(2), (i + 2).min(spans.len() - 1));
        let way = vec2::sub(middle(after), middle(before));
        let (along, across) = match chain.is_down {
            true => (vec2::unit_or(way, [0.0, 1.0]), 1),
            false => (vec2::unit_or(way, [1.0, 0.0]), 0),
        };
        let [a, b] = span.sides;
        ribs.push(Rib {
            at: middle(i),
            along,
            // The line cuts the ribbon at an angle.
            width_px: span.width_px() * along[across],
            color: span.color,
            // The normal points to lower columns if the ribbon goes down, and to higher rows if it
            // goes right.
            sides: if chain.is_down { [a, b] } else { [b, a] },
            quality: span.quality,
        });
    }
}

/// Returns whether ribs next to better pieces are the ground there, or the ground in shadow.
fn is_ground(picture: &Picture, ground: &Ground, ribs: &[Rib]) -> bool {
    let (mut beside, mut shade) = (0.0, 0.0);
    for rib in ribs {
        let (mut is_beside, mut is_ground) = (false, false);
        let mut free = [true; 2];
        for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
            let off_px = sign * (0.5 * rib.width_px + BESIDE_PX);
            let Some(number) = ground.at(picture, rib.aside(off_px)) else {
                continue;
            };
            (is_beside, free[k]) = (true, false);
            // Find the first place beyond that piece.
            let beyond = (1..ACROSS_PX)
                .map(|px| off_px + sign * px as f32)
                .find(|&px| ground.at(picture, rib.aside(px)) != Some(number));
            let place = beyond.map(|px| rib.aside(px + sign * BESIDE_PX));
            if let Some(place) = place
                && ground.at(picture, place).is_none()
                && let Some(color) = picture.between(place)
            {
                is_ground |= is_shade(rib.color, color, picture.noise);
            }
        }
        let own = (0..2).any(|k| free[k] && is_shade(rib.color, rib.sides[k], picture.noise));
        if is_beside {
            beside += 1.0;
            shade += f32::from(u8::from(is_ground || own));
        }
    }
    beside > BESIDE * ribs.len() as f32 && shade > GROUND * beside
}

/// Returns whether two pieces look as if they may be of one rope.
pub(super) fn are_alike(a: &Fragment, b: &Fragment, unlike: f32, wider: f32) -> bool {
    unlikeness(a.color, b.color) < unlike && a.wider(b.width_px) < wider
}
