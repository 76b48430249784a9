//! The rope: a chain of point masses that hardly stretches, resists bending and rubs on the table.
//!
//! Extended position-based dynamics (Macklin, Müller and Chentanez, *XPBD*, 2016; one iteration in each of many small
//! steps: Macklin et al., *Small Steps in Physics Simulation*, 2019). Each constraint C with compliance α is worth the
//! energy C² / 2α. A step predicts where the masses go by themselves, x̃, and moves them by
//!
//! ```text
//! Δx = W Jᵀλ,   (J W Jᵀ + α/Δt²) λ = −C(x̃),   v = (x̃ + Δx − x) / Δt
//! ```
//!
//! Along a chain this system is banded, so it is solved exactly and not constraint by constraint (as Deul et al., *Direct
//! Position-Based Solver for Stiff Rods*, 2018): a pull is felt at the other end at once, however stiff the rope is.
//! Bending is that of discrete elastic rods (Bergou et al. 2008): 2 tan(φ/2) for the angle φ between two segments.
//!
//! Coulomb friction is a drag whose coefficient is μg over the speed, implicit as all else: it is part of W, the inverse
//! of what resists in a step. Below [`CREEP_PX_S`] the coefficient stays what it is there, so that what holds a rope at
//! rest is a drag so strong that it creeps by less than a pixel in a quarter of an hour.
//!
//! The rope does not feel itself: strands pass through each other.

use crate::band::{Band, HALF_WIDTH};

/// Below this speed friction no longer grows.
const CREEP_PX_S: f64 = 1e-3;
/// How fast a pull runs along the rope: it stretches by a millionth under its own friction.
const SOUND_PX_S: f64 = 1e6;
/// What 1 + cos φ is taken to be at least: segments folded upon each other have no direction to unfold in.
const LEAST_OPENING: f64 = 0.05;

/// What a rope is made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Material {
    /// Length of a segment.
    pub(crate) segment_px: f64,
    /// Bending stiffness by mass of a pixel's length, in px⁴/s².
    pub(crate) bending_px4_s2: f64,
    /// What friction takes from the speed.
    pub(crate) friction_px_s2: f64,
    /// What share of its speed it loses in a second beside friction.
    pub(crate) damping_per_s: f64,
}

/// What is stored in a rope, in px²/s² by the mass of one node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// Of motion, but for the nodes that grippers hold.
    pub kinetic: f64,
    /// Of bending.
    pub bending: f64,
    /// Of stretching.
    pub stretching: f64,
}

impl Energy {
    /// All of it.
    pub fn total(&self) -> f64 {
        self.kinetic + self.bending + self.stretching
    }
}

/// One constraint where it stands: its value, and its gradient at the nodes from `first` on.
#[derive(Debug, Clone, Copy, Default)]
struct Constraint {
    value: f64,
    gradient: [[f64; 2]; 3],
    /// How many nodes it is about.
    nodes: usize,
}

/// A chain of nodes of equal mass.
#[derive(Debug, Clone)]
pub(crate) struct Rod {
    material: Material,
    at: Vec<[f64; 2]>,
    before: Vec<[f64; 2]>,
    velocity: Vec<[f64; 2]>,
    /// W: 0 where a gripper holds the node, 1 where nothing resists.
    mobility: Vec<f64>,
    /// Stretch of segment k at 2k, bend at its end at 2k + 1: the order in which the system is banded.
    constraints: Vec<Constraint>,
    system: Band,
    multipliers: Vec<f64>,
}

impl Rod {
    /// A rope at rest along these nodes, three or more at equal steps.
    pub(crate) fn new(nodes: Vec<[f64; 2]>, material: Material) -> Self {
        let count = nodes.len();
        let constraints = 2 * count - 3;
        Self {
            material,
            before: nodes.clone(),
            at: nodes,
            velocity: vec![[0.0; 2]; count],
            mobility: vec![1.0; count],
            constraints: vec![Constraint::default(); constraints],
            system: Band::new(constraints),
            multipliers: vec![0.0; constraints],
        }
    }

    pub(crate) fn nodes(&self) -> &[[f64; 2]] {
        &self.at
    }

    /// How much longer it is than when it is loose, as a share.
    pub(crate) fn stretch(&self) -> f64 {
        let chords = self.at.windows(2).map(|pair| minus(pair[1], pair[0]));
        let length_px: f64 = chords.map(|chord| dot(chord, chord).sqrt()).sum();
        length_px / (self.material.segment_px * (self.at.len() - 1) as f64) - 1.0
    }

    /// The fastest node's speed.
    pub(crate) fn speed_px_s(&self) -> f64 {
        self.velocity
            .iter()
            .map(|v| dot(*v, *v))
            .fold(0.0, f64::max)
            .sqrt()
    }

    /// One step in time; `held` says where nodes are at its end.
    pub(crate) fn step(&mut self, step_s: f64, held: impl IntoIterator<Item = (usize, [f64; 2])>) {
        self.predict(step_s);
        for (node, at) in held {
            self.at[node] = at;
            self.mobility[node] = 0.0;
        }
        self.constrain(step_s);
        // Wound up beyond what its stiffness can be solved for, it stays where it was.
        if !self.at.as_flattened().iter().all(|c| c.is_finite()) {
            self.at.copy_from_slice(&self.before);
        }
        for ((velocity, at), before) in self.velocity.iter_mut().zip(&self.at).zip(&self.before) {
            *velocity = minus(*at, *before).map(|d| d / step_s);
        }
    }

    /// Where each node goes by itself, slowed by the table.
    fn predict(&mut self, step_s: f64) {
        let Material {
            friction_px_s2,
            damping_per_s,
            ..
        } = self.material;
        self.before.copy_from_slice(&self.at);
        for ((at, velocity), mobility) in self
            .at
            .iter_mut()
            .zip(&self.velocity)
            .zip(&mut self.mobility)
        {
            let speed_px_s = dot(*velocity, *velocity).sqrt().max(CREEP_PX_S);
            let drag_per_s = friction_px_s2 / speed_px_s + damping_per_s;
            *mobility = 1.0 / (1.0 + drag_per_s * step_s);
            push(at, *mobility * step_s, *velocity);
        }
    }

    /// Moves the nodes so that the constraints hold as stiffly as they should.
    fn constrain(&mut self, step_s: f64) {
        self.linearize();
        let per_step2 = 1.0 / (step_s * step_s);
        for row in 0..self.constraints.len() {
            for d in 0..=HALF_WIDTH.min(row) {
                self.system.rows[row][d] = self.coupling(row, row - d);
            }
            self.system.rows[row][0] += self.compliance(row) * per_step2;
            self.multipliers[row] = -self.constraints[row].value;
        }
        self.system.solve(&mut self.multipliers);
        for (row, constraint) in self.constraints.iter().enumerate() {
            let first = row / 2;
            for (i, gradient) in constraint.gradient[..constraint.nodes].iter().enumerate() {
                let by = self.mobility[first + i] * self.multipliers[row];
                push(&mut self.at[first + i], by, *gradient);
            }
        }
    }

    /// Values and gradients of all constraints at the nodes as they are.
    fn linearize(&mut self) {
        let segment_px = self.material.segment_px;
        for (row, constraint) in self.constraints.iter_mut().enumerate() {
            let nodes = &self.at[row / 2..];
            *constraint = if row % 2 == 0 {
                stretch(nodes[0], nodes[1], segment_px)
            } else {
                bend([nodes[0], nodes[1], nodes[2]], segment_px)
            };
        }
    }

    /// The entry of J W Jᵀ for two constraints, `a` not before `b`.
    fn coupling(&self, a: usize, b: usize) -> f64 {
        let (later, earlier) = (&self.constraints[a], &self.constraints[b]);
        let (first, offset) = (a / 2, a / 2 - b / 2);
        (0..later.nodes)
            .filter(|i| i + offset < earlier.nodes)
            .map(|i| {
                let both = dot(later.gradient[i], earlier.gradient[i + offset]);
                self.mobility[first + i] * both
            })
            .sum()
    }

    /// α of a constraint, for nodes of mass 1.
    fn compliance(&self, row: usize) -> f64 {
        let segment_px = self.material.segment_px;
        let stiffness = if row.is_multiple_of(2) {
            SOUND_PX_S * SOUND_PX_S
        } else {
            self.material.bending_px4_s2
        };
        segment_px * segment_px / stiffness
    }

    /// What is stored in the rope now.
    pub(crate) fn energy(&mut self) -> Energy {
        self.linearize();
        let stored = |parity: usize| -> f64 {
            let rows = (parity..self.constraints.len()).step_by(2);
            rows.map(|row| {
                let value = self.constraints[row].value;
                0.5 * value * value / self.compliance(row)
            })
            .sum()
        };
        let moving = self.velocity.iter().zip(&self.mobility);
        Energy {
            kinetic: moving
                .filter(|(_, mobility)| **mobility > 0.0)
                .map(|(v, _)| 0.5 * dot(*v, *v))
                .sum(),
            bending: stored(1),
            stretching: stored(0),
        }
    }
}

/// How much longer a segment is than it should be.
fn stretch(from: [f64; 2], to: [f64; 2], segment_px: f64) -> Constraint {
    let chord = minus(to, from);
    let length_px = dot(chord, chord).sqrt();
    // Two nodes upon each other have no direction; they are parted by their neighbours.
    let along = chord.map(|c| c / length_px.max(1e-9));
    Constraint {
        value: length_px - segment_px,
        gradient: [along.map(|c| -c), along, [0.0; 2]],
        nodes: 2,
    }
}

/// 2 tan(φ/2) for the turn φ at the middle one of three nodes: 2 a×b / (ℓ² + a·b).
fn bend([p, q, r]: [[f64; 2]; 3], segment_px: f64) -> Constraint {
    let (a, b) = (minus(q, p), minus(r, q));
    let square = segment_px * segment_px;
    let opening = (square + dot(a, b)).max(LEAST_OPENING * square);
    let value = 2.0 * (a[0] * b[1] - a[1] * b[0]) / opening;
    let by_a = [2.0 * b[1] - value * b[0], -2.0 * b[0] - value * b[1]].map(|c| c / opening);
    let by_b = [-2.0 * a[1] - value * a[0], 2.0 * a[0] - value * a[1]].map(|c| c / opening);
    Constraint {
        value,
        gradient: [by_a.map(|c| -c), minus(by_a, by_b), by_b],
        nodes: 3,
    }
}

/// at += by · along
fn push(at: &mut [f64; 2], by: f64, along: [f64; 2]) {
    *at = [at[0] + by * along[0], at[1] + by * along[1]];
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_those_of_finite_differences() {
        let nodes = [[1.0, 2.0], [5.5, 4.0], [8.0, 8.5]];
        let of = |nodes: [[f64; 2]; 3]| [bend(nodes, 5.0), stretch(nodes[0], nodes[1], 5.0)];
        let exact = of(nodes);
        for node in 0..3 {
            for axis in 0..2 {
                let moved = |by: f64| {
                    let mut nodes = nodes;
                    nodes[node][axis] += by;
                    of(nodes).map(|constraint| constraint.value)
                };
                let (up, down) = (moved(1e-6), moved(-1e-6));
                for kind in 0..2 {
                    let slope = (up[kind] - down[kind]) / 2e-6;
                    let exact = exact[kind].gradient[node][axis];
                    assert!((slope - exact).abs() < 1e-8, "{slope} {exact}");
                }
            }
        }
    }
}
