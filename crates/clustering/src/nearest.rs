//! Which pixels have which center nearest, without a look at any pixel.
//!
//! Along a row the square of the distance from center c is x² − 2·cₓ·x + const: of two centers the left one is nearer up to
//! a column, where the line in the middle between them crosses the row, and the right one behind it. So a center's pixels
//! in a piece of a run are what all other centers leave of it between two columns; their number, sum and squares are closed
//! forms. One assignment costs by the number of pieces, 16 of them at a time, not by that of pixels.
//!
//! ```text
//! for each block of pieces
//!   near ← the centers no farther from its box than the nearest center is from the box's farthest corner
//!   for each pair of them, a left of b: x ← middle + slope · (y − middle); a's end ≤ x, b's begin ≥ x
//! ```
//!
//! A pixel as far from one as from the other goes to the right one; of centers on one place the first has all.

use lariat_portable::Simd;

use super::blocks::{Block, LANES, Lanes};

/// Where no center is, and far from all of them.
const NOWHERE: f32 = 1e9;
/// Centers in one column are taken for this far apart in it, so that the slope is a number: the bisector then turns within
/// a column.
const SAME_COLUMN: f32 = 1e-30;
/// Bounds of squares are compared with this much to spare, more than they are rounded.
const SPARE: f32 = 1.0 + 1e-5;

/// A center that may be the nearest to a pixel of the block at hand.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Near {
    pub(super) x: f32,
    pub(super) y: f32,
    /// Its rank among all.
    pub(super) rank: u32,
}

/// The centers from left to right, and the cells of the block at hand.
#[derive(Debug, Default)]
pub(super) struct Nearest {
    /// The columns and rows of the centers, those on a place of another left out, filled up to whole lanes.
    xs: Vec<Lanes>,
    ys: Vec<Lanes>,
    /// Which center each of them is.
    pub(super) order: Vec<u32>,
    /// The square of the distance of each from the block's box.
    squares: Vec<Lanes>,
    pub(super) near: Vec<Near>,
    /// Where the pixels of each near center begin in each piece, and what lies behind the last; whole numbers. There are
    /// none where it does not begin before that.
    pub(super) begins: Vec<Lanes>,
    pub(super) ends: Vec<Lanes>,
}

impl Nearest {
    /// Takes the centers, all of them places.
    pub(super) fn take(&mut self, centers: &[[f32; 2]]) {
        let at = |i: u32| centers[i as usize];
        if self.order.len() != centers.len() {
            self.order.clear();
            self.order.extend(0..centers.len() as u32);
        }
        self.order.sort_unstable_by(|&i, &j| {
            let (a, b) = (at(i), at(j));
            let columns = a[0].total_cmp(&b[0]);
            columns.then(a[1].total_cmp(&b[1])).then(i.cmp(&j))
        });
        let groups = centers.len().div_ceil(LANES);
        for lanes in [&mut self.xs, &mut self.ys, &mut self.squares] {
            lanes.clear();
            lanes.resize(groups, [NOWHERE; LANES]);
        }
        let (xs, ys) = (self.xs.as_flattened_mut(), self.ys.as_flattened_mut());
        let mut last = [NOWHERE; 2];
        for (rank, &i) in self.order.iter().enumerate() {
            let center = at(i);
            if center != last {
                [xs[rank], ys[rank]] = center;
            }
            last = center;
        }
        self.near.resize(LANES * groups, Near::default());
        self.begins.resize(LANES * groups, [0.0; LANES]);
        self.ends.resize(LANES * groups, [0.0; LANES]);
    }

    /// Makes `begins` and `ends` those of a block, and answers how many centers are near.
    #[inline(always)]
    pub(super) fn cut<S: Simd>(&mut self, simd: S, block: &Block) -> usize {
        let count = self.choose(simd, block);
        let near = &self.near[..count];
        let (begins, ends) = (&mut self.begins[..count], &mut self.ends[..count]);
        let ys = S::as_simd_f32s(&block.y).0;
        let from = S::as_simd_f32s(&block.from).0;
        let to = S::as_simd_f32s(&block.to).0;
        for begin in begins.iter_mut() {
            *begin = block.from;
        }
        for (part, &y) in ys.iter().enumerate() {
            for (i, a) in near.iter().enumerate() {
                let mut end = to[part];
                for (b, begin) in near[i + 1..].iter().zip(&mut begins[i + 1..]) {
                    let begin = &mut S::as_mut_simd_f32s(begin).0[part];
                    let apart = b.x - a.x;
                    let apart = if apart > SAME_COLUMN {
                        apart
                    } else {
                        SAME_COLUMN
                    };
                    let slope = simd.splat_f32s((a.y - b.y) / apart);
                    let (x, middle) = (0.5 * (a.x + b.x), 0.5 * (a.y + b.y));
                    let off = simd.sub_f32s(y, simd.splat_f32s(middle));
                    let x = simd.add_f32s(simd.splat_f32s(x), simd.mul_f32s(slope, off));
                    end = simd.min_f32s(end, x);
                    *begin = simd.max_f32s(*begin, x);
                }
                let begin = &mut S::as_mut_simd_f32s(&mut begins[i]).0[part];
                // Within the piece: no more is rounded than can be.
                *begin = round_up(simd, simd.min_f32s(*begin, to[part]));
                let end = simd.max_f32s(end, from[part]);
                S::as_mut_simd_f32s(&mut ends[i]).0[part] = round_up(simd, end);
            }
        }
        count
    }

    /// Lists the centers near the block, from left to right.
    #[inline(always)]
    fn choose<S: Simd>(&mut self, simd: S, block: &Block) -> usize {
        let zero = simd.splat_f32s(0.0);
        let [left, right] = [
            simd.splat_f32s(block.columns[0]),
            simd.splat_f32s(block.columns[1]),
        ];
        let [top, bottom] = [
            simd.splat_f32s(block.rows[0]),
            simd.splat_f32s(block.rows[1]),
        ];
        let mut bound = simd.splat_f32s(f32::INFINITY);
        let xs = S::as_simd_f32s(self.xs.as_flattened()).0;
        let ys = S::as_simd_f32s(self.ys.as_flattened()).0;
        let squares = S::as_mut_simd_f32s(self.squares.as_flattened_mut()).0;
        for ((&x, &y), square) in xs.iter().zip(ys).zip(squares) {
            let (a, b) = (simd.sub_f32s(x, left), simd.sub_f32s(right, x));
            let (c, d) = (simd.sub_f32s(y, top), simd.sub_f32s(bottom, y));
            let (far_x, far_y) = (simd.max_f32s(a, b), simd.max_f32s(c, d));
            let near_x = simd.min_f32s(simd.min_f32s(a, b), zero);
            let near_y = simd.min_f32s(simd.min_f32s(c, d), zero);
            let far = simd.add_f32s(simd.mul_f32s(far_x, far_x), simd.mul_f32s(far_y, far_y));
            bound = simd.min_f32s(bound, far);
            *square = simd.add_f32s(simd.mul_f32s(near_x, near_x), simd.mul_f32s(near_y, near_y));
        }
        let bound = SPARE * simd.reduce_min_f32s(bound);
        let mut count = 0;
        // From left to right most centers are far off: whole vectors of them are passed by.
        let width = size_of::<S::f32s>() / size_of::<f32>();
        let vectors = S::as_simd_f32s(self.squares.as_flattened()).0.iter();
        let squares = self.squares.as_flattened().chunks_exact(width);
        let xs = self.xs.as_flattened().chunks_exact(width);
        let ys = self.ys.as_flattened().chunks_exact(width);
        for (part, (((&vector, squares), xs), ys)) in
            vectors.zip(squares).zip(xs).zip(ys).enumerate()
        {
            if simd.reduce_min_f32s(vector) > bound {
                continue;
            }
            for i in 0..width {
                self.near[count] = Near {
                    x: xs[i],
                    y: ys[i],
                    rank: (part * width + i) as u32,
                };
                count += usize::from(squares[i] <= bound && xs[i] < NOWHERE);
            }
        }
        count
    }
}

/// The least whole numbers that are no smaller, of numbers from 0 to 2²³.
#[inline(always)]
fn round_up<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    // From here on floats are whole numbers.
    let whole = simd.splat_f32s(8_388_608.0);
    let rounded = simd.sub_f32s(simd.add_f32s(x, whole), whole);
    let next = simd.add_f32s(rounded, simd.splat_f32s(1.0));
    simd.select_f32s(simd.less_than_f32s(rounded, x), next, rounded)
}
