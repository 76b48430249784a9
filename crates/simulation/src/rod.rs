//! The rope: a chain of point masses that hardly stretches, resists bending and rubs on the table; in the plane of the table, or in
//! space above it.
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
//! Bending is that of discrete elastic rods (Bergou et al. 2008): 2 tan(φ/2) for the angle φ between two segments, about the one axis of
//! the plane or the three of space (where it is their curvature binormal). A rope in space may be twisted as one likes: it resists that not.
//!
//! Coulomb friction is a drag whose coefficient is μp over the speed, p what presses on the table by mass, implicit as all else: it is part of
//! W, the inverse of what resists in a step. Below [`CREEP_PX_S`] the coefficient stays what it is there, so that what holds a rope at
//! rest is a drag so strong that it creeps by less than a pixel in a quarter of an hour.
//!
//! In the plane all of the rope's weight presses. In space gravity takes it down, and the table is a stiff damped spring below it, implicit
//! likewise: a part of W along z.
//!
//! The rope does not feel itself: strands pass through each other.

use crate::band::Band;
use crate::vector::{dot, length, minus, push};

/// Gravity in px/s².
pub(crate) const GRAVITY_PX_S2: f64 = 9810.0;
/// Below this speed friction no longer grows.
const CREEP_PX_S: f64 = 1e-3;
/// How fast a pull runs along the rope: it stretches by a millionth under its own friction.
const SOUND_PX_S: f64 = 1e6;
/// What 1 + cos φ is taken to be at least: segments folded upon each other have no direction to unfold in.
const LEAST_OPENING: f64 = 0.05;
/// How stiff the table is, by mass: under its own weight a rope sinks into it by a fiftieth of a millimetre.
const TABLE_PER_S2: f64 = GRAVITY_PX_S2 / 0.02;
/// What it takes from what moves into it: no bounce is left (the damping that is critical, 2√stiffness).
const TABLE_DAMPING_PER_S: f64 = 1400.0;

/// What a rope is made of, and what it is above.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Material {
    /// Length of a segment.
    pub(crate) segment_px: f64,
    /// Bending stiffness by mass of a pixel's length, in px⁴/s².
    pub(crate) bending_px4_s2: f64,
    /// Coefficient of friction with the table.
    pub(crate) friction: f64,
    /// What share of its speed it loses in a second beside friction.
    pub(crate) damping_per_s: f64,
    /// Its centerline's height where it lies on the table, in space.
    pub(crate) lies_at_px: f64,
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
    /// Of height above the table, and of what is pressed into that; 0 in the plane.
    pub height: f64,
}

impl Energy {
    /// All of it.
    pub fn total(&self) -> f64 {
        self.kinetic + self.bending + self.stretching + self.height
    }
}

/// One constraint where it stands: its value, and its gradient at the nodes from its first on.
#[derive(Debug, Clone, Copy)]
struct Constraint<const D: usize> {
    value: f64,
    gradient: [[f64; D]; 3],
    /// How many nodes it is about.
    nodes: usize,
}

/// How a node gives way in a step.
#[derive(Debug, Clone, Copy)]
struct Mobility {
    /// 0 where a gripper holds the node, 1 where nothing resists.
    along: f64,
    /// What of that is left along z.
    up: f64,
}

/// A chain of nodes of equal mass. `BAND`: the width of the system's band, which for `bends` at a node is 2 (1 + bends) + bends: 5 in the
/// plane, 11 in space.
#[derive(Debug, Clone)]
pub(crate) struct Rod<const D: usize, const BAND: usize> {
    material: Material,
    at: Vec<[f64; D]>,
    before: Vec<[f64; D]>,
    velocity: Vec<[f64; D]>,
    mobility: Vec<Mobility>,
    /// Stretch of segment k, and the bends at its end: the order in which the system is banded.
    constraints: Vec<Constraint<D>>,
    system: Band<BAND>,
    multipliers: Vec<f64>,
}

impl<const D: usize, const BAND: usize> Rod<D, BAND> {
    /// Constraints by segment: one axis to bend about in the plane, three in space.
    const ROWS: usize = 1 + D * (D - 1) / 2;

    /// A rope at rest along these nodes, three or more at equal steps.
    pub(crate) fn new(nodes: Vec<[f64; D]>, material: Material) -> Self {
        let count = nodes.len();
        // The last segment has no bend at its end.
        let constraints = Self::ROWS * (count - 2) + 1;
        let none = Constraint {
            value: 0.0,
            gradient: [[0.0; D]; 3],
            nodes: 0,
        };
        Self {
            material,
            before: nodes.clone(),
            at: nodes,
            velocity: vec![[0.0; D]; count],
            mobility: vec![
                Mobility {
                    along: 1.0,
                    up: 1.0
                };
                count
            ],
            constraints: vec![none; constraints],
            system: Band::new(constraints),
            multipliers: vec![0.0; constraints],
        }
    }

    pub(crate) fn nodes(&self) -> &[[f64; D]] {
        &self.at
    }

    /// How much longer it is than when it is loose, as a share.
    pub(crate) fn stretch(&self) -> f64 {
        let chords = self.at.windows(2).map(|pair| minus(pair[1], pair[0]));
        let length_px: f64 = chords.map(length).sum();
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
    pub(crate) fn step(&mut self, step_s: f64, held: impl IntoIterator<Item = (usize, [f64; D])>) {
        self.predict(step_s);
        for (node, at) in held {
            self.at[node] = at;
            self.mobility[node].along = 0.0;
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
            friction,
            damping_per_s,
            lies_at_px,
            ..
        } = self.material;
        self.before.copy_from_slice(&self.at);
        for ((at, velocity), mobility) in self
            .at
            .iter_mut()
            .zip(&self.velocity)
            .zip(&mut self.mobility)
        {
            let mut pressed_px_s2 = GRAVITY_PX_S2;
            let mut along = *velocity;
            if D == 3 {
                pressed_px_s2 = TABLE_PER_S2 * (lies_at_px - at[2]).max(0.0);
                along[2] = 0.0;
            }
            let speed_px_s = length(along).max(CREEP_PX_S);
            let drag_per_s = friction * pressed_px_s2 / speed_px_s + damping_per_s;
            mobility.along = 1.0 / (1.0 + drag_per_s * step_s);
            push(at, mobility.along * step_s, along);
            if D == 3 {
                let (by_px, up) = fall(at[2] - lies_at_px, velocity[2], damping_per_s, step_s);
                at[2] += by_px;
                mobility.up = up / mobility.along;
            }
        }
    }

    /// Moves the nodes so that the constraints hold as stiffly as they should.
    fn constrain(&mut self, step_s: f64) {
        self.linearize();
        let per_step2 = 1.0 / (step_s * step_s);
        for row in 0..self.constraints.len() {
            for d in 0..BAND.min(row + 1) {
                self.system.rows[row][d] = self.coupling(row, row - d);
            }
            self.system.rows[row][0] += self.compliance(row) * per_step2;
            self.multipliers[row] = -self.constraints[row].value;
        }
        self.system.solve(&mut self.multipliers);
        for (row, constraint) in self.constraints.iter().enumerate() {
            let first = row / Self::ROWS;
            for (i, gradient) in constraint.gradient[..constraint.nodes].iter().enumerate() {
                let Mobility { along, up } = self.mobility[first + i];
                let mut gradient = *gradient;
                if D == 3 {
                    gradient[2] *= up;
                }
                push(
                    &mut self.at[first + i],
                    along * self.multipliers[row],
                    gradient,
                );
            }
        }
    }

    /// Values and gradients of all constraints at the nodes as they are.
    fn linearize(&mut self) {
        let segment_px = self.material.segment_px;
        for (row, constraint) in self.constraints.iter_mut().enumerate() {
            let nodes = &self.at[row / Self::ROWS..];
            *constraint = match row % Self::ROWS {
                0 => stretch(nodes[0], nodes[1], segment_px),
                axis => bend([nodes[0], nodes[1], nodes[2]], segment_px, AXES[axis - 1]),
            };
        }
    }

    /// The entry of J W Jᵀ for two constraints, `a` not before `b`.
    fn coupling(&self, a: usize, b: usize) -> f64 {
        let (later, earlier) = (&self.constraints[a], &self.constraints[b]);
        let first = a / Self::ROWS;
        let offset = first - b / Self::ROWS;
        (0..later.nodes)
            .filter(|i| i + offset < earlier.nodes)
            .map(|i| {
                let Mobility { along, up } = self.mobility[first + i];
                let mut gradient = later.gradient[i];
                if D == 3 {
                    gradient[2] *= up;
                }
                along * dot(gradient, earlier.gradient[i + offset])
            })
            .sum()
    }

    /// α of a constraint, for nodes of mass 1.
    fn compliance(&self, row: usize) -> f64 {
        let segment_px = self.material.segment_px;
        let stiffness = if row.is_multiple_of(Self::ROWS) {
            SOUND_PX_S * SOUND_PX_S
        } else {
            self.material.bending_px4_s2
        };
        segment_px * segment_px / stiffness
    }

    /// What is stored in the rope now.
    pub(crate) fn energy(&mut self) -> Energy {
        self.linearize();
        let stored = |is_meant: fn(usize) -> bool| -> f64 {
            let rows = (0..self.constraints.len()).filter(|row| is_meant(row % Self::ROWS));
            rows.map(|row| {
                let value = self.constraints[row].value;
                0.5 * value * value / self.compliance(row)
            })
            .sum()
        };
        let moving = self.velocity.iter().zip(&self.mobility);
        let above = |at: &[f64; D]| at[2] - self.material.lies_at_px;
        let height = |above: f64| {
            let pressed = above.min(0.0);
            GRAVITY_PX_S2 * above + 0.5 * TABLE_PER_S2 * pressed * pressed
        };
        Energy {
            kinetic: moving
                .filter(|(_, mobility)| mobility.along > 0.0)
                .map(|(v, _)| 0.5 * dot(*v, *v))
                .sum(),
            bending: stored(|of_segment| of_segment > 0),
            stretching: stored(|of_segment| of_segment == 0),
            height: match D {
                3 => self.at.iter().map(|at| height(above(at))).sum(),
                _ => 0.0,
            },
        }
    }
}

/// How far a node that is so high above where it would lie goes by itself along z, and how it gives way there. The table counts where
/// the node would be in it at the step's end.
fn fall(above_px: f64, velocity_px_s: f64, damping_per_s: f64, step_s: f64) -> (f64, f64) {
    let free_px_s = velocity_px_s - GRAVITY_PX_S2 * step_s;
    if above_px + step_s * free_px_s >= 0.0 {
        let up = 1.0 / (1.0 + damping_per_s * step_s);
        return (up * step_s * free_px_s, up);
    }
    let up = 1.0 / (1.0 + step_s * (TABLE_DAMPING_PER_S + step_s * TABLE_PER_S2));
    let pushed_px_s = free_px_s - step_s * TABLE_PER_S2 * above_px;
    (up * step_s * pushed_px_s, up)
}

/// How much longer a segment is than it should be.
fn stretch<const D: usize>(from: [f64; D], to: [f64; D], segment_px: f64) -> Constraint<D> {
    let chord = minus(to, from);
    let length_px = length(chord);
    // Two nodes upon each other have no direction; they are parted by their neighbours.
    let along = chord.map(|c| c / length_px.max(1e-9));
    Constraint {
        value: length_px - segment_px,
        gradient: [along.map(|c| -c), along, [0.0; D]],
        nodes: 2,
    }
}

/// Axes to bend about, each by the two that it is across: z, x, y.
const AXES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Of 2 tan(φ/2), for the turn φ at the middle one of three nodes, what is about an axis: 2 e·(a×b) / (ℓ² + a·b).
fn bend<const D: usize>(
    [p, q, r]: [[f64; D]; 3],
    segment_px: f64,
    [i, j]: [usize; 2],
) -> Constraint<D> {
    let (a, b) = (minus(q, p), minus(r, q));
    let square = segment_px * segment_px;
    let opening = (square + dot(a, b)).max(LEAST_OPENING * square);
    let value = 2.0 * (a[i] * b[j] - a[j] * b[i]) / opening;
    // b×e and e×a.
    let (mut of_a, mut of_b) = ([0.0; D], [0.0; D]);
    (of_a[i], of_a[j]) = (2.0 * b[j], -2.0 * b[i]);
    (of_b[i], of_b[j]) = (-2.0 * a[j], 2.0 * a[i]);
    push(&mut of_a, -value, b);
    push(&mut of_b, -value, a);
    let (by_a, by_b) = (of_a.map(|c| c / opening), of_b.map(|c| c / opening));
    Constraint {
        value,
        gradient: [by_a.map(|c| -c), minus(by_a, by_b), by_b],
        nodes: 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_those_of_finite_differences() {
        holds([[1.0, 2.0], [5.5, 4.0], [8.0, 8.5]], &AXES[..1]);
        holds([[1.0, 2.0, 0.5], [5.5, 4.0, 1.0], [8.0, 8.5, -1.0]], &AXES);
    }

    fn holds<const D: usize>(nodes: [[f64; D]; 3], axes: &[[usize; 2]]) {
        for &axis_across in axes {
            let of = |nodes: [[f64; D]; 3]| {
                [
                    bend(nodes, 5.0, axis_across),
                    stretch(nodes[0], nodes[1], 5.0),
                ]
            };
            let exact = of(nodes);
            for node in 0..3 {
                for axis in 0..D {
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
}
