//! Paths of ropes: points one pixel apart.

use std::f32::consts::PI;

use crate::canvas::{Vec2, direction, dot, happens, minus, normal};
use lariat_portable::SplitMix64;

/// Points one pixel apart, and the unit tangent at each.
pub(crate) struct Path {
    pub(crate) points: Vec<Vec2>,
    pub(crate) tangents: Vec<Vec2>,
}

impl Path {
    /// Returns the path of a rope of this width anywhere in the picture. It may leave the picture
    /// and cross itself.
    pub(crate) fn draw(side: usize, width_px: f32, random: &mut SplitMix64) -> Self {
        let knots = match random.below(20) {
            0..10 => across(side as f32, random),
            10..13 => astray(side as f32, random),
            13..19 => return Self::wound(side as f32, width_px, random),
            _ => nearly_straight(side as f32, random),
        };
        Self::through(&knots)
    }

    /// Returns a path through the picture without tight bends.
    pub(crate) fn gentle(side: usize, random: &mut SplitMix64) -> Self {
        let knots = match happens(random, 0.6) {
            true => across(side as f32, random),
            false => nearly_straight(side as f32, random),
        };
        Self::through(&knots)
    }

    /// Returns a path next to this one, at a signed distance that may change along it.
    pub(crate) fn beside(&self, away_px: impl Fn(usize) -> f32) -> Self {
        let moved = |i: usize| {
            let [x, y] = self.tangents[i];
            let away = away_px(i);
            [self.points[i][0] - away * y, self.points[i][1] + away * x]
        };
        Self::even(&(0..self.points.len()).map(moved).collect::<Vec<_>>())
    }

    /// Returns a smooth path through knots (Catmull and Rom, 1974).
    fn through(knots: &[Vec2]) -> Self {
        let knot = |i: isize| knots[i.clamp(0, knots.len() as isize - 1) as usize];
        let mut dense = Vec::new();
        for i in 0..knots.len() as isize - 1 {
            let [a, b, c, d] = [-1, 0, 1, 2].map(|k| knot(i + k));
            for piece in 0..16 {
                let t = piece as f32 / 16.0;
                dense.push([0, 1].map(|k| {
                    b[k] + 0.5
                        * t
                        * (c[k] - a[k]
                            + t * (2.0 * a[k] - 5.0 * b[k] + 4.0 * c[k] - d[k]
                                + t * (3.0 * (b[k] - c[k]) + d[k] - a[k])))
                }));
            }
        }
        dense.push(knot(knots.len() as isize - 1));
        Self::even(&dense)
    }

    fn even(dense: &[Vec2]) -> Self {
        let mut points = vec![dense[0]];
        let mut rest = 1.0;
        for pair in dense.windows(2) {
            let step = minus(pair[1], pair[0]);
            let length = dot(step, step).sqrt();
            let mut at = rest;
            while at <= length {
                points.push([0, 1].map(|k| pair[0][k] + step[k] * at / length));
                at += 1.0;
            }
            rest = at - length;
        }
        let last = points.len() - 1;
        let tangent = |i: usize| {
            let step = minus(points[(i + 2).min(last)], points[i.saturating_sub(2)]);
            step.map(|c| c / dot(step, step).sqrt().max(1e-6))
        };
        let tangents = (0..points.len()).map(tangent).collect();
        Self { points, tangents }
    }

    /// Returns a path whose curvature varies at random, up to the tightest bend of a rope of this
    /// width: loops, knots, tangles.
    fn wound(side: f32, width_px: f32, random: &mut SplitMix64) -> Self {
        let mut at = [(); 2].map(|()| random.uniform_f32(-0.1 * side, 1.1 * side));
        let mut heading = random.uniform_f32(0.0, 2.0 * PI);
        let tightest = 1.0 / (width_px * random.uniform_f32(1.3, 12.0)).max(9.0);
        let memory_px = random.uniform_f32(20.0, 120.0);
        let mut bend = 0.0;
        let mut points = Vec::new();
        for _ in 0..random.uniform_f32(0.5 * side, 3.5 * side) as usize {
            points.push(at);
            bend += -bend / memory_px + tightest * (2.0 / memory_px).sqrt() * normal(random);
            heading += bend.clamp(-tightest, tightest);
            // Turn back towards the picture when far outside.
            let home = minus([0.5 * side; 2], at);
            if dot(home, home) > 0.6 * side * side {
                let [x, y] = direction(heading);
                heading += 0.02 * (x * home[1] - y * home[0]).signum();
            }
            let step = direction(heading);
            at = [at[0] + step[0], at[1] + step[1]];
        }
        Self::even(&points)
    }
}

/// Returns knots across the picture, from outside one side towards another. Sometimes they end
/// inside.
fn across(side: f32, random: &mut SplitMix64) -> Vec<Vec2> {
    let along = direction(random.uniform_f32(0.0, 2.0 * PI));
    let middle = [(); 2].map(|()| side * (0.5 + 0.22 * normal(random)));
    let reach = side * random.uniform_f32(0.6, 0.95);
    let count = 4 + random.below(5);
    let swing = side * random.uniform_f32(0.02, 0.22);
    let mut off = swing * normal(random);
    let mut knots: Vec<Vec2> = (0..count)
        .map(|i| {
            off += swing * normal(random) - 0.25 * off;
            let place = reach * (2.0 * i as f32 / (count - 1) as f32 - 1.0);
            [
                middle[0] + place * along[0] - off * along[1],
                middle[1] + place * along[1] + off * along[0],
            ]
        })
        .collect();
    if happens(random, 0.4) {
        knots.truncate((count - count / 3).max(3));
    }
    knots
}

/// Returns knots of a random walk whose direction turns at random.
fn astray(side: f32, random: &mut SplitMix64) -> Vec<Vec2> {
    let mut at = [(); 2].map(|()| random.uniform_f32(0.0, side));
    let mut heading = random.uniform_f32(0.0, 2.0 * PI);
    let step = side * random.uniform_f32(0.08, 0.25);
    let turn = random.uniform_f32(0.2, 0.9);
    (0..5 + random.below(6))
        .map(|_| {
            heading += turn * normal(random);
            let along = direction(heading);
            at = [at[0] + step * along[0], at[1] + step * along[1]];
            at
        })
        .collect()
}

/// Returns knots of a slight arc.
fn nearly_straight(side: f32, random: &mut SplitMix64) -> Vec<Vec2> {
    let along = direction(random.uniform_f32(0.0, 2.0 * PI));
    let middle = [(); 2].map(|()| random.uniform_f32(0.0, side));
    let sag = random.uniform_f32(-0.06, 0.06) * side;
    let reach = side * random.uniform_f32(0.3, 1.2);
    (-3..=3)
        .map(|i| {
            let t = i as f32 / 3.0;
            let (place, off) = (reach * t, sag * t * t);
            [
                middle[0] + place * along[0] - off * along[1],
                middle[1] + place * along[1] + off * along[0],
            ]
        })
        .collect()
}
