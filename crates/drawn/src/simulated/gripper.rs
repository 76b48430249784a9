//! A planar gripper from above: a round wrist, a palm, two jaws, and between them the pad that
//! holds the rope down.
//!
//! Its orange differs from the table, the rope, the rope's dark rim and its shadow, and its wrist
//! is much wider than the rope. The extractor uses both to distinguish it from a rope.

use lariat_simulation::Pose;

use super::plate::Plate;
use crate::rendered::draw::{Area, Canvas};

const WRIST_RGB: [f32; 3] = [204.0, 100.0, 40.0];
const FLANGE_RGB: [f32; 3] = [180.0, 86.0, 36.0];
const PALM_RGB: [f32; 3] = [190.0, 92.0, 40.0];
const JAW_RGB: [f32; 3] = [160.0, 82.0, 42.0];
const PAD_RGB: [f32; 3] = [138.0, 70.0, 38.0];

/// Parts of a gripper, from bottom to top. Only the first three cast a shadow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawing([Plate; 6]);

impl Drawing {
    /// Makes a gripper at this pose, with jaws that reach `jaw_px` along a rope `rope_px` wide.
    pub(super) fn new(pose: &Pose, jaw_px: f64, rope_px: f64) -> Self {
        let (sin, cos) = libm::sincos(pose.angle_rad);
        let along = [cos as f32, sin as f32];
        let (jaw, rope) = (jaw_px as f32, rope_px as f32);
        let at = pose.at.map(|c| c as f32);
        // u: toward the rope; v: across it.
        let plate = |[from, to]: [f32; 2], [left, right]: [f32; 2], corner: f32, rgb| {
            let (u, v) = (0.5 * (from + to), 0.5 * (left + right));
            Plate {
                middle: [
                    at[0] + u * along[0] - v * along[1],
                    at[1] + u * along[1] + v * along[0],
                ],
                along,
                half: [0.5 * (to - from), 0.5 * (right - left)],
                corner,
                rgb,
            }
        };
        let inner = 0.5 * rope + 1.0;
        let outer = inner + 8.0;
        Self([
            plate([-62.0, -14.0], [-24.0, 24.0], 24.0, WRIST_RGB),
            plate([-22.0, -3.0], [-22.0, 22.0], 4.0, PALM_RGB),
            plate([-4.0, jaw], [-inner, inner], 1.0, PAD_RGB),
            plate([-5.0, jaw], [-outer, -inner], 2.0, JAW_RGB),
            plate([-5.0, jaw], [inner, outer], 2.0, JAW_RGB),
            plate([-52.0, -24.0], [-14.0, 14.0], 14.0, FLANGE_RGB),
        ])
    }

    pub(super) fn draw(&self, canvas: &mut Canvas) {
        for plate in &self.0[..3] {
            plate.shade(canvas);
        }
        for plate in &self.0 {
            plate.draw(canvas);
        }
    }

    /// Returns the part of the canvas that [`draw`](Self::draw) can touch.
    pub(super) fn area(&self, width: usize, height: usize) -> Area {
        let areas = self.0.iter().map(|plate| plate.area(width, height));
        let union = |a: Area, b: Area| {
            let both = |a: [usize; 2], b: [usize; 2]| [a[0].min(b[0]), a[1].max(b[1])];
            Area {
                x: both(a.x, b.x),
                y: both(a.y, b.y),
            }
        };
        areas.reduce(union).unwrap_or_default()
    }
}
