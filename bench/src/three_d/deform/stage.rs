//! Placement of the cameras in front of motion-captured ropes, and reconstruction of the ropes from
//! their markers.

use super::super::{ASIDE, FOCAL_PX, SIZE, far};
use crate::accuracy::spline;
use lariat_drawn::space::{Eye, LiftedRope};

/// Points of the spline per interval between two markers.
const FINER: usize = 20;
/// Share of the picture, to each side of its center, that the rope stays within.
const INNER: f64 = 0.45;
/// Distance of the wall behind the rope, mm.
const WALL_MM: f64 = 150.0;
/// Number of camera rotations that are tried.
const TURNS: u32 = 36;

/// The cameras and their frame: x to their right, y up, and the wall at z = 0.
pub(super) struct Stage {
    turn: [f64; 2],
    origin: [f64; 3],
    /// The color camera and the depth camera.
    pub(super) eyes: [Eye; 2],
}

impl Stage {
    /// Places the cameras for a sequence, given the markers of each frame.
    pub(super) fn of(frames: &[Vec<[f64; 3]>]) -> Self {
        let markers = || frames.iter().flatten();
        let spans = |turn: [f64; 2]| {
            [0, 1, 2].map(|k| {
                let along = || markers().map(|&p| turned(turn, p)[k]);
                [
                    along().fold(f64::MAX, f64::min),
                    along().fold(f64::MIN, f64::max),
                ]
            })
        };
        let depth = |turn: [f64; 2]| {
            let [near, far] = spans(turn)[2];
            far - near
        };
        let turns = (0..TURNS).map(|k| {
            let (sin, cos) = f64::from(k * 180 / TURNS).to_radians().sin_cos();
            [cos, sin]
        });
        let turn = turns.min_by(|&a, &b| depth(a).total_cmp(&depth(b)));
        let turn = turn.unwrap_or([1.0, 0.0]);
        let [x, y, z] = spans(turn);
        let origin = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), z[0] - WALL_MM];
        let near_enough = markers().map(|&marker| {
            let at = turned(turn, marker);
            let asks = |k: usize| (at[k] - origin[k]).abs() * FOCAL_PX / (INNER * SIZE[k] as f64);
            at[2] - origin[2] + asks(0).max(asks(1))
        });
        let distance_mm = near_enough.fold(0.0, f64::max);
        let color = Eye::above(FOCAL_PX, SIZE, distance_mm, 0.0, 0.0);
        Self {
            turn,
            origin,
            eyes: [color, color.beside(ASIDE, 425.0, SIZE)],
        }
    }

    /// Returns the rope through a frame's markers.
    pub(super) fn rope(&self, markers: &[[f64; 3]], radius_mm: f64) -> LiftedRope {
        let knots: Vec<[f64; 3]> = (markers.iter())
            .map(|&marker| {
                let at = turned(self.turn, marker);
                [0, 1, 2].map(|k| at[k] - self.origin[k])
            })
            .collect();
        let last = knots.len() - 1;
        let mirrored = |at: [f64; 3], p: [f64; 3]| [0, 1, 2].map(|k| 2.0 * at[k] - p[k]);
        let mut line = Vec::with_capacity(FINER * last + 1);
        for i in 0..last {
            let before = match i {
                0 => mirrored(knots[0], knots[1]),
                _ => knots[i - 1],
            };
            let after = match knots.get(i + 2) {
                Some(&after) => after,
                None => mirrored(knots[last], knots[last - 1]),
            };
            let around = [before, knots[i], knots[i + 1], after];
            line.extend((0..FINER).map(|k| spline::between(around, far, k as f64 / FINER as f64)));
        }
        line.push(knots[last]);
        LiftedRope::along(&line, radius_mm)
    }
}

/// Rotates a point about the vertical, to axes that point right, up, and towards the viewer.
fn turned([cos, sin]: [f64; 2], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [cos * x + sin * y, z, sin * x - cos * y]
}
