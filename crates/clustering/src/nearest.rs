//! Finds the pixels nearest to each center without visiting individual pixels.
//!
//! Along a row, the squared distance from center c is x² − 2·cₓ·x + const. The left of two centers
//! is therefore nearer up to the column where their bisector crosses the row, and the right one
//! after it. A center's pixels in a piece of a run are thus the range between two columns that all
//! other centers leave to it. Their number, sum and squares have closed forms. The cost of an
//! assignment grows with the number of pieces, processed 16 at a time, not with the number of
//! pixels.
//!
//! ```text
//! for each block of pieces
//!   near ← the centers no farther from its box than the nearest center is from the box's farthest corner
//!   for each pair of them, a left of b: x ← middle + slope · (y − middle); a's end ≤ x, b's begin ≥ x
//! ```
//!
//! A pixel equidistant from two centers belongs to the right one. If centers coincide, the first
//! one has all pixels.

use lariat_portable::Simd;

use super::blocks::{Block, LANES, Lanes};

/// A coordinate far from all pixels, for unused lanes.
const NOWHERE: f32 = 1e9;
/// Horizontal distance assumed for centers in the same column, so that the slope is finite. The
/// bisector then turns within a column.
const SAME_COLUMN: f32 = 1e-30;
/// Factor by which bounds of squares are relaxed when compared. It exceeds their rounding error.
const SPARE: f32 = 1.0 + 1e-5;

/// A center that may be the nearest to a pixel of the current block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Near {
    pub(super) x: f32,
    pub(super) y: f32,
    /// The center's rank from left to right.
    pub(super) rank: u32,
}

/// The centers from left to right, and the cells of the current block.
#[derive(Debug, Default)]
pub(super) struct Nearest {
    /// Columns and rows of the centers, padded to whole lanes. A center that coincides with an
    /// earlier one is left out.
    xs: Vec<Lanes>,
    ys: Vec<Lanes>,
    /// Index of the center at each rank.
    pub(super) order: Vec<u32>,
    /// Squared distance of each center from the block's box.
    squares: Vec<Lanes>,
    pub(super) near: Vec<Near>,
    /// First column of each near center's pixels in each piece, and the column after the last. Both
    /// are integers. The range is empty if begin is not less than end.
    pub(super) begins: Vec<Lanes>,
    pub(super) ends: Vec<Lanes>,
}

impl Nearest {
    /// Stores the centers, whose coordinates must be finite.
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

    /// Computes `begins` and `ends` for a block. Returns the number of near centers.
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
                // Clamped to the piece, because `round_up` takes a limited range.
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
        // Most centers are far away, so whole vectors of them are skipped.
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

/// Rounds numbers from 0 to 2²³ up to integers.
#[inline(always)]
fn round_up<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    // Floats of this size and above are integers.
    let whole = simd.splat_f32s(8_388_608.0);
    let rounded = simd.sub_f32s(simd.add_f32s(x, whole), whole);
    let next = simd.add_f32s(rounded, simd.splat_f32s(1.0));
    simd.select_f32s(simd.less_than_f32s(rounded, x), next, rounded)
}
