//! `[simulation]`: the simulated rope, and disturbances of its picture.

use crate::settings::Capture;
use lariat_capture::{HandOptions, SimulatedOptions};

/// The simulated rope.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Number of grippers that hold the rope: 1 or 2.
    pub grippers: usize,
    /// Length of the rope in px.
    pub length_px: f64,
    /// Bending stiffness divided by mass per length, in m⁴/s², where a pixel is a millimeter.
    pub stiffness: f64,
    /// Coefficient of friction with the table.
    pub friction: f64,
    /// Standard deviation of the camera noise, in steps of 8-bit levels.
    pub noise: f64,
    /// Time at which a hand covers the rope, in seconds from the first frame. Without it, no hand
    /// appears.
    pub hand_at_s: Option<f64>,
    /// Time for which the hand stays, in seconds.
    pub hand_for_s: f64,
}

impl Default for Simulation {
    fn default() -> Self {
        let rope = lariat_capture::SimulatedOptions::default();
        Self {
            grippers: rope.simulation.grippers,
            length_px: rope.simulation.length_px,
            stiffness: rope.simulation.stiffness,
            friction: rope.simulation.friction,
            noise: rope.noise,
            hand_at_s: None,
            hand_for_s: 1.0,
        }
    }
}

impl Simulation {
    /// Returns the options of the source, with seed, size and rate from `[capture]` and a truth of
    /// `points` points. `lifted` is true if a depth camera sees the rope.
    pub(super) fn options(
        &self,
        capture: &Capture,
        points: usize,
        lifted: bool,
    ) -> SimulatedOptions {
        let defaults = SimulatedOptions::default();
        let hand = |at_s| HandOptions {
            at_s,
            for_s: self.hand_for_s,
        };
        let mut options = SimulatedOptions {
            lifted,
            pace: capture.pace(),
            noise: self.noise,
            hand: self.hand_at_s.map(hand),
            truth_points: points as u32,
            ..defaults
        };
        let rope = &mut options.simulation;
        rope.seed = capture.seed;
        rope.grippers = self.grippers;
        rope.length_px = self.length_px;
        rope.stiffness = self.stiffness;
        rope.friction = self.friction;
        rope.picture_px = capture.likely_size().map(f64::from);
        options
    }
}
