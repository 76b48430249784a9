//! Fuzzy c-means (J. Bezdek, Pattern Recognition with Fuzzy Objective Function Algorithms, 1981) with the exponent m = 2:
//! each pixel belongs to all centers, to the near ones more.
//!
//! ```text
//! uᵢₖ = (1/d²ᵢₖ) / Σⱼ 1/d²ᵢⱼ           how much pixel i belongs to center k
//! cₖ  = Σᵢ u²ᵢₖ xᵢ / Σᵢ u²ᵢₖ
//! J   = Σᵢₖ u²ᵢₖ d²ᵢₖ = Σᵢ 1/Σₖ 1/d²ᵢₖ   where the u are the first line's
//! ```
//!
//! This is scikit-fuzzy's `cmeans(m = 2)` whose first memberships are those to the given centers. They fall off so slowly
//! that all centers matter to all pixels: nothing can be left out. A few registers of pixels are taken at a time, and the
//! weights 1/d² to all centers kept near by between the two passes that each of them needs.

mod membership;

use lariat_portable::Arch;

use super::extent::Extent;
use super::seeding::Seeding;
use super::{Outcome, Pixels, Start};
use membership::{Distortion, Memory, Moved, Round};

/// Rounds at most: by then J mostly falls by less than a ten-thousandth a round. And the change of all memberships
/// together, the root of the sum of their squares, below which it ends: that of scikit-fuzzy's own examples (the
/// function has no default).
pub(super) const MOST_ROUNDS: u32 = 300;
const TOLERANCE: f64 = 0.005;
/// Rounds at most from the last frame's centers. They follow a rope that moved by 4 px to where J is within a thousandth
/// of what 300 rounds reach; what takes hundreds is that centers even out along it, and that goes on from frame to frame.
const CONTINUED_ROUNDS: u32 = 5;

/// Fuzzy c-means. Keeps its memory from run to run.
#[derive(Debug, Default)]
pub struct FuzzyMeans {
    seeding: Seeding,
    memory: Memory,
    before: Vec<[f32; 2]>,
}

impl FuzzyMeans {
    /// Moves the `centers` to where the `pixels` belong to them, until all memberships together change by less than 0.005
    /// (the root of the sum of squares): 300 rounds at most from [`Start::Seeded`], 5 from [`Start::Given`]. Centers
    /// stay within the box around the pixels. Without pixels nothing changes.
    ///
    /// The objective is J in px², with the memberships to the centers as they are at the end.
    pub fn run(&mut self, pixels: &Pixels, start: Start, centers: &mut [[f32; 2]]) -> Outcome {
        self.seeding.begin(pixels, start, centers);
        let most_rounds = match start {
            Start::Seeded(_) => MOST_ROUNDS,
            Start::Given => CONTINUED_ROUNDS,
        };
        self.move_centers(pixels, most_rounds, centers)
    }

    pub(super) fn move_centers(
        &mut self,
        pixels: &Pixels,
        most_rounds: u32,
        centers: &mut [[f32; 2]],
    ) -> Outcome {
        let mut outcome = Outcome {
            rounds: 0,
            objective: 0.0,
        };
        let Some(extent) = Extent::of(pixels).filter(|_| !centers.is_empty()) else {
            return outcome;
        };
        let arch = Arch::new();
        extent.confine(centers);
        self.memory.take(pixels, extent.middle(), centers.len());
        while outcome.rounds < most_rounds {
            self.before.clear();
            self.before.extend_from_slice(centers);
            arch.dispatch(Round {
                memory: &mut self.memory,
                centers,
            });
            // Rounding may have led a center just outside.
            extent.confine(centers);
            outcome.rounds += 1;
            let moved = arch.dispatch(Moved {
                memory: &mut self.memory,
                centers: [&self.before, centers],
                tolerance: TOLERANCE,
            });
            if !moved {
                break;
            }
        }
        outcome.objective = arch.dispatch(Distortion {
            memory: &mut self.memory,
            centers,
        });
        outcome
    }
}
