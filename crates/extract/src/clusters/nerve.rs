//! Which centers lie side by side in the mask: the nerve of their cells, drawn.
//!
//! A center's cell are the pixels nearest to it. Two centers are joined where their cells touch, three span a triangle where
//! theirs meet in one place: the induced Delaunay triangulation of Martinetz and Schulten ("Topology representing networks",
//! Neural Networks 7, 1994) with its triangles. Its edges do not cross, and where cells and the borders between them are in
//! one piece each, it is connected as the mask is, holes included (the nerve theorem; Edelsbrunner and Shah,
//! "Triangulating topological spaces", 1994). So it needs no case of its own for centers that lie in single file, in zigzag
//! or two abreast: thinned, all of them become one line through their middle.
//!
//! It is not connected as the mask is where a hole lies between two cells, or within one: a hole smaller than the
//! distance between centers is not seen.

use super::cells::Cell;
use crate::bits::BitPlane;

/// The most centers of one piece.
pub(crate) const MOST_CENTERS: usize = 256;
/// No cell.
const NONE: u16 = u16::MAX;

/// Centers side by side, as a picture: lines between two, areas between three.
#[derive(Debug, Default)]
pub(crate) struct Nerve {
    pub(crate) plane: BitPlane,
    /// For each center those that it is joined with.
    joined: Vec<[u64; MOST_CENTERS / 64]>,
}

impl Nerve {
    /// Begins a picture of this size.
    pub(crate) fn begin(&mut self, width: usize, height: usize) {
        self.plane.resize(width, height);
        self.joined.reserve(MOST_CENTERS);
    }

    /// Draws what lies between these centers, at most [`MOST_CENTERS`], of which the cells are given row by row.
    pub(crate) fn add(&mut self, cells: &[Cell], centers: &[[f32; 2]]) {
        self.joined.clear();
        self.joined.resize(centers.len(), Default::default());
        let mut above: &[Cell] = &[];
        for row in cells.chunk_by(|a, b| a.y == b.y) {
            let touches = above.first().is_some_and(|cell| cell.y + 1 == row[0].y);
            let upper = if touches { above } else { &[] };
            each_meeting(upper, row, |corners| self.meet(corners, centers));
            above = row;
        }
    }

    /// Draws what lies between the centers of two pixels above (left, right) and two below.
    fn meet(&mut self, [ul, ur, ll, lr]: [u16; 4], centers: &[[f32; 2]]) {
        for (a, b) in [(ul, ur), (ll, lr), (ul, ll), (ur, lr), (ul, lr), (ur, ll)] {
            self.join(a, b, centers);
        }
        // All four cells in one corner span two triangles.
        for corners in [[ul, ur, ll], [ur, ll, lr], [ul, ur, lr], [ul, ll, lr]] {
            let [a, b, c] = corners;
            if a != b && b != c && a != c && !corners.contains(&NONE) {
                let at = corners.map(|center| self.pixel(centers[usize::from(center)]));
                self.fill(at);
            }
        }
    }

    /// Draws the line between two centers, once.
    fn join(&mut self, a: u16, b: u16, centers: &[[f32; 2]]) {
        if a == b || a == NONE || b == NONE {
            return;
        }
        let (a, b) = (usize::from(a.min(b)), usize::from(a.max(b)));
        let bit = 1u64 << (b % 64);
        if self.joined[a][b / 64] & bit == 0 {
            self.joined[a][b / 64] |= bit;
            let [from, to] = [a, b].map(|center| self.pixel(centers[center]));
            self.draw(from, to);
        }
    }

    /// The pixel in which a center lies.
    fn pixel(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let (right, bottom) = (self.plane.width() - 1, self.plane.height() - 1);
        [
            x.round().clamp(0.0, right as f32),
            y.round().clamp(0.0, bottom as f32),
        ]
    }

    fn draw(&mut self, from: [f32; 2], to: [f32; 2]) {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let steps = dx.abs().max(dy.abs()) as usize;
        let share = 1.0 / steps.max(1) as f32;
        for k in 0..=steps {
            let t = k as f32 * share;
            let (x, y) = (from[0] + t * dx, from[1] + t * dy);
            let (x, y) = (x.round() as usize, y.round() as usize);
            self.plane.row_mut(y)[x / 64] |= 1 << (x % 64);
        }
    }

    /// Fills a triangle, row by row.
    fn fill(&mut self, corners: [[f32; 2]; 3]) {
        let [a, b, c] = corners;
        let top = a[1].min(b[1]).min(c[1]) as usize;
        let bottom = a[1].max(b[1]).max(c[1]) as usize;
        for y in top..=bottom {
            let (mut from, mut to) = (f32::INFINITY, f32::NEG_INFINITY);
            for (a, b) in [(a, b), (b, c), (c, a)] {
                let (upper, lower) = if a[1] <= b[1] { (a, b) } else { (b, a) };
                let below = y as f32 - upper[1];
                let height = lower[1] - upper[1];
                if below < 0.0 || below > height || height == 0.0 {
                    continue;
                }
                let x = upper[0] + below / height * (lower[0] - upper[0]);
                (from, to) = (from.min(x), to.max(x));
            }
            if from <= to {
                self.plane.fill(y, from.ceil() as usize, to as usize + 1, true);
            }
        }
    }
}

/// Calls `meeting` wherever four pixels, two of the upper row and two of the lower, change from those to their left.
fn each_meeting(upper: &[Cell], lower: &[Cell], mut meeting: impl FnMut([u16; 4])) {
    let (mut upper, mut lower) = (upper.iter().peekable(), lower.iter().peekable());
    let (mut x, mut left) = (0, [NONE; 2]);
    while x < u16::MAX {
        let (above, above_to) = at(&mut upper, x);
        let (below, below_to) = at(&mut lower, x);
        meeting([left[0], above, left[1], below]);
        left = [above, below];
        x = above_to.min(below_to);
    }
}

/// Whose pixel column `x` of a row is, and up to where nothing changes.
fn at<'a>(
    row: &mut std::iter::Peekable<impl Iterator<Item = &'a Cell>>,
    x: u16,
) -> (u16, u16) {
    while row.next_if(|cell| cell.to <= x).is_some() {}
    match row.peek() {
        Some(cell) if cell.from <= x => (cell.center, cell.to),
        Some(cell) => (NONE, cell.from),
        None => (NONE, u16::MAX),
    }
}
