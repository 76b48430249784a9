//! Fuzzy c-means (J. Bezdek, Pattern Recognition with Fuzzy Objective Function Algorithms, 1981)
//! with the exponent m = 2. Each pixel belongs to all centers, and more to the near ones.
//!
//! ```text
//! uᵢₖ = (1/d²ᵢₖ) / Σⱼ 1/d²ᵢⱼ           how much pixel i belongs to center k
//! cₖ  = Σᵢ u²ᵢₖ xᵢ / Σᵢ u²ᵢₖ
//! J   = Σᵢₖ u²ᵢₖ d²ᵢₖ = Σᵢ 1/Σₖ 1/d²ᵢₖ   where the u are the first line's
//! ```
//!
//! This is scikit-fuzzy's `cmeans(m = 2)`, with initial memberships computed from the given
//! centers. Memberships decay so slowly that all centers matter to all pixels, and nothing can be
//! left out. Each step takes a few registers of pixels and makes two passes over all centers.
//! Between the passes, the weights 1/d² stay in the cache.

mod membership;

use lariat_portable::Arch;

use super::extent::Extent;
use super::seeding::Seeding;
use super::{Outcome, Pixels, Start};
use membership::{Distortion, Memory, Moved, Round};

/// Maximum number of rounds. By then, J usually falls by less than a ten-thousandth per round. The
/// tolerance is the change of all memberships (the root of the sum of squares) below which the
/// rounds end. It is that of scikit-fuzzy's examples, as the function has no default.
pub(super) const MOST_ROUNDS: u32 = 300;
const TOLERANCE: f64 = 0.005;
/// Maximum number of rounds from the last frame's centers. After a rope has moved by 4 px, 5 rounds
/// bring J within a thousandth of what 300 rounds reach. The remaining rounds spread the centers
/// evenly along the rope, which continues from frame to frame.
const CONTINUED_ROUNDS: u32 = 5;

/// Fuzzy c-means clustering. It keeps its memory from run to run.
#[derive(Debug, Default)]
pub struct FuzzyMeans {
    seeding: Seeding,
    memory: Memory,
    before: Vec<[f32; 2]>,
}

impl FuzzyMeans {
    /// Moves `centers` according to the memberships of `pixels`.
    ///
    /// The rounds end when all memberships together (the root of the sum of squares) change by less
    /// than 0.005. There are at most 300 rounds from [`Start::Seeded`], and 5 from
    /// [`Start::Given`]. Centers stay within the bounding box of the pixels. Without pixels nothing
    /// changes.
    ///
    /// The objective is J in px², with the memberships to the final centers.
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
            // Rounding may have moved a center just outside the box.
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
