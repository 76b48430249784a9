//! Groups pieces that continue each other, and weighs whether each group is a rope.

use lariat_portable::{Arch, NullaryFnOnce};

use super::picture::Picture;
use super::pieces::{Fragment, Ground, are_alike};
use super::{Color, Rib, unlikeness};
use crate::statistics::{self, grade};
use crate::vec2::{self, Vec2};

/// Maximum gap between two ends that continue each other, in widths and in pixels.
const GAP: (f32, f32) = (7.0, 30.0);
/// Maximum difference in color and maximum ratio of widths of such ends. Minimum cosine of the turn
/// from one end to the other, and of the turn from each end to the gap.
const UNLIKE: f32 = 25.0;
const WIDER: f32 = 1.7;
const FACING: f32 = 0.6;
const STRAIGHT: f32 = 0.75;
/// Maximum cost of a link.
const COST: f32 = 9.0;
/// Maximum difference in color and maximum ratio of widths of a piece that an end lies on.
const ON: (f32, f32) = (20.0, 1.6);
/// Minimum evidence that a group is a rope, and its minimum length in pixels.
const ROPE: f32 = 4.0;
const SHORTEST_PX: f32 = 40.0;
/// Minimum evidence and length of a group whose width counts as one that ropes have in this
/// picture.
const SURE: (f32, f32) = (4.5, 60.0);
/// Weight of the evidence that a group has such a width or not.
const FITS: f32 = 1.2;
/// Weight of the network's probability for a group, compared with one half.
const LIKELY: f32 = 6.0;
/// Step between the pixels that are compared with a group's color.
const STRIDE: usize = 5;

/// An end of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) piece: usize,
    pub(super) rib: usize,
    pub(super) at: Vec2,
    /// Outward direction.
    pub(super) along: Vec2,
    /// The end that it is linked with.
    pub(super) linked: Option<usize>,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(super) struct Grouper {
    /// Two per piece: its first and its last.
    pub(super) ends: Vec<End>,
    links: Vec<(f32, u32, u32)>,
    /// Group of each piece, identified by one of its pieces.
    group: Vec<usize>,
    /// Values of each group, at the index of that piece.
    lengths: Vec<f32>,
    widths: Vec<f32>,
    evidence: Vec<f32>,
    grid: Grid,
    ribs: Vec<Rib>,
    values: Vec<f32>,
    sure: Vec<f32>,
    is_rope: Vec<bool>,
}

impl Grouper {
    /// Reserves the buffers for this many pieces, and for a picture of this size.
    pub(super) fn reserve(&mut self, [width, height]: [usize; 2], pieces: usize, ribs: usize) {
        self.grid
            .reserve((width / STRIDE + 1) * (height / STRIDE + 1));
        self.ends.reserve(2 * pieces);
        // Each end faces few others.
        self.links.reserve(8 * pieces);
        self.group.reserve(pieces);
        for values in [&mut self.lengths, &mut self.widths, &mut self.evidence] {
            values.reserve(pieces);
        }
        self.ribs.reserve(ribs);
        self.values.reserve(ribs);
        self.sure.reserve(pieces);
        self.is_rope.reserve(pieces);
    }

    /// Groups the pieces and decides which are rope.
    pub(super) fn run(
        &mut self,
        picture: &Picture,
        ground: &Ground,
        pieces: &[Fragment],
        ribs: &[Rib],
    ) {
        self.find_ends(pieces, ribs);
        self.group.clear();
        self.group.extend(0..pieces.len());
        self.link(pieces);
        self.lay_on(picture, ground, pieces);
        self.grid.take(picture, ground);
        self.weigh(picture, pieces, ribs);
    }

    /// Returns whether a piece is part of a rope.
    pub(super) fn is_rope(&self, piece: usize) -> bool {
        self.is_rope[piece]
    }

    fn find_ends(&mut self, pieces: &[Fragment], ribs: &[Rib]) {
        self.ends.clear();
        for (number, piece) in pieces.iter().enumerate() {
            let own = &ribs[piece.from..piece.to];
            let last = own.len() - 1;
            for (end, inside) in [(0, 3.min(last)), (last, last - 3.min(last))] {
                let way = vec2::sub(own[end].at, own[inside].at);
                self.ends.push(End {
                    piece: number,
                    rib: piece.from + end,
                    at: own[end].at,
                    along: vec2::unit_or(way, own[end].along),
                    linked: None,
                });
            }
        }
    }

    /// Links ends that face each other, the cheapest pairs first.
    fn link(&mut self, pieces: &[Fragment]) {
        self.links.clear();
        for (i, a) in self.ends.iter().enumerate() {
            for (j, b) in self.ends.iter().enumerate().skip(i + 1) {
                if let Some(cost) = cost(pieces, a, b).filter(|&cost| cost <= COST) {
                    self.links.push((cost, i as u32, j as u32));
                }
            }
        }
        (self.links).sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for k in 0..self.links.len() {
            let (i, j) = (self.links[k].1 as usize, self.links[k].2 as usize);
            if self.ends[i].linked.is_none() && self.ends[j].linked.is_none() {
                (self.ends[i].linked, self.ends[j].linked) = (Some(j), Some(i));
                self.unite(self.ends[i].piece, self.ends[j].piece);
            }
        }
    }

    /// Groups each piece with what its ends lie on.
    fn lay_on(&mut self, picture: &Picture, ground: &Ground, pieces: &[Fragment]) {
        for i in 0..self.ends.len() {
            let End {
                piece, at, along, ..
            } = self.ends[i];
            for widths in [0.0, 0.5, 1.0] {
                let place = vec2::along(at, along, widths * pieces[piece].width_px);
                if let Some(other) = ground.at(picture, place)
                    && other != piece
                    && are_alike(&pieces[piece], &pieces[other], ON.0, ON.1)
                {
                    self.unite(piece, other);
                }
            }
        }
    }

    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.group[a.max(b)] = a.min(b);
    }

    fn root(&mut self, mut piece: usize) -> usize {
        while self.group[piece] != piece {
            self.group[piece] = self.group[self.group[piece]];
            piece = self.group[piece];
        }
        piece
    }

    /// Weighs every group.
    fn weigh(&mut self, picture: &Picture, pieces: &[Fragment], ribs: &[Rib]) {
        let count = pieces.len();
        for values in [&mut self.lengths, &mut self.widths, &mut self.evidence] {
            values.clear();
            values.resize(count, 0.0);
        }
        for (piece, own) in pieces.iter().enumerate() {
            let group = self.root(piece);
            self.lengths[group] += own.length_px;
        }
        for group in 0..count {
            if self.root(group) == group {
                self.widths[group] = pieces[group].width_px;
                self.evidence[group] = self.evidence_of(picture, group, (pieces, ribs));
            }
        }
        let sure = (0..count).filter(|&k| self.evidence[k] >= SURE.0 && self.lengths[k] > SURE.1);
        self.sure.clear();
        self.sure.extend(sure.map(|k| self.widths[k]));
        self.is_rope.clear();
        for piece in 0..count {
            let group = self.root(piece);
            let fits = self.fits(self.widths[group]);
            let is_rope = self.evidence[group] + fits >= ROPE && self.lengths[group] >= SHORTEST_PX;
            self.is_rope.push(is_rope);
        }
    }

    /// Evidence from a width: positive if certain ropes have about the same width, and negative if
    /// not.
    fn fits(&self, width_px: f32) -> f32 {
        let wider = self
            .sure
            .iter()
            .map(|sure| (sure / width_px).max(width_px / sure));
        match wider.reduce(f32::min) {
            Some(wider) => FITS * (grade(wider, 1.8, 1.2) - 0.5),
            None => 0.0,
        }
    }

    /// Sum of the evidence that a group is a rope.
    fn evidence_of(
        &mut self,
        picture: &Picture,
        group: usize,
        (pieces, ribs): (&[Fragment], &[Rib]),
    ) -> f32 {
        self.ribs.clear();
        for (piece, own) in pieces.iter().enumerate() {
            if self.root(piece) == group {
                let ribs = ribs[own.from..own.to].iter();
                // Traced ribs are left out.
                self.ribs.extend(ribs.filter(|rib| rib.quality > 0.0));
            }
        }
        let values = &mut self.values;
        let ribs = &self.ribs[..];
        let mut median = |of: &dyn Fn(&Rib) -> f32| {
            values.clear();
            values.extend(ribs.iter().map(of));
            statistics::median(values)
        };
        let share = 1.0 / ribs.len() as f32;
        let mean = |of: &dyn Fn(&Rib) -> f32| share * ribs.iter().map(of).sum::<f32>();
        let unlike = median(&|rib| {
            let [a, b] = rib.sides.map(|side| unlikeness(rib.color, side));
            a.min(b)
        });
        let color = [0, 1, 2].map(|c| median(&|rib| rib.color[c]));
        let middle = mean(&|rib| rib.width_px);
        let uneven = mean(&|rib| (rib.width_px - middle) * (rib.width_px - middle)).sqrt() / middle;
        let width_px = pieces[group].width_px;
        let bend = off_line_px(ribs, share) / width_px.max(4.0);
        let likely = mean(&|rib| picture.likely_at(rib.at));
        let rare = (self.grid).rarity(color, (0.4 * unlike).clamp(5.0, 14.0));
        LIKELY * (likely - 0.5)
            + grade(median(&|rib| rib.quality), 2.5, 6.0)
            + grade(unlike, 15.0, 50.0)
            + grade(self.lengths[group] / width_px, 8.0, 60.0)
            - 2.0 * grade(uneven, 0.15, 0.5)
            - 1.5 * grade(bend, 0.6, 0.2) * (1.0 - 0.7 * grade(unlike, 40.0, 80.0))
            + 1.5 * grade(rare, -1.5, 1.5)
    }
}

/// Cost of linking two ends; `None` if they do not continue each other.
fn cost(pieces: &[Fragment], a: &End, b: &End) -> Option<f32> {
    let (one, other) = (&pieces[a.piece], &pieces[b.piece]);
    let facing = -vec2::dot(a.along, b.along);
    if facing < FACING || a.piece == b.piece {
        return None;
    }
    let width_px = one.width_px.max(other.width_px);
    let way = vec2::sub(b.at, a.at);
    let gap_px = vec2::norm(way);
    if gap_px > (GAP.0 * width_px).max(GAP.1) || !are_alike(one, other, UNLIKE, WIDER) {
        return None;
    }
    let straight = match gap_px > width_px {
        true => [
            vec2::dot(a.along, way) / gap_px,
            -vec2::dot(b.along, way) / gap_px,
        ],
        false => [facing; 2],
    };
    if straight[0].min(straight[1]) < STRAIGHT {
        return None;
    }
    let turn = 8.0 * (2.0 - straight[0] - straight[1]) + 4.0 * (1.0 - facing);
    let unlike = 0.1 * unlikeness(one.color, other.color) + 2.0 * (one.wider(other.width_px) - 1.0);
    Some(gap_px / width_px + turn + unlike)
}

/// Root-mean-square distance of some ribs from a straight line through them.
fn off_line_px(ribs: &[Rib], share: f32) -> f32 {
    let middle = ribs
        .iter()
        .fold([0.0; 2], |sum, rib| vec2::along(sum, rib.at, share));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for rib in ribs {
        let [x, y] = vec2::sub(rib.at, middle);
        (xx, xy, yy) = (xx + share * x * x, xy + share * x * y, yy + share * y * y);
    }
    let half = 0.5 * (xx - yy);
    let root = (half * half + xy * xy).sqrt();
    (0.5 * (xx + yy) - root).max(0.0).sqrt()
}

/// Pixels in a grid, and whether a piece has taken them.
#[derive(Debug, Default)]
struct Grid {
    channels: [Vec<f32>; 3],
    is_taken: Vec<u32>,
}

impl Grid {
    fn reserve(&mut self, pixels: usize) {
        self.channels
            .iter_mut()
            .for_each(|levels| levels.reserve(pixels));
        self.is_taken.reserve(pixels);
    }

    fn take(&mut self, picture: &Picture, ground: &Ground) {
        self.channels.iter_mut().for_each(Vec::clear);
        self.is_taken.clear();
        for y in (STRIDE / 2..picture.height).step_by(STRIDE) {
            for x in (STRIDE / 2..picture.width).step_by(STRIDE) {
                for (levels, level) in self.channels.iter_mut().zip(picture.at(x, y)) {
                    levels.push(level);
                }
                let is_taken = ground.is_taken(y * picture.width + x);
                self.is_taken.push(u32::from(is_taken));
            }
        }
    }

    /// Logarithm of how much more often a color is inside ribbons than outside them.
    fn rarity(&self, color: Color, radius: f32) -> f32 {
        let grid = self;
        let [all, inside] = Arch::new().dispatch(Alike {
            grid,
            color,
            radius,
        });
        libm::logf((4.0 + inside as f32) / (1.0 + (all - inside) as f32))
    }
}

/// Counts the pixels that are like a color, and those of them that are taken.
struct Alike<'a> {
    grid: &'a Grid,
    color: Color,
    radius: f32,
}

impl NullaryFnOnce for Alike<'_> {
    type Output = [u32; 2];

    #[inline(always)]
    fn call(self) -> [u32; 2] {
        let [y, u, v] = &self.grid.channels;
        let pixels = y.iter().zip(u).zip(v).zip(&self.grid.is_taken);
        let (mut all, mut inside) = (0, 0);
        for (((&y, &u), &v), &is_taken) in pixels {
            let is_alike = u32::from(unlikeness([y, u, v], self.color) < self.radius);
            all += is_alike;
            inside += is_alike & is_taken;
        }
        [all, inside]
    }
}
