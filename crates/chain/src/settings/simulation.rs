//! `[simulation]`: the rope that is simulated, and what disturbs its picture.

use crate::settings::Capture;
use lariat_capture::{HandOptions, SimulatedOptions};

/// The simulated rope.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// How many grippers hold it: 1 or 2.
    pub grippers: usize,
    /// Its length in px.
    pub length_px: f64,
    /// Bending stiffness by mass of length, in m⁴/s² with a pixel as a millimetre.
    pub stiffness: f64,
    /// Coefficient of friction with the table.
    pub friction: f64,
    /// Standard deviation of the camera's noise, in steps of a byte.
    pub noise: f64,
    /// From when on a hand rests on the rope, in seconds from the first frame on; without it, none does.
    pub hand_at_s: Option<f64>,
    /// For how long.
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
    /// The source's own options, with seed, size and rate of `[capture]`, and a truth of `points` points. `lifted`: whether a depth camera
    /// sees it.
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
