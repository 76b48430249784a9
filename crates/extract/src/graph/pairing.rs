//! Pairs the arms of a crossing into strands, by the least bending energy.
//!
//! Between two arms is a hidden stretch. The cubic through their ends with slopes α and β against
//! its chord has a bending energy proportional to α² + αβ + β². An arc costs a quarter of its turn
//! squared, an S three times as much. Differences in width, color and side of an overlap add to the
//! cost of a pair, as do deviations from the prior (`cost`). An arm may also stay alone, as the end
//! of a rope, at a fixed cost.
//!
//! Zones of up to `MOST_ARMS` arms are solved exactly: all pairings are tried. Larger ones are
//! solved greedily. The two arms of a zone without others are always paired.

use super::arm::Arm;
use crate::image::color;
use crate::past::Past;
use crate::vec2::{self, Vec2};

/// Cost of one arm that stays alone. It equals the cost of an arc that turns by 1.55 rad (89°),
/// which a rope of ordinary stiffness does not make within its own width.
pub(crate) const ALONE: f32 = 0.6;
/// Cost of each further arm that stays alone: two ends are rarely at one place.
pub(crate) const ALONE_TOO: f32 = 1.4;
/// Cost of changing sides in an overlap that is too wide for its strands to cross.
const OTHER_SIDE: f32 = 0.8;
/// Maximum number of arms for the exact search (945 pairings). Larger zones are paired greedily,
/// the cheapest pair first.
const MOST_ARMS: usize = 10;
/// Color difference, in levels, that counts as much as a bend by one radian.
const COLOR_LEVELS: f32 = 60.0;
/// Maximum color difference in a cost, in units of `COLOR_LEVELS`. Its square is less than the cost
/// of two arms alone, since a rope's end may be taped or dyed.
const MOST_COLOR: f32 = 0.9;

/// Buffers and result of the search.
#[derive(Debug, Default)]
pub(crate) struct Pairing {
    /// Cost of each pair of arms as one strand. The diagonal holds the prior's addition to the cost
    /// of an arm that stays alone.
    costs: Vec<f32>,
    order: Vec<(f32, usize, usize)>,
    /// Partner of each arm, or the arm itself if it stays alone.
    partner: Vec<usize>,
    best: Vec<usize>,
    /// Cost of the result.
    pub(crate) best_cost: f32,
}

impl Pairing {
    /// Reserves memory for as many arms as crossings of ropes have.
    pub(crate) fn reserve(&mut self) {
        const ARMS: usize = 16;
        self.costs.reserve(ARMS * ARMS);
        self.order.reserve(ARMS * ARMS);
        self.partner.reserve(ARMS);
        self.best.reserve(ARMS);
    }

    /// Returns the index of the partner of each of `arms`, or the arm's own index if the strand
    /// ends here. All arms are of one zone.
    pub(crate) fn resolve(&mut self, arms: &[Arm], past: &Past, yuv: bool) -> &[usize] {
        let n = arms.len();
        self.costs.clear();
        for (i, a) in arms.iter().enumerate() {
            for (j, b) in arms.iter().enumerate() {
                self.costs.push(if i == j {
                    past.against_end(&a.past)
                } else {
                    cost(a, b, past, yuv)
                });
            }
        }
        self.partner.clear();
        self.partner.extend(0..n);
        self.best.clear();
        self.best.extend(0..n);
        if n == 2 {
            // Without other arms, the strand continues.
            self.best.swap(0, 1);
            self.best_cost = self.costs[1];
        } else if n <= MOST_ARMS {
            self.best_cost = f32::INFINITY;
            self.search(n, 0, 0.0, ALONE);
        } else {
            self.greedy(n);
        }
        &self.best
    }

    /// Searches all pairings of the arms from index `from` on, depth first. Stops where the cost
    /// reaches that of the best known pairing. `alone` is the cost of the next arm that stays
    /// alone.
    fn search(&mut self, n: usize, from: usize, so_far: f32, alone: f32) {
        if so_far >= self.best_cost {
            return;
        }
        let Some(i) = (from..n).find(|&i| self.partner[i] == i) else {
            self.best_cost = so_far;
            self.best.copy_from_slice(&self.partner);
            return;
        };
        for j in i + 1..n {
            if self.partner[j] == j {
                (self.partner[i], self.partner[j]) = (j, i);
                self.search(n, i + 1, so_far + self.costs[i * n + j], alone);
                (self.partner[i], self.partner[j]) = (i, j);
            }
        }
        // The search continues after this arm, so it is not found free again.
        let alone = alone + self.costs[i * n + i];
        self.search(n, i + 1, so_far + alone, ALONE_TOO);
    }

    /// Pairs the cheapest arms first, as long as a pair costs less than two arms alone.
    fn greedy(&mut self, n: usize) {
        self.order.clear();
        for i in 0..n {
            for j in i + 1..n {
                self.order.push((self.costs[i * n + j], i, j));
            }
        }
        self.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        self.best_cost = n as f32 * ALONE;
        for &(cost, i, j) in &self.order {
            if cost < 2.0 * ALONE && self.best[i] == i && self.best[j] == j {
                (self.best[i], self.best[j]) = (j, i);
                self.best_cost += cost - 2.0 * ALONE;
            }
        }
    }
}

/// Cost of arms `a` and `b` as one strand.
pub(crate) fn cost(a: &Arm, b: &Arm, past: &Past, yuv: bool) -> f32 {
    let bend = bending(a.at, a.into, b.at, vec2::scale(b.into, -1.0));
    let (wa, wb) = (a.half_px, b.half_px);
    let width = (wa - wb) / (wa + wb);
    let sides = OTHER_SIDE * (-a.side * b.side).max(0.0);
    let against = past.against(&a.past, &b.past, vec2::distance(a.at, b.at));
    // The narrowest ropes are measured too coarsely for their width to count fully.
    bend + 2.0 * width * width * (wa + wb).min(10.0) / 10.0
        + color_cost(a, b, yuv)
        + sides
        + against
}

/// Cost of the color difference between two arms.
pub(crate) fn color_cost(a: &Arm, b: &Arm, yuv: bool) -> f32 {
    let color = (color::distance(a.color, b.color, yuv) / COLOR_LEVELS).min(MOST_COLOR);
    color * color
}

/// Bending energy (times length / 4) of the cubic from `from` in direction `out` to `to` in
/// direction `onward`.
pub(crate) fn bending(from: Vec2, out: Vec2, to: Vec2, onward: Vec2) -> f32 {
    let chord = vec2::unit_or(vec2::sub(to, from), out);
    let (alpha, beta) = (vec2::angle(chord, out), vec2::angle(chord, onward));
    bending_of(alpha, beta)
}

/// Bending energy for slopes `alpha` and `beta` against the chord.
pub(crate) fn bending_of(alpha: f32, beta: f32) -> f32 {
    alpha * alpha + alpha * beta + beta * beta
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::past::FormerPlaces;

    /// An arm of a crossing at (50, 50), coming from `angle_deg`.
    fn spoke(angle_deg: f32, color: f32) -> Arm {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        Arm {
            edge: 0,
            end: 0,
            zone: 0,
            trim: 0,
            at: [50.0 + 10.0 * cos, 50.0 + 10.0 * sin],
            into: [-cos, -sin],
            half_px: 5.0,
            color: [color; 3],
            side: 0.0,
            past: FormerPlaces::default(),
        }
    }

    #[test]
    fn straight_strands_win_a_crossing() {
        let arms = [
            spoke(0.0, 9.0),
            spoke(40.0, 9.0),
            spoke(180.0, 9.0),
            spoke(220.0, 9.0),
        ];
        assert_eq!(
            Pairing::default().resolve(&arms, &Past::default(), false),
            [2, 3, 0, 1]
        );
    }

    #[test]
    fn three_strands_through_one_point_all_go_straight() {
        let arms = [0.0, 60.0, 120.0, 180.0, 240.0, 300.0].map(|a| spoke(a, 9.0));
        assert_eq!(
            Pairing::default().resolve(&arms, &Past::default(), false),
            [3, 4, 5, 0, 1, 2]
        );
    }

    #[test]
    fn color_outweighs_a_bend() {
        let arms = [
            spoke(0.0, 200.0),
            spoke(40.0, 20.0),
            spoke(180.0, 20.0),
            spoke(220.0, 200.0),
        ];
        assert_eq!(
            Pairing::default().resolve(&arms, &Past::default(), false),
            [3, 2, 1, 0]
        );
    }

    #[test]
    fn an_end_on_a_strand_stays_an_end() {
        let arms = [spoke(0.0, 9.0), spoke(90.0, 9.0), spoke(180.0, 9.0)];
        assert_eq!(
            Pairing::default().resolve(&arms, &Past::default(), false),
            [2, 1, 0]
        );
    }
}
