//! A strand's axis around a crossing, with one sample in each SIMD lane.

use lariat_portable::Simd;

use super::MOST_SAMPLES;
use crate::crossings::place::{around, split};
use crate::image::ray::{LANES, Lanes};
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Finely spaced samples of the axis.
#[derive(Debug)]
pub(super) struct Axis {
    pub(super) blocks: Vec<Block>,
    /// Number of samples; the last one fills the rest of the last block.
    pub(super) count: usize,
    /// The sample at the crossing.
    pub(super) center: usize,
    pub(super) half_px: f32,
}

/// Consecutive samples: x and y of each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) at: [Lanes; 2],
    pub(super) normal: [Lanes; 2],
}

impl Block {
    /// The samples' places, moved aside by this distance.
    #[inline(always)]
    pub(super) fn moved(&self, aside_px: f32) -> [Lanes; 2] {
        let mut at = [[0.0; LANES]; 2];
        for (c, at) in at.iter_mut().enumerate() {
            let axis = self.at[c].iter().zip(&self.normal[c]);
            for (at, (axis, normal)) in at.iter_mut().zip(axis) {
                *at = axis + aside_px * normal;
            }
        }
        at
    }
}

/// Places of a spline, one in each lane: the points around each place, and the place's share of the
/// way from the second point to the third.
struct Places {
    points: [[Lanes; 2]; 4],
    share: Lanes,
}

impl Default for Axis {
    fn default() -> Self {
        Self {
            // Room for the maximum, so that no later, flatter crossing allocates.
            blocks: Vec::with_capacity(MOST_SAMPLES.div_ceil(LANES)),
            count: 0,
            center: 0,
            half_px: 0.0,
        }
    }
}

impl Axis {
    /// Samples `curve` every `step_px` around place `at`, as far back and ahead as `reach_px`
    /// gives.
    #[inline(always)]
    pub(super) fn lay(&mut self, curve: &Curve, at: f32, reach_px: [f32; 2], step_px: f32) {
        self.blocks.clear();
        (self.count, self.center) = (0, 0);
        self.half_px = 0.5 * curve.width_px;
        let step = step_px / curve.spacing_px().max(1e-3);
        let most = |px: f32| ((px / step_px) as i32).min(MOST_SAMPLES as i32 / 2 - 1);
        let (back, ahead) = (most(reach_px[0]), most(reach_px[1]));
        let last = curve.intervals() as f32;
        let mut places = Places {
            points: [[[0.0; LANES]; 2]; 4],
            share: [0.0; LANES],
        };
        let (mut piece, mut points) = (i32::MIN, [[0.0; 2]; 4]);
        for k in -back..=ahead {
            let place = at + step * k as f32;
            if !curve.closed && !(0.0..=last).contains(&place) {
                continue;
            }
            if k <= 0 {
                self.center = self.count;
            }
            let (here, share) = split(curve, place);
            if here != piece {
                (piece, points) = (here, around(curve, here));
            }
            let lane = self.count % LANES;
            places.put(lane, &points, share);
            self.count += 1;
            if lane == LANES - 1 {
                self.blocks.push(places.block());
            }
        }
        let rest = self.count % LANES;
        if rest > 0 {
            let share = places.share[rest - 1];
            for lane in rest..LANES {
                places.put(lane, &points, share);
            }
            self.blocks.push(places.block());
        }
    }

    /// Squared distances from this axis to the samples of `block`, moved aside by each of
    /// `aside_px`.
    #[inline(always)]
    pub(super) fn squares<S: Simd, const N: usize>(
        &self,
        simd: S,
        block: &Block,
        aside_px: &[f32; N],
    ) -> [Lanes; N] {
        let mut squares = [[0.0; LANES]; N];
        let [xs, ys] = [&block.at[0], &block.at[1]];
        let [xs, ys] = [S::as_simd_f32s(xs).0, S::as_simd_f32s(ys).0];
        let [us, vs] = [&block.normal[0], &block.normal[1]];
        let [us, vs] = [S::as_simd_f32s(us).0, S::as_simd_f32s(vs).0];
        for (r, ((x, y), (u, v))) in (xs.iter().zip(ys)).zip(us.iter().zip(vs)).enumerate() {
            let (mut px, mut py) = ([*x; N], [*y; N]);
            for k in 0..N {
                let aside = simd.splat_f32s(aside_px[k]);
                px[k] = simd.add_f32s(*x, simd.mul_f32s(aside, *u));
                py[k] = simd.add_f32s(*y, simd.mul_f32s(aside, *v));
            }
            let mut least = [simd.splat_f32s(f32::INFINITY); N];
            let mut left = self.count;
            for other in &self.blocks {
                let count = left.min(LANES);
                left -= count;
                for (x, y) in other.at[0][..count].iter().zip(&other.at[1][..count]) {
                    let (x, y) = (simd.splat_f32s(*x), simd.splat_f32s(*y));
                    for k in 0..N {
                        let (dx, dy) = (simd.sub_f32s(px[k], x), simd.sub_f32s(py[k], y));
                        let square = simd.add_f32s(simd.mul_f32s(dx, dx), simd.mul_f32s(dy, dy));
                        least[k] = simd.min_f32s(least[k], square);
                    }
                }
            }
            for (squares, least) in squares.iter_mut().zip(least) {
                S::as_mut_simd_f32s(squares).0[r] = least;
            }
        }
        squares
    }
}

impl Places {
    #[inline(always)]
    fn put(&mut self, lane: usize, points: &[Vec2; 4], share: f32) {
        for (to, point) in self.points.iter_mut().zip(points) {
            (to[0][lane], to[1][lane]) = (point[0], point[1]);
        }
        self.share[lane] = share;
    }

    /// The Catmull-Rom spline at the places, and the normals of its tangents.
    #[inline(always)]
    fn block(&self) -> Block {
        let mut block = Block {
            at: [[0.0; LANES]; 2],
            normal: [[0.0; LANES]; 2],
        };
        let mut way = [[0.0; LANES]; 2];
        for c in 0..2 {
            for l in 0..LANES {
                let [p, q, r, s] = &self.points;
                let (p, q, r, s) = (p[c][l], q[c][l], r[c][l], s[c][l]);
                let t = self.share[l];
                let bend = 2.0 * p - 5.0 * q + 4.0 * r - s;
                let twist = 3.0 * (q - r) + s - p;
                block.at[c][l] = 0.5 * (2.0 * q + t * (r - p + t * (bend + t * twist)));
                way[c][l] = r - p + t * (2.0 * bend + 3.0 * t * twist);
            }
        }
        let mut shortest = f32::INFINITY;
        let [us, vs] = &mut block.normal;
        for ((u, v), (x, y)) in us.iter_mut().zip(vs).zip(way[0].iter().zip(&way[1])) {
            let length = (x * x + y * y).sqrt();
            let share = 1.0 / length;
            (*u, *v) = (-y * share, x * share);
            shortest = if length < shortest { length } else { shortest };
        }
        if shortest <= 1e-6 {
            self.straighten(&way, &mut block);
        }
        block
    }

    /// Takes the direction from the points, where the spline has zero derivative.
    #[cold]
    fn straighten(&self, way: &[Lanes; 2], block: &mut Block) {
        for (l, (x, y)) in way[0].iter().zip(&way[1]).enumerate() {
            let [q, r] = [1, 2].map(|k| [0, 1].map(|c| self.points[k][c][l]));
            let straight = vec2::unit_or(vec2::sub(r, q), [1.0, 0.0]);
            let normal = vec2::normal(vec2::unit_or([*x, *y], straight));
            (block.normal[0][l], block.normal[1][l]) = (normal[0], normal[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crossings::place::tangent;
    use proptest::prelude::*;

    struct Measuring<'a>(&'a Axis, &'a Block, f32);

    impl lariat_portable::WithSimd for Measuring<'_> {
        type Output = Lanes;

        fn with_simd<S: Simd>(self, simd: S) -> Lanes {
            self.0.squares(simd, self.1, &[self.2])[0]
        }
    }

    fn curve(closed: bool) -> Curve {
        let mut curve = Curve::default();
        curve.points.extend((0..40).map(|i| {
            let (sin, cos) = (i as f32 * std::f32::consts::TAU / 40.0).sin_cos();
            [60.0 + 50.0 * cos, 60.0 + 40.0 * sin]
        }));
        (curve.closed, curve.width_px) = (closed, 9.0);
        curve.length_px = 280.0;
        curve
    }

    proptest! {
        #[test]
        fn samples_lie_on_the_curve_a_step_apart(at in 0.0f32..39.0, back in 0.0f32..90.0, ahead in 0.0f32..90.0, closed: bool) {
            let (curve, mut axis) = (curve(closed), Axis::default());
            axis.lay(&curve, at, [back, ahead], 1.0);
            let samples: Vec<_> = (0..axis.count).map(|i| {
                let block = &axis.blocks[i / LANES];
                let of = |both: &[Lanes; 2]| [both[0][i % LANES], both[1][i % LANES]];
                (of(&block.at), of(&block.normal))
            }).collect();
            let direction = tangent(&curve, at);
            let (center, normal) = samples[axis.center];
            prop_assert!(vec2::dot(normal, direction).abs() < 1e-4);
            prop_assert!(vec2::distance(center, curve.at(at)) < 0.5);
            for pair in samples.windows(2) {
                let way = vec2::sub(pair[1].0, pair[0].0);
                prop_assert!((vec2::norm(way) - 1.0).abs() < 0.2);
                prop_assert!(vec2::dot(way, pair[0].1).abs() < 0.1);
            }
            let squares = lariat_portable::Arch::new().dispatch(Measuring(&axis, &axis.blocks[0], 3.0));
            for (l, &(at, normal)) in samples.iter().enumerate().take(LANES) {
                let aside = vec2::along(at, normal, 3.0);
                let nearest = samples.iter().map(|(at, _)| vec2::distance(*at, aside)).fold(f32::MAX, f32::min);
                prop_assert!((squares[l].sqrt() - nearest).abs() < 1e-4);
            }
        }
    }
}
