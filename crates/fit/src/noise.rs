//! Propagates pixel noise to the control points of a curve that was fitted to mapped and resampled
//! points, such as those on a table.
//!
//! Pixel noise is independent, of variance σ² in each coordinate of each point. A map with the
//! derivative `Jᵢ` turns it into `σ² Sᵢ`, `Sᵢ = JᵢJᵢᵀ`, in the points `cᵢ` that are resampled. New
//! point `k` is `Σᵢ Rₖᵢ cᵢ` ([`Resampler`]) at the arc length `ρₖ S`, and the arc lengths change
//! with the points too. To first order, with `tₖ` the tangent, `sᵢ` the arc length up to old point
//! `i` and `S` that of the whole,
//!
//! ```text
//! dc'ₖ = Σᵢ Rₖᵢ (dcᵢ − tₖ dsᵢ) + tₖ ρₖ dS,      dsᵢ = Σ_{l ≤ i} τₗ·(dcₗ − dcₗ₋₁)
//! ```
//!
//! with the chords' directions `τₗ`. A point that slides along the curve does not change the curve;
//! only the ends matter. The control points are `s = P c'`, so that, with `T = PR`,
//! `Vⱼᵢ = Σₖ Pⱼₖ tₖ Rₖᵢ`, `αⱼ = Σₖ Pⱼₖ tₖ ρₖ` and `Kⱼₗ = αⱼ − Σ_{i ≥ l} Vⱼᵢ`,
//!
//! ```text
//! dsⱼ = Σᵢ Aⱼᵢ dcᵢ,     Aⱼᵢ = Tⱼᵢ I + Kⱼᵢ τᵢᵀ − Kⱼ,ᵢ₊₁ τᵢ₊₁ᵀ,     Cov(sⱼ) = σ² Σᵢ Aⱼᵢ Sᵢ Aⱼᵢᵀ
//! ```
//!
//! Directions are those of the curve, not of the noisy chords.
//!
//! σ² comes from the residuals. Sliding does not appear in them. With the normals `nᵢ` and
//! `H = BP`, the expectation of their sum of squares is therefore `σ² Σᵢ (nᵢᵀSᵢnᵢ) ‖(I − H) Rᵢ‖²`,
//! with `Rᵢ` the column of `R`. `‖(I − H)Rᵢ‖² = ‖Rᵢ‖² − RᵢᵀHRᵢ` if `H` is a projection (without
//! ridge and pins).
//!
//! A fit whose algebra changes with its points (weights, measured ρ, rational) has another `P` each
//! time. In that case `A` is that of the even fit, and each control point's covariance is
//! multiplied by the ratio of its variance factors `Cⱼⱼ` in the two fits.

use crate::basis::MAX_CONTROL_POINTS;
use crate::options::MAX_POINTS;
use crate::resample::{Resampler, length};
use faer::Mat;

/// A covariance, or a map's derivative times its transpose: symmetric.
pub type Square<const D: usize> = [[f64; D]; D];

/// Scratch memory for the sums over a line's points.
#[derive(Debug, Clone)]
pub(crate) struct Propagation<const D: usize> {
    /// Rows of `T` and `V` for one control point.
    t: Vec<f64>,
    v: Vec<[f64; D]>,
    /// Row of `BᵀR` for the same control point.
    u: Vec<f64>,
    /// `‖(I − H)Rᵢ‖²`.
    freedom: Vec<f64>,
    /// Points of the even fit's curve; later, its directions midway between neighboring points.
    curve: Vec<[f64; D]>,
    /// Directions of the curve at the chords of the old points, and at the new points.
    chords: Vec<[f64; D]>,
    tangents: Vec<[f64; D]>,
}

/// The even fit: `P` transposed and `B`, each N × m.
pub(crate) struct EvenFit<'a> {
    pub(crate) p: &'a Mat<f64>,
    pub(crate) b: &'a Mat<f64>,
}

impl<const D: usize> Propagation<D> {
    pub(crate) fn new() -> Self {
        Self {
            t: vec![0.0; MAX_POINTS],
            v: vec![[0.0; D]; MAX_POINTS],
            u: vec![0.0; MAX_POINTS],
            freedom: vec![0.0; MAX_POINTS],
            curve: vec![[0.0; D]; MAX_POINTS],
            chords: vec![[0.0; D]; MAX_POINTS],
            tangents: vec![[0.0; D]; MAX_POINTS],
        }
    }

    /// Computes the covariances of the control points for σ = 1. Returns the expected sum of
    /// squared residuals divided by σ². `squares` are the `Sᵢ`.
    pub(crate) fn run(
        &mut self,
        fit: &EvenFit,
        line: &Resampler<D>,
        squares: &[Square<D>],
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    ) -> f64 {
        let (count, closed) = line.shape();
        self.straighten(fit, line);
        self.freedom[..count].fill(0.0);
        for mean in &line.means[..count] {
            for (i, weight) in mean.sources() {
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

    /// Computes `T`, `V` and `BᵀR` of control point `j`. Returns `αⱼ`.
    fn gather(&mut self, fit: &EvenFit, line: &Resampler<D>, j: usize) -> [f64; D] {
        let (count, _) = line.shape();
        self.t[..count].fill(0.0);
        self.u[..count].fill(0.0);
        self.v[..count].fill([0.0; D]);
        let mut ends = [0.0; D];
        let fitted = fit.p.col_as_slice(j).iter().zip(fit.b.col_as_slice(j));
        for ((k, mean), (&p, &b)) in line.means[..count].iter().enumerate().zip(fitted) {
            let along = self.tangents[k].map(|c| p * c);
            for (i, weight) in mean.sources() {
                self.t[i] += p * weight;
                self.u[i] += b * weight;
                self.v[i] = std::array::from_fn(|axis| self.v[i][axis] + along[axis] * weight);
            }
            // Points beyond a closed line's seam are one whole length farther, or nearer.
            let rho = mean.rho - line.beyond_the_seam(mean);
            ends = std::array::from_fn(|axis| ends[axis] + along[axis] * rho);
        }
        ends
    }

    /// `Σᵢ Aⱼᵢ Sᵢ Aⱼᵢᵀ` from the last point to the first.
    fn sum(&self, squares: &[Square<D>], ends: [f64; D], closed: bool) -> Square<D> {
        let count = squares.len();
        let mut sum = [[0.0; D]; D];
        // K of the chord that leaves the point, and the sum of V from this point on.
        let mut away = if closed { ends } else { [0.0; D] };
        let mut behind = [0.0; D];
        for i in (0..count).rev() {
            behind = std::array::from_fn(|axis| behind[axis] + self.v[i][axis]);
            let into = match i {
                0 if closed => ends,
                0 => [0.0; D],
                _ => std::array::from_fn(|axis| ends[axis] - behind[axis]),
            };
            let before = self.chords[(i + count - 1) % count];
            let after = self.chords[i];
            let mut a = [[0.0; D]; D];
            for (row, entries) in a.iter_mut().enumerate() {
                entries[row] = self.t[i];
                for (column, entry) in entries.iter_mut().enumerate() {
                    *entry += into[row] * before[column] - away[row] * after[column];
                }
            }
            for row in 0..D {
                for column in row..D {
                    sum[row][column] += between(a[row], &squares[i], a[column]);
                    sum[column][row] = sum[row][column];
                }
            }
            away = into;
        }
        sum
    }

    /// `nᵀSn` at an old point, with the normal of the curve there; in 3-D, the sum over two
    /// normals.
    fn across(&self, i: usize, closed: bool, squares: &[Square<D>]) -> f64 {
        let count = squares.len();
        let before = match i {
            0 if !closed => self.chords[0],
            _ => self.chords[(i + count - 1) % count],
        };
        let after = match i {
            _ if i + 1 == count && !closed => before,
            _ => self.chords[i],
        };
        let along = direction(
            std::array::from_fn(|axis| before[axis] + after[axis]),
            before,
        );
        let square = &squares[i];
        if let ([x, y], 2) = (&along[..2.min(D)], D) {
            return square[0][0] * y * y - 2.0 * square[0][1] * x * y + square[1][1] * x * x;
        }
        (0..D).map(|axis| square[axis][axis]).sum::<f64>() - between(along, square, along)
    }

    /// Computes the directions of the curve. The directions of the noisy chords are unsuitable.
    /// With 0.3 px of noise and steps of 5 px, consecutive chords turn three times as much as the
    /// rope, and the effect of turns is squared.
    fn straighten(&mut self, fit: &EvenFit, line: &Resampler<D>) {
        let (count, closed) = line.shape();
        let points = line.points();
        self.curve[..count].fill([0.0; D]);
        for j in 0..fit.p.ncols() {
            let (p, b) = (fit.p.col_as_slice(j), fit.b.col_as_slice(j));
            let sum = |axis: usize| p.iter().zip(points).map(|(p, point)| p * point[axis]).sum();
            let control_point: [f64; D] = std::array::from_fn(sum);
            for (at, b) in self.curve[..count].iter_mut().zip(b) {
                *at = std::array::from_fn(|axis| at[axis] + b * control_point[axis]);
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
            let way = std::array::from_fn(|axis| next[axis] - self.curve[k][axis]);
            self.curve[k] = direction(way, line.chords[k]);
        }
        // Interpolates between the middles of two steps. The place along the line is given in steps
        // from the first new point.
        let turns = &self.curve[..steps];
        let at = |place: f64, chord: [f64; D]| {
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
                std::array::from_fn(|axis| a[axis] + share * (b[axis] - a[axis])),
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

/// A vector scaled to length one; `other` if it has no direction.
fn direction<const D: usize>(vector: [f64; D], other: [f64; D]) -> [f64; D] {
    let size = length(vector);
    if size > 1e-9 {
        vector.map(|c| c / size)
    } else {
        other
    }
}

/// `pᵀ S q`.
fn between<const D: usize>(p: [f64; D], square: &Square<D>, q: [f64; D]) -> f64 {
    let mut sum = 0.0;
    for a in 0..D {
        sum += square[a][a] * p[a] * q[a];
        for b in a + 1..D {
            sum += square[a][b] * (p[a] * q[b] + p[b] * q[a]);
        }
    }
    sum
}
