//! What noise of the pixels does to the control points of a curve that was fitted elsewhere: on a table, to points that were
//! set anew at equal steps.
//!
//! Pixel noise is independent, of variance σ² in each coordinate of each point. A map with the derivative `Jᵢ` makes of it
//! `σ² Sᵢ`, `Sᵢ = JᵢJᵢᵀ`, in the points `cᵢ` that are resampled: new point `k` is `Σᵢ Rₖᵢ cᵢ` ([`Resampler`]) at the arc
//! length `ρₖ S`, and the arc lengths too change with the points. To the first order, with `tₖ` the tangent, `sᵢ` the arc
//! length up to old point `i` and `S` that of the whole,
//!
//! ```text
//! dc'ₖ = Σᵢ Rₖᵢ (dcᵢ − tₖ dsᵢ) + tₖ ρₖ dS,      dsᵢ = Σ_{l ≤ i} τₗ·(dcₗ − dcₗ₋₁)
//! ```
//!
//! with the chords' directions `τₗ`: where a point slides along the curve the curve stays, and only the ends tell. The control
//! points are `s = P c'`, so that, with `T = PR`, `Vⱼᵢ = Σₖ Pⱼₖ tₖ Rₖᵢ`, `αⱼ = Σₖ Pⱼₖ tₖ ρₖ` and `Kⱼₗ = αⱼ − Σ_{i ≥ l} Vⱼᵢ`,
//!
//! ```text
//! dsⱼ = Σᵢ Aⱼᵢ dcᵢ,     Aⱼᵢ = Tⱼᵢ I + Kⱼᵢ τᵢᵀ − Kⱼ,ᵢ₊₁ τᵢ₊₁ᵀ,     Cov(sⱼ) = σ² Σᵢ Aⱼᵢ Sᵢ Aⱼᵢᵀ
//! ```
//!
//! Directions are those of the curve, not of the noisy chords.
//!
//! σ² comes from the residuals. What slides does not show in them, so that with the normals `nᵢ` and `H = BP` their sum of
//! squares is, in the mean, `σ² Σᵢ (nᵢᵀSᵢnᵢ) ‖(I − H) Rᵢ‖²`, `Rᵢ` the column of `R`, and `‖(I − H)Rᵢ‖² = ‖Rᵢ‖² − RᵢᵀHRᵢ` where `H`
//! is a projection (without ridge and pins).
//!
//! A fit whose algebra changes with its points (weights, measured ρ, rational) has another `P` each time; there `A` is that
//! of the even fit, and each control point's covariance is scaled as that point's own factor in `C` is.

use crate::basis::MAX_CONTROL_POINTS;
use crate::matrix::Matrix;
use crate::options::MAX_POINTS;
use crate::resample::Resampler;

/// Room for the sums over a line's points.
#[derive(Debug, Clone)]
pub(crate) struct Propagation {
    /// Of one control point: `T`, and `V`.
    t: Vec<f64>,
    v: Vec<[f64; 2]>,
    /// `BᵀR` of the same.
    u: Vec<f64>,
    /// `‖(I − H)Rᵢ‖²`.
    freedom: Vec<f64>,
    /// Points of the even fit's curve, then its directions in the middle between each and the next.
    curve: Vec<[f64; 2]>,
    /// Its directions where the chords of the old points are, and at the new points.
    chords: Vec<[f64; 2]>,
    tangents: Vec<[f64; 2]>,
}

/// The even fit: `P` transposed and `B`, each N × m.
pub(crate) struct EvenFit<'a> {
    pub(crate) p: &'a Matrix,
    pub(crate) b: &'a Matrix,
}

impl Propagation {
    pub(crate) fn new() -> Self {
        Self {
            t: vec![0.0; MAX_POINTS],
            v: vec![[0.0; 2]; MAX_POINTS],
            u: vec![0.0; MAX_POINTS],
            freedom: vec![0.0; MAX_POINTS],
            curve: vec![[0.0; 2]; MAX_POINTS],
            chords: vec![[0.0; 2]; MAX_POINTS],
            tangents: vec![[0.0; 2]; MAX_POINTS],
        }
    }

    /// The covariances `[xx, xy, yy]` of the control points for σ = 1, and by how much of σ² the sum of squared residuals
    /// grows in the mean. `squares` are the `Sᵢ`.
    pub(crate) fn run(
        &mut self,
        fit: &EvenFit,
        line: &Resampler,
        squares: &[[f64; 3]],
        covariances: &mut [[f64; 3]; MAX_CONTROL_POINTS],
    ) -> f64 {
        let (count, closed) = line.shape();
        self.straighten(fit, line);
        self.freedom[..count].fill(0.0);
        for mean in &line.means[..count] {
            for (i, weight) in line.sources(mean) {
                self.freedom[i] += weight * weight;
            }
        }
        for (j, covariance) in covariances.iter_mut().enumerate().take(fit.p.ncols()) {
            let ends = self.gather(fit, line, j);
            for i in 0..count {
                self.freedom[i] -= self.u[i] * self.t[i];
            }
            *covariance = self.sum(squares, ends, closed);
        }
        let normals = (0..count).map(|i| self.across(i, closed, squares));
        let freedom = self.freedom[..count].iter();
        normals.zip(freedom).map(|(n, f)| n * f.max(0.0)).sum()
    }

    /// `T`, `V` and `BᵀR` of control point `j`; returns `αⱼ`.
    fn gather(&mut self, fit: &EvenFit, line: &Resampler, j: usize) -> [f64; 2] {
        let (count, _) = line.shape();
        self.t[..count].fill(0.0);
        self.u[..count].fill(0.0);
        self.v[..count].fill([0.0; 2]);
        let mut ends = [0.0; 2];
        let fitted = fit.p.column(j).iter().zip(fit.b.column(j));
        for ((k, mean), (&p, &b)) in line.means[..count].iter().enumerate().zip(fitted) {
            let along = self.tangents[k].map(|c| p * c);
            for (i, weight) in line.sources(mean) {
                self.t[i] += p * weight;
                self.u[i] += b * weight;
                self.v[i] = [0, 1].map(|axis| self.v[i][axis] + along[axis] * weight);
            }
            // What is beyond a closed line's seam lies a whole length farther, or not yet one far.
            let rho = mean.rho - line.beyond_the_seam(mean);
            ends = [0, 1].map(|axis| ends[axis] + along[axis] * rho);
        }
        ends
    }

    /// `Σᵢ Aⱼᵢ Sᵢ Aⱼᵢᵀ` from the last point to the first.
    fn sum(&self, squares: &[[f64; 3]], ends: [f64; 2], closed: bool) -> [f64; 3] {
        let count = squares.len();
        let mut sum = [0.0; 3];
        // K of the chord that leads away from the point, and what of V lies behind it.
        let mut away = if closed { ends } else { [0.0; 2] };
        let mut behind = [0.0; 2];
        for i in (0..count).rev() {
            behind = [0, 1].map(|axis| behind[axis] + self.v[i][axis]);
            let into = match i {
                0 if closed => ends,
                0 => [0.0; 2],
                _ => [0, 1].map(|axis| ends[axis] - behind[axis]),
            };
            let before = self.chords[(i + count - 1) % count];
            let after = self.chords[i];
            let mut a = [[self.t[i], 0.0], [0.0, self.t[i]]];
            for (row, entries) in a.iter_mut().enumerate() {
                for (column, entry) in entries.iter_mut().enumerate() {
                    *entry += into[row] * before[column] - away[row] * after[column];
                }
            }
            let [xx, xy, yy] = squares[i];
            let dot = |p: [f64; 2], q: [f64; 2]| {
                xx * p[0] * q[0] + xy * (p[0] * q[1] + p[1] * q[0]) + yy * p[1] * q[1]
            };
            sum[0] += dot(a[0], a[0]);
            sum[1] += dot(a[0], a[1]);
            sum[2] += dot(a[1], a[1]);
            away = into;
        }
        sum
    }

    /// `nᵀSn` at an old point, with the normal of the curve there.
    fn across(&self, i: usize, closed: bool, squares: &[[f64; 3]]) -> f64 {
        let count = squares.len();
        let before = match i {
            0 if !closed => self.chords[0],
            _ => self.chords[(i + count - 1) % count],
        };
        let after = match i {
            _ if i + 1 == count && !closed => before,
            _ => self.chords[i],
        };
        let [x, y] = direction([before[0] + after[0], before[1] + after[1]], before);
        let [xx, xy, yy] = squares[i];
        xx * y * y - 2.0 * xy * x * y + yy * x * x
    }

    /// The directions of the curve. Those of the noisy chords themselves would not do: at 0.3 px of noise and steps of 5 px
    /// they turn by three times as much from one to the next as a rope does, and the effect of turns is squared.
    fn straighten(&mut self, fit: &EvenFit, line: &Resampler) {
        let (count, closed) = line.shape();
        let points = line.points();
        self.curve[..count].fill([0.0; 2]);
        for j in 0..fit.p.ncols() {
            let (p, b) = (fit.p.column(j), fit.b.column(j));
            let sum = |axis: usize| p.iter().zip(points).map(|(p, point)| p * point[axis]).sum();
            let control_point: [f64; 2] = [sum(0), sum(1)];
            for (at, b) in self.curve[..count].iter_mut().zip(b) {
                *at = [0, 1].map(|axis| at[axis] + b * control_point[axis]);
            }
        }
        let steps = if closed { count } else { count - 1 };
        let first = self.curve[0];
        for k in 0..steps {
            let next = if k + 1 == count {
                first
            } else {
                self.curve[k + 1]
            };
            let way = [0, 1].map(|axis| next[axis] - self.curve[k][axis]);
            self.curve[k] = direction(way, line.chords[k]);
        }
        // At a place along the line, in steps from the first new point: between the middles of two steps.
        let turns = &self.curve[..steps];
        let at = |place: f64, chord: [f64; 2]| {
            let place = if closed {
                place
            } else {
                place.clamp(0.5, steps as f64 - 0.5)
            };
            let before = (place - 0.5).floor();
            let share = place - 0.5 - before;
            let turn = |k: f64| turns[(k.rem_euclid(steps as f64) as usize).min(steps - 1)];
            let (a, b) = (
                turn(before),
                turn(if share > 0.0 { before + 1.0 } else { before }),
            );
            direction(
                [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis])),
                chord,
            )
        };
        for (i, chord) in self.chords[..steps].iter_mut().enumerate() {
            *chord = at(steps as f64 * line.middle(i), line.chords[i]);
        }
        for (k, tangent) in self.tangents[..count].iter_mut().enumerate() {
            *tangent = at(k as f64, line.tangent(&line.means[k]));
        }
    }
}

/// A vector made one long; `other`, if it has no direction.
fn direction(vector: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    let size = libm::hypot(vector[0], vector[1]);
    if size > 1e-9 {
        vector.map(|c| c / size)
    } else {
        other
    }
}
