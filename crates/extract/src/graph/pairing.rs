//! Which arms of a crossing are one strand: the pairing of least bending energy.
//!
//! Between two arms lies a hidden piece. The cubic through their ends with slopes α and β against
//! its chord has a bending energy proportional to α² + αβ + β²: an arc costs a quarter of its turn
//! squared, an S three times as much. Arms of different width or color are less likely one rope. All
//! pairings of a zone are tried; an arm may stay alone, as the end of a rope that lies there. Where
//! the last image knows which strand went where, that weighs in.

use super::arm::Arm;
use crate::image::color;
use crate::past::Past;
use crate::vec2::{self, Vec2};

/// What an arm that stays alone costs: as much as an arc by 1.5 rad (89°), which a rope of ordinary
/// stiffness does not make within its own width.
pub(crate) const ALONE: f32 = 0.6;
/// What each further one costs: two ends seldom lie at one place.
pub(crate) const ALONE_TOO: f32 = 1.4;
/// What it costs to change sides in an overlap that is too wide for strands to cross in it.
const OTHER_SIDE: f32 = 0.8;
/// Zones with more arms than this (945 pairings) are resolved pair by pair, the cheapest first.
const MOST_ARMS: usize = 10;
/// Levels of color difference that count as much as a bend by one radian.
const COLOR_LEVELS: f32 = 60.0;
/// What color may say at most: less than two arms alone, since a rope's end may be taped or dyed.
const MOST_COLOR: f32 = 0.9;

/// Memory of the search.
#[derive(Debug, Default)]
pub(crate) struct Pairing {
    /// For each two arms what it costs to read them as one strand; on the diagonal, what an arm
    /// that stays alone costs besides.
    costs: Vec<f32>,
    order: Vec<(f32, usize, usize)>,
    /// For each arm its partner, or itself when it stays alone.
    partner: Vec<usize>,
    best: Vec<usize>,
    /// The cost of the result.
    pub(crate) best_cost: f32,
}

impl Pairing {
    /// Makes room for zones of as many arms as crossings of ropes have.
    pub(crate) fn reserve(&mut self) {
        const ARMS: usize = 16;
        self.costs.reserve(ARMS * ARMS);
        self.order.reserve(ARMS * ARMS);
        self.partner.reserve(ARMS);
        self.best.reserve(ARMS);
    }

    /// For each of `arms`, all of one zone, the index of its partner, or its own when it ends here.
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
            // Nothing else is here: the strand goes on.
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
        // Alone: skipped by starting after it, so it must not be found free again.
        let alone = alone + self.costs[i * n + i];
        self.search(n, i + 1, so_far + alone, ALONE_TOO);
    }

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

/// What it costs to read arms `a` and `b` as one strand.
pub(crate) fn cost(a: &Arm, b: &Arm, past: &Past, yuv: bool) -> f32 {
    let bend = bending(a.at, a.into, b.at, vec2::scale(b.into, -1.0));
    let (wa, wb) = (a.half_px, b.half_px);
    let width = (wa - wb) / (wa + wb);
    let sides = OTHER_SIDE * (-a.side * b.side).max(0.0);
    let against = past.against(&a.past, &b.past, vec2::distance(a.at, b.at));
    // The narrowest ropes measure their width too coarsely for it to say much.
    bend + 2.0 * width * width * (wa + wb).min(10.0) / 10.0
        + color_cost(a, b, yuv)
        + sides
        + against
}

/// What it costs that the arms' strands differ in color.
pub(crate) fn color_cost(a: &Arm, b: &Arm, yuv: bool) -> f32 {
    let color = (color::distance(a.color, b.color, yuv) / COLOR_LEVELS).min(MOST_COLOR);
    color * color
}

/// The bending energy (times length / 4) of the cubic from `from` in direction `out` to `to` in
/// direction `onward`.
pub(crate) fn bending(from: Vec2, out: Vec2, to: Vec2, onward: Vec2) -> f32 {
    let chord = vec2::unit_or(vec2::sub(to, from), out);
    let (alpha, beta) = (vec2::angle(chord, out), vec2::angle(chord, onward));
    bending_of(alpha, beta)
}

/// The same for slopes `alpha` and `beta` against the chord.
pub(crate) fn bending_of(alpha: f32, beta: f32) -> f32 {
    alpha * alpha + alpha * beta + beta * beta
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::past::FormerPlaces;

    /// An arm of a crossing in the middle, coming from `angle_deg`.
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
