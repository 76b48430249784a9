//! The rope: a chain of point masses that hardly stretches, resists bending and has friction with
//! the table. It is in the plane of the table, or in 3-D above the table.
//!
//! The method is extended position-based dynamics (Macklin, Müller and Chentanez, *XPBD*, 2016; one
//! iteration in each of many small steps: Macklin et al., *Small Steps in Physics Simulation*,
//! 2019). Each constraint C with compliance α has the energy C² / 2α. A step predicts the free
//! motion of the masses to x̃, and moves them by
//!
//! ```text
//! Δx = W Jᵀλ,   (J W Jᵀ + α/Δt²) λ = −C(x̃),   v = (x̃ + Δx − x) / Δt
//! ```
//!
//! Along a chain, this system is banded. It is solved exactly (as in Deul et al., *Direct
//! Position-Based Solver for Stiff Rods*, 2018) and not constraint by constraint. A pull therefore
//! acts on the other end at once, however stiff the rope is. Bending is that of discrete elastic
//! rods (Bergou et al. 2008): 2 tan(φ/2) for the angle φ between two segments. In the plane,
//! bending is about a single axis. In 3-D it is about three axes: its components are those of the
//! curvature binormal. A rope in 3-D has no torsional stiffness.
//!
//! Coulomb friction is a drag with the coefficient μp divided by the speed, where p is the contact
//! pressure on the table per mass. It is implicit like everything else: it is part of W, the
//! inverse of the resistance in a step. Below [`CREEP_PX_S`], the coefficient is constant. A rope
//! at rest is thus held by a drag so strong that it creeps by less than a pixel in a quarter of an
//! hour.
//!
//! In the plane, the whole weight of the rope presses on the table. In 3-D, gravity pulls the rope
//! down, and the table below is a stiff damped spring. This spring is implicit, too: a part of W
//! along z.
//!
//! There is no self-contact: strands pass through each other.

use crate::band::Band;
use crate::vector::{dot, length, minus, push};

/// Gravity in px/s².
pub(crate) const GRAVITY_PX_S2: f64 = 9810.0;
/// Speed below which friction no longer grows.
const CREEP_PX_S: f64 = 1e-3;
/// Speed at which a pull travels along the rope. With this value, the rope stretches by a millionth
/// under its own friction.
const SOUND_PX_S: f64 = 1e6;
/// Minimum value of 1 + cos φ, because segments folded onto each other have no direction to unfold
/// in.
const LEAST_OPENING: f64 = 0.05;
/// Stiffness of the table, per mass: under its own weight, a rope sinks into it by a fiftieth of a
/// millimeter.
const TABLE_PER_S2: f64 = GRAVITY_PX_S2 / 0.02;
/// Damping of motion into the table. It is critical (2√stiffness), so nothing bounces.
const TABLE_DAMPING_PER_S: f64 = 1400.0;

/// Properties of a rope and of the table below it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Material {
    /// Length of a segment.
    pub(crate) segment_px: f64,
    /// Bending stiffness divided by the mass of a pixel's length, in px⁴/s².
    pub(crate) bending_px4_s2: f64,
    /// Coefficient of friction with the table.
    pub(crate) friction: f64,
    /// Share of its speed that the rope loses per second in addition to friction.
    pub(crate) damping_per_s: f64,
    /// Height of the centerline of a rope on the table, in 3-D.
    pub(crate) lies_at_px: f64,
}

/// Energy stored in a rope, in px²/s² per mass of one node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// Kinetic energy, without the nodes that grippers hold.
    pub kinetic: f64,
    /// Bending energy.
    pub bending: f64,
    /// Stretching energy.
    pub stretching: f64,
    /// Energy of the height above the table, and of the pressure into it; 0 in the plane.
    pub height: f64,
}

impl Energy {
    /// Returns the total energy.
    pub fn total(&self) -> f64 {
        self.kinetic + self.bending + self.stretching + self.height
    }
}

/// One constraint at the current positions: its value, and its gradient at each of its nodes, from
/// the first one on.
#[derive(Debug, Clone, Copy)]
struct Constraint<const D: usize> {
    value: f64,
    gradient: [[f64; D]; 3],
    /// Number of nodes that it involves.
    nodes: usize,
}

/// Mobility of a node in a step.
#[derive(Debug, Clone, Copy)]
struct Mobility {
    /// 0 if a gripper holds the node, 1 if nothing resists.
    along: f64,
    /// Share of `along` that remains in the z direction.
    up: f64,
}

/// A chain of nodes of equal mass. `BAND`: width of the system's band, which is 2 (1 + bends) +
/// bends, where `bends` is the number of bending axes of a node: 5 in the plane, 11 in 3-D.
#[derive(Debug, Clone)]
pub(crate) struct Rod<const D: usize, const BAND: usize> {
    material: Material,
    at: Vec<[f64; D]>,
    before: Vec<[f64; D]>,
    velocity: Vec<[f64; D]>,
    mobility: Vec<Mobility>,
    /// Stretch of segment k, then the bends at its end. In this order the system is banded.
    constraints: Vec<Constraint<D>>,
    system: Band<BAND>,
    multipliers: Vec<f64>,
}

impl<const D: usize, const BAND: usize> Rod<D, BAND> {
    /// Number of constraints per segment: a stretch, and one bending axis in the plane or three in
    /// 3-D.
    const ROWS: usize = 1 + D * (D - 1) / 2;

    /// Makes a rope at rest along these nodes, at least three at equal steps.
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

    /// Relative elongation, compared with the relaxed rope.
    pub(crate) fn stretch(&self) -> f64 {
        let chords = self.at.windows(2).map(|pair| minus(pair[1], pair[0]));
        let length_px: f64 = chords.map(length).sum();
        length_px / (self.material.segment_px * (self.at.len() - 1) as f64) - 1.0
    }

    /// Speed of the fastest node.
    pub(crate) fn speed_px_s(&self) -> f64 {
        self.velocity
            .iter()
            .map(|v| dot(*v, *v))
            .fold(0.0, f64::max)
            .sqrt()
    }

    /// Makes one time step. `held` gives the positions of the held nodes at the end of the step.
    pub(crate) fn step(&mut self, step_s: f64, held: impl IntoIterator<Item = (usize, [f64; D])>) {
        self.predict(step_s);
        for (node, at) in held {
            self.at[node] = at;
            self.mobility[node].along = 0.0;
        }
        self.constrain(step_s);
        // If the rope is wound up beyond what its stiffness can be solved for, it stays where it
        // was.
        if !self.at.as_flattened().iter().all(|c| c.is_finite()) {
            self.at.copy_from_slice(&self.before);
        }
        for ((velocity, at), before) in self.velocity.iter_mut().zip(&self.at).zip(&self.before) {
            *velocity = minus(*at, *before).map(|d| d / step_s);
        }
    }

    /// Predicts the free motion of each node, slowed by the table.
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

    /// Moves the nodes so that the constraints hold with their stiffness.
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

    /// Computes the values and gradients of all constraints at the current nodes.
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

    /// Entry of J W Jᵀ for two constraints, with `a` not before `b`.
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

    /// Compliance α of a constraint, for nodes of mass 1.
    fn compliance(&self, row: usize) -> f64 {
        let segment_px = self.material.segment_px;
        let stiffness = if row.is_multiple_of(Self::ROWS) {
            SOUND_PX_S * SOUND_PX_S
        } else {
            self.material.bending_px4_s2
        };
        segment_px * segment_px / stiffness
    }

    /// Returns the energy stored in the rope now.
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

/// Free motion along z of a node at this height above its resting height, and its mobility there.
/// The table counts if the node would be inside it at the end of the step.
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

/// Elongation of a segment.
fn stretch<const D: usize>(from: [f64; D], to: [f64; D], segment_px: f64) -> Constraint<D> {
    let chord = minus(to, from);
    let length_px = length(chord);
    // Coincident nodes have no direction; their neighbors separate them.
    let along = chord.map(|c| c / length_px.max(1e-9));
    Constraint {
        value: length_px - segment_px,
        gradient: [along.map(|c| -c), along, [0.0; D]],
        nodes: 2,
    }
}

/// Bending axes z, x and y, each given by the two axes perpendicular to it.
const AXES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Component about an axis of 2 tan(φ/2), for the turn φ at the middle one of three nodes: 2
/// e·(a×b) / (ℓ² + a·b).
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
