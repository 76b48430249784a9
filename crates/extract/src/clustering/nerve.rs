//! Finds which centers are adjacent in the mask, and draws the nerve of their cells.
//!
//! A center's cell is the set of pixels nearest to it. Two centers are joined where their cells
//! touch, and three where their cells meet in one place. This is the induced Delaunay triangulation
//! of Martinetz and Schulten ("Topology representing networks", Neural Networks 7, 1994).
//!
//! It is drawn as its barycentric subdivision. A line runs from one center to the other through the
//! middle of the border between their cells, which on a rope is the rope's own middle. Around a
//! place where three cells meet, the area between such lines is filled. Each stroke stays within
//! one cell, so strokes do not cross.
//!
//! If every cell is in one piece without holes, the drawing is connected as the mask is, holes
//! included (the nerve theorem; Edelsbrunner and Shah, "Triangulating topological spaces", 1994).
//! Centers in single file, in a zigzag or two abreast therefore need no special case. After
//! thinning, all of them become one line through their middle.
//!
//! A cell of a plain stretch reaches the mask's edge in at most two places, its sides. Paths branch
//! in a cell that reaches it in three places, or between three cells that meet and reach it in two
//! places each. The centers do not tell where paths branch, so all pixels of these cells are drawn.
//! Only a hole within a cell of a plain stretch is missed.

#[cfg(test)]
mod tests;

use crate::bitmap::bits::BitPlane;
use lariat_clustering::Cell;

/// Stands for a missing cell.
const NONE: u16 = u16::MAX;
/// The end of a list of borders.
const LAST: u32 = u32::MAX;
/// Maximum distance between parts of one border, in pixels: the edge of a mask is ragged.
const NEAR_PX: f32 = 3.0;
/// Weight of the common corner of two pixels in the place of a border, relative to a common side.
const CORNER: f32 = 0.01;

/// A stretch along which two cells touch.
#[derive(Clone, Copy, Debug)]
struct Border {
    /// The second cell. The border is in the list of the first.
    other: u16,
    /// The next border in that list.
    next: u32,
    /// Bounds of the border, and the sum of its places with their number.
    least: [f32; 2],
    most: [f32; 2],
    sum: [f32; 3],
}

impl Border {
    fn middle(&self) -> [f32; 2] {
        let [x, y, count] = self.sum;
        [x / count, y / count]
    }

    fn is_beside(&self, other: &Self) -> bool {
        (0..2).all(|c| {
            other.least[c] <= self.most[c] + NEAR_PX && self.least[c] <= other.most[c] + NEAR_PX
        })
    }

    fn take(&mut self, part: &Self) {
        for c in 0..2 {
            self.least[c] = self.least[c].min(part.least[c]);
            self.most[c] = self.most[c].max(part.most[c]);
        }
        for (sum, more) in self.sum.iter_mut().zip(part.sum) {
            *sum += more;
        }
    }

    fn is_near(&self, [x, y]: [f32; 2], reach_px: f32) -> bool {
        x >= self.least[0] - reach_px
            && x <= self.most[0] + reach_px
            && y >= self.least[1] - reach_px
            && y <= self.most[1] + reach_px
    }
}

/// A place where three cells meet.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    cells: [u16; 3],
    at: [f32; 2],
}

/// Adjacent centers as a picture: lines between two, areas between three.
#[derive(Debug, Default)]
pub(crate) struct Nerve {
    pub(crate) plane: BitPlane,
    borders: Vec<Border>,
    /// For each cell, the first of its borders with later cells.
    first: Vec<u32>,
    meetings: Vec<Meeting>,
    /// Number of places where each cell reaches the mask's edge: between two borders, unless these
    /// meet in a third cell.
    edges: Vec<i32>,
    /// Cells that are drawn whole.
    partings: Vec<bool>,
}

impl Nerve {
    /// Reserves memory for this many centers.
    pub(crate) fn reserve(&mut self, centers: usize) {
        // A planar graph has fewer than 3 edges and 2 faces per vertex. A ragged mask shows some of
        // them more than once.
        self.borders.reserve(6 * centers);
        self.meetings.reserve(8 * centers);
        self.first.reserve(centers);
        self.edges.reserve(centers);
        self.partings.reserve(centers);
    }

    /// Begins a picture of this size.
    pub(crate) fn begin(&mut self, width: usize, height: usize) {
        self.plane.resize(width, height);
    }

    /// Draws the connections between these centers. Their cells are given row by row.
    pub(crate) fn add(&mut self, cells: &[Cell], centers: &[[f32; 2]]) {
        self.borders.clear();
        self.meetings.clear();
        self.first.clear();
        self.first.resize(centers.len(), LAST);
        let mut above: &[Cell] = &[];
        for row in cells.chunk_by(|a, b| a.y == b.y) {
            let touches = above.first().is_some_and(|cell| cell.y + 1 == row[0].y);
            self.sweep(if touches { above } else { &[] }, row);
            above = row;
        }
        self.unite();
        self.draw(centers);
        self.find_partings(centers.len());
        for cell in cells {
            if self.partings[usize::from(cell.center)] {
                let [y, from, to] = [cell.y, cell.from, cell.to].map(usize::from);
                self.plane.fill(y, from, to, true);
            }
        }
    }

    /// Finds the cells in which paths branch, alone or where three of them meet.
    fn find_partings(&mut self, cells: usize) {
        self.count_edges(cells);
        self.partings.clear();
        self.partings
            .extend(self.edges.iter().map(|&edges| edges >= 3));
        for same in self.meetings.chunk_by(|a, b| a.cells == b.cells) {
            let cells = same[0].cells.map(usize::from);
            if cells.iter().all(|&cell| self.edges[cell] >= 2) {
                cells
                    .into_iter()
                    .for_each(|cell| self.partings[cell] = true);
            }
        }
    }

    /// Counts the places where each cell reaches the mask's edge, and sorts the meetings.
    fn count_edges(&mut self, cells: usize) {
        self.edges.clear();
        self.edges.resize(cells, 0);
        for a in 0..cells {
            let mut i = self.first[a];
            while i != LAST {
                let border = &self.borders[i as usize];
                self.edges[a] += 1;
                self.edges[usize::from(border.other)] += 1;
                i = border.next;
            }
        }
        // A ragged border shows the same meeting several times.
        self.meetings
            .iter_mut()
            .for_each(|m| m.cells.sort_unstable());
        self.meetings.sort_unstable_by_key(|m| m.cells);
        for same in self.meetings.chunk_by(|a, b| a.cells == b.cells) {
            for cell in same[0].cells {
                self.edges[usize::from(cell)] -= 1;
            }
        }
    }

    /// Finds the borders in a row and between it and the row above, from left to right.
    fn sweep(&mut self, upper: &[Cell], lower: &[Cell]) {
        let y = f32::from(lower[0].y);
        let (mut upper, mut lower) = (upper.iter().peekable(), lower.iter().peekable());
        let (mut x, mut left) = (0, [NONE; 2]);
        while x < u16::MAX {
            let (above, above_to) = at(&mut upper, x);
            let (below, below_to) = at(&mut lower, x);
            let to = above_to.min(below_to);
            let edge = f32::from(x) - 0.5;
            // The longest part first: it connects the others to the border in the row above.
            if above != below && above != NONE && below != NONE {
                let half = 0.5 * f32::from(to - x);
                self.touch(above, below, [edge + half, y - 0.5], half, 2.0 * half);
            }
            self.touch(left[1], below, [edge, y], 0.0, 1.0);
            self.meet([left[0], above, left[1], below], [edge, y - 0.5]);
            left = [above, below];
            x = to;
        }
    }

    /// Examines the corner of four pixels, two above and two below.
    fn meet(&mut self, [ul, ur, ll, lr]: [u16; 4], at: [f32; 2]) {
        self.touch(ul, lr, at, 0.0, CORNER);
        self.touch(ur, ll, at, 0.0, CORNER);
        for cells in [[ul, ur, ll], [ur, ll, lr], [ul, ur, lr], [ul, ll, lr]] {
            let [a, b, c] = cells;
            if a != b && b != c && a != c && !cells.contains(&NONE) {
                self.meetings.push(Meeting { cells, at });
            }
        }
    }

    /// Adds a place, extended by `half_px` to its left and right, to the border between two cells.
    fn touch(&mut self, a: u16, b: u16, [x, y]: [f32; 2], half_px: f32, count: f32) {
        if a == b || a == NONE || b == NONE {
            return;
        }
        let (a, other) = (a.min(b), a.max(b));
        let found = self.border(a, other, [x, y], NEAR_PX + half_px);
        let i = found.unwrap_or_else(|| {
            let first = &mut self.first[usize::from(a)];
            self.borders.push(Border {
                other,
                next: *first,
                least: [x, y],
                most: [x, y],
                sum: [0.0; 3],
            });
            *first = self.borders.len() as u32 - 1;
            self.borders.len() - 1
        });
        let border = &mut self.borders[i];
        border.least = [border.least[0].min(x - half_px), border.least[1].min(y)];
        border.most = [border.most[0].max(x + half_px), border.most[1].max(y)];
        let [sum_x, sum_y, sum] = border.sum;
        border.sum = [sum_x + count * x, sum_y + count * y, sum + count];
    }

    /// The border between cell `a` and the later cell `other` that comes near to a place.
    fn border(&self, a: u16, other: u16, at: [f32; 2], reach_px: f32) -> Option<usize> {
        let mut i = self.first[usize::from(a)];
        while i != LAST {
            let border = &self.borders[i as usize];
            if border.other == other && border.is_near(at, reach_px) {
                return Some(i as usize);
            }
            i = border.next;
        }
        None
    }

    /// Merges parts of a border that have come near each other since they were started.
    fn unite(&mut self) {
        for a in 0..self.first.len() {
            let mut i = self.first[a];
            while i != LAST {
                let mut before = i;
                let mut j = self.borders[i as usize].next;
                while j != LAST {
                    let (border, part) = (self.borders[i as usize], self.borders[j as usize]);
                    if part.other == border.other && border.is_beside(&part) {
                        self.borders[i as usize].take(&part);
                        self.borders[before as usize].next = part.next;
                    } else {
                        before = j;
                    }
                    j = part.next;
                }
                i = self.borders[i as usize].next;
            }
        }
    }

    fn draw(&mut self, centers: &[[f32; 2]]) {
        for (a, &center) in centers.iter().enumerate() {
            let mut i = self.first[a];
            while i != LAST {
                let border = self.borders[i as usize];
                let other = centers[usize::from(border.other)];
                self.line(center, border.middle());
                self.line(border.middle(), other);
                i = border.next;
            }
        }
        for k in 0..self.meetings.len() {
            let Meeting { cells, at } = self.meetings[k];
            let [a, b, c] = cells;
            for (a, b) in [(a, b), (b, c), (c, a)] {
                if let Some(i) = self.border(a.min(b), a.max(b), at, NEAR_PX) {
                    let middle = self.borders[i].middle();
                    self.fill([at, centers[usize::from(a)], middle]);
                    self.fill([at, middle, centers[usize::from(b)]]);
                }
            }
        }
    }

    /// The pixel that contains a position.
    fn pixel(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let (right, bottom) = (self.plane.width() - 1, self.plane.height() - 1);
        [
            x.round().clamp(0.0, right as f32),
            y.round().clamp(0.0, bottom as f32),
        ]
    }

    fn line(&mut self, from: [f32; 2], to: [f32; 2]) {
        let (from, to) = (self.pixel(from), self.pixel(to));
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
        let [a, b, c] = corners.map(|corner| self.pixel(corner));
        let top = a[1].min(b[1]).min(c[1]) as usize;
        let bottom = a[1].max(b[1]).max(c[1]) as usize;
        for y in top..=bottom {
            let (mut from, mut to) = (f32::INFINITY, f32::NEG_INFINITY);
            for (a, b) in [(a, b), (b, c), (c, a)] {
                let (upper, lower) = if a[1] <= b[1] { (a, b) } else { (b, a) };
                let (below, height) = (y as f32 - upper[1], lower[1] - upper[1]);
                if below < 0.0 || below > height {
                    continue;
                }
                let share = below / height.max(1.0);
                let x = upper[0] + share * (lower[0] - upper[0]);
                (from, to) = (from.min(x), to.max(x));
            }
            let (from, to) = (from.ceil() as usize, to as usize + 1);
            self.plane.fill(y, from.min(to), to, true);
        }
    }
}

/// The cell of column `x` in a row, and the column up to which it stays the same.
fn at<'a>(row: &mut std::iter::Peekable<impl Iterator<Item = &'a Cell>>, x: u16) -> (u16, u16) {
    while row.next_if(|cell| cell.to <= x).is_some() {}
    match row.peek() {
        Some(cell) if cell.from <= x => (cell.center, cell.to),
        Some(cell) => (NONE, cell.from),
        None => (NONE, u16::MAX),
    }
}
