//! Weight of each point in the law, and the amount of noise in a shape.
//!
//! A message has a covariance `Dⱼ` for each point. The metric gives the joint covariance,
//! `Σⱼₖ = Dⱼ^½ cⱼₖ Dₖ^½` with the correlations `c` of `M⁻¹` (as in `lariat-wire`). So `W ∝ Σ⁻¹` has
//! the blocks
//!
//! ```text
//! Wⱼₖ = Rⱼ Mⱼₖ Rₖ,      Rⱼ = (Dⱼ/gⱼ)^−½,    gⱼ = (M⁻¹)ⱼⱼ
//! ```
//!
//! scaled so that the mean of the `R²` is 1. With noise that is even along the curve, `Dⱼ ∝ gⱼ I`,
//! all `R` are `I`, and `W` is the metric.

use crate::command::{Weights, Why};
use crate::eigen::{Eigen, eigen};
use crate::{Coordinates, Features, INPUTS, MAX_FEATURES, MAX_POINTS, Metric};

/// Maximum ratio of two points' weights. A point whose variance is underestimated, or a single
/// visible point, must not determine the motion alone.
const MOST_RATIO: f64 = 100.0;

/// Largest valid variance, px².
const MOST_VARIANCE_PX2: f64 = 1e12;

/// `W`, updated from frame to frame.
#[derive(Debug, Clone)]
pub(crate) struct Weighing {
    count: usize,
    /// Coordinates per point.
    dimensions: usize,
    gram: [[f64; MAX_POINTS]; MAX_POINTS],
    gains: [f64; MAX_POINTS],
    /// `Rⱼ`; z is unused in the plane.
    roots: [Symmetric; MAX_POINTS],
}

/// A symmetric matrix of a point's coordinates: `[xx, xy, xz, yy, yz, zz]`.
type Symmetric = [f64; 6];

impl Weighing {
    pub(crate) fn new(metric: &Metric, count: usize, dimensions: usize) -> Self {
        let (gram, gains) = metric.matrix(count);
        Self {
            count,
            dimensions,
            gram,
            gains,
            roots: [unit(dimensions); MAX_POINTS],
        }
    }

    /// Sets a frame's weights. Returns the mean square distance caused by noise alone, px²:
    /// `tr (M ⊗ I)Σ`, which is `Σⱼ tr Dⱼ/gⱼ`.
    pub(crate) fn take(&mut self, weights: Weights, noise_px: f64) -> Result<f64, Why> {
        let mut relative = [[0.0; 6]; MAX_POINTS];
        let (given, dimensions) = match weights {
            Weights::Even => {
                self.roots = [unit(self.dimensions); MAX_POINTS];
                return Ok(noise_px * noise_px);
            }
            Weights::Points(weights) => (weights.len(), self.dimensions),
            Weights::Covariances(covariances) => (covariances.len(), 2),
            Weights::Covariances3(covariances) => (covariances.len(), 3),
        };
        if (given, dimensions) != (self.count, self.dimensions) {
            return Err(Why::Weights);
        }
        let mut noise_px2 = 0.0;
        let mut largest = 0.0f64;
        for (j, relative) in relative[..given].iter_mut().enumerate() {
            let variance = variance(weights, j, dimensions).ok_or(Why::Weights)?;
            *relative = variance.map(|entry| entry / self.gains[j]);
            let trace = trace(relative);
            noise_px2 += trace;
            largest = largest.max(trace);
        }
        // All points are without noise, so their weights are equal.
        if largest == 0.0 {
            return self.take(Weights::Even, 0.0);
        }
        // Adds a little noise to all points, so that no weight is unbounded.
        let least = 0.5 * largest / MOST_RATIO;
        let mut mean = 0.0;
        for (root, mut relative) in self.roots[..given].iter_mut().zip(relative) {
            for (entry, unit) in relative.iter_mut().zip(unit(dimensions)) {
                *entry += least * unit;
            }
            *root = match dimensions {
                3 => root_of_inverse3(relative),
                _ => root_of_inverse(relative),
            };
            let [xx, xy, xz, yy, yz, zz] = root.map(|entry| entry * entry);
            mean += (xx + yy + zz + 2.0 * (xy + xz + yz)) / dimensions as f64;
        }
        let scale = (given as f64 / mean).sqrt();
        let roots = self.roots[..given].as_flattened_mut();
        roots.iter_mut().for_each(|entry| *entry *= scale);
        Ok(noise_px2)
    }

    /// Distance of two shapes with the difference `e`, px, by the metric alone.
    pub(crate) fn distance_px(&self, e: &Features) -> f64 {
        // Negative only by rounding.
        dot(e, &self.times_gram(e)).max(0.0).sqrt()
    }

    /// Returns `JᵀWJ` and `JᵀWe`.
    pub(crate) fn normal(
        &self,
        columns: &[Features; INPUTS],
        e: &Features,
    ) -> ([Coordinates; INPUTS], Coordinates) {
        let weighed = columns.map(|column| self.times_roots(&column));
        let e = self.times_roots(e);
        let mut matrix = [[0.0; INPUTS]; INPUTS];
        let mut right = [0.0; INPUTS];
        for i in 0..INPUTS {
            let product = self.times_gram(&weighed[i]);
            right[i] = dot(&product, &e);
            for j in 0..=i {
                matrix[i][j] = dot(&product, &weighed[j]);
                matrix[j][i] = matrix[i][j];
            }
        }
        (matrix, right)
    }

    fn times_roots(&self, column: &Features) -> Features {
        let mut product = [0.0; MAX_FEATURES];
        let each = self.dimensions;
        let points = (column.chunks_exact(each)).zip(product.chunks_exact_mut(each));
        for ((point, product), root) in points.zip(&self.roots[..self.count]) {
            let [xx, xy, xz, yy, yz, zz] = *root;
            match (point, product) {
                (&[x, y], [to_x, to_y]) => (*to_x, *to_y) = (xx * x + xy * y, xy * x + yy * y),
                (&[x, y, z], [to_x, to_y, to_z]) => {
                    *to_x = xx * x + xy * y + xz * z;
                    *to_y = xy * x + yy * y + yz * z;
                    *to_z = xz * x + yz * y + zz * z;
                }
                // Points have two or three coordinates.
                _ => {}
            }
        }
        product
    }

    fn times_gram(&self, column: &Features) -> Features {
        let mut product = [0.0; MAX_FEATURES];
        let each = self.dimensions;
        for (sum, row) in product.chunks_exact_mut(each).zip(&self.gram[..self.count]) {
            for (point, entry) in column.chunks_exact(each).zip(&row[..self.count]) {
                for (sum, coordinate) in sum.iter_mut().zip(point) {
                    *sum += entry * coordinate;
                }
            }
        }
        product
    }
}

fn dot(a: &Features, b: &Features) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Unit matrix of this many dimensions.
const fn unit(dimensions: usize) -> Symmetric {
    let up = if dimensions == 3 { 1.0 } else { 0.0 };
    [1.0, 0.0, 0.0, 1.0, 0.0, up]
}

fn trace([xx, _, _, yy, _, zz]: &Symmetric) -> f64 {
    xx + yy + zz
}

/// Covariance of point `j`. `None` if it is not a valid covariance.
fn variance(weights: Weights, j: usize, dimensions: usize) -> Option<Symmetric> {
    let within = |variance| (0.0..=MOST_VARIANCE_PX2).contains(&variance);
    // Tolerates a determinant that rounding has made slightly negative.
    let together = |ab: f64, a: f64, b: f64| ab * ab <= a * b * (1.0 + 1e-9);
    match weights {
        Weights::Even => Some(unit(dimensions)),
        Weights::Points(weights) => {
            let within = (1.0 / MOST_VARIANCE_PX2..=MOST_VARIANCE_PX2).contains(&weights[j]);
            within.then(|| unit(dimensions).map(|entry| entry / weights[j]))
        }
        Weights::Covariances(covariances) => {
            let [xx, xy, yy] = covariances[j];
            let valid = within(xx) && within(yy) && together(xy, xx, yy);
            valid.then_some([xx, xy, 0.0, yy, 0.0, 0.0])
        }
        Weights::Covariances3(covariances) => {
            let [xx, xy, xz, yy, yz, zz] = covariances[j];
            let valid = [xx, yy, zz].into_iter().all(within)
                && together(xy, xx, yy)
                && together(xz, xx, zz)
                && together(yz, yy, zz);
            valid.then_some(covariances[j])
        }
    }
}

/// `D^−½`. With `s = √det D`, the root of `D` is `(D + sI)/√(tr D + 2s)`, and its inverse is its
/// adjugate divided by its determinant, `s`.
fn root_of_inverse([xx, xy, _, yy, ..]: Symmetric) -> Symmetric {
    let s = (xx * yy - xy * xy).max(f64::MIN_POSITIVE).sqrt();
    let size = (xx + yy + 2.0 * s).sqrt() * s;
    [(yy + s) / size, -xy / size, 0.0, (xx + s) / size, 0.0, 0.0]
}

/// `D^−½` in 3-D, by the eigenvectors. Eigenvalues that rounding or an invalid covariance makes
/// negative are raised to a small positive value.
fn root_of_inverse3(d: Symmetric) -> Symmetric {
    let [xx, xy, xz, yy, yz, zz] = d;
    let Eigen { values, vectors } = eigen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let least = trace(&d) / (100.0 * MOST_RATIO);
    let mut root = [0.0; 6];
    for (value, [x, y, z]) in values.into_iter().zip(vectors) {
        let per = 1.0 / value.max(least).max(f64::MIN_POSITIVE).sqrt();
        for (entry, product) in root
            .iter_mut()
            .zip([x * x, x * y, x * z, y * y, y * z, z * z])
        {
            *entry += per * product;
        }
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_noise_of_the_curve_weighs_as_the_metric_does() {
        let metric = Metric::bezier(4).expect("a metric");
        let mut weighing = Weighing::new(&metric, 5, 2);
        let gains = metric.matrix(5).1;
        let covariances: Vec<[f64; 3]> = gains[..5]
            .iter()
            .map(|g| [0.01 * g, 0.0, 0.01 * g])
            .collect();
        let noise = weighing
            .take(Weights::Covariances(&covariances), 0.0)
            .expect("weights");
        assert!((noise - 0.01 * 10.0).abs() < 1e-12, "{noise}");
        for root in &weighing.roots[..5] {
            assert!((root[0] - 1.0).abs() < 1e-9 && root[1] == 0.0, "{root:?}");
        }
    }

    #[test]
    fn a_point_seen_badly_counts_less_and_the_mean_is_one() {
        let mut weighing = Weighing::new(&Metric::default(), 3, 2);
        weighing
            .take(Weights::Points(&[1.0, 1.0, 0.01]), 0.0)
            .expect("weights");
        let squares = [0, 1, 2].map(|j| weighing.roots[j][0].powi(2));
        assert!((squares.iter().sum::<f64>() - 3.0).abs() < 1e-12);
        // One hundredth, except for the small noise that is added: (1 + 1)/(100 + 1).
        assert!(
            (squares[2] / squares[0] - 2.0 / 101.0).abs() < 1e-12,
            "{squares:?}"
        );
    }

    #[test]
    fn no_point_counts_without_bounds() {
        let mut weighing = Weighing::new(&Metric::default(), 2, 2);
        weighing
            .take(Weights::Covariances(&[[0.0; 3], [1.0, 0.0, 1.0]]), 0.0)
            .expect("weights");
        let ratio = (weighing.roots[0][0] / weighing.roots[1][0]).powi(2);
        assert!(ratio < MOST_RATIO + 2.0, "{ratio}");
    }

    #[test]
    fn the_root_of_an_inverse_squared_inverts() {
        let [xx, xy, yy] = [2.0, 0.7, 0.5];
        let [a, b, _, c, ..] = root_of_inverse([xx, xy, 0.0, yy, 0.0, 0.0]);
        let square = [a * a + b * b, b * (a + c), b * b + c * c];
        let product = [
            square[0] * xx + square[1] * xy,
            square[0] * xy + square[1] * yy,
            square[1] * xy + square[2] * yy,
        ];
        for (given, wanted) in product.into_iter().zip([1.0, 0.0, 1.0]) {
            assert!((given - wanted).abs() < 1e-12, "{product:?}");
        }
    }

    #[test]
    fn in_space_it_does_too() {
        let d = [2.0, 0.7, -0.3, 0.5, 0.1, 1.5];
        let full = |[xx, xy, xz, yy, yz, zz]: Symmetric| [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let times = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum::<f64>()))
        };
        let root = full(root_of_inverse3(d));
        let product = times(times(root, root), full(d));
        for (i, row) in product.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let unit = f64::from(u8::from(i == j));
                assert!((entry - unit).abs() < 1e-12, "{product:?}");
            }
        }
        // A flat covariance has a bounded weight.
        let flat = root_of_inverse3([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        assert!(flat.iter().all(|entry| entry.is_finite()), "{flat:?}");
    }

    #[test]
    fn weights_that_are_none_are_refused() {
        let mut weighing = Weighing::new(&Metric::default(), 2, 2);
        for bad in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
            assert_eq!(
                weighing.take(Weights::Points(&[1.0, bad]), 1.0),
                Err(Why::Weights)
            );
        }
        for bad in [[-1.0, 0.0, 1.0], [1.0, 2.0, 1.0], [1.0, f64::NAN, 1.0]] {
            let covariances = [[1.0, 0.0, 1.0], bad];
            assert_eq!(
                weighing.take(Weights::Covariances(&covariances), 1.0),
                Err(Why::Weights)
            );
        }
        assert_eq!(
            weighing.take(Weights::Points(&[1.0]), 1.0),
            Err(Why::Weights)
        );
        // The dimensions differ.
        assert_eq!(
            weighing.take(Weights::Covariances3(&[unit(3); 2]), 1.0),
            Err(Why::Weights)
        );
        let mut in_space = Weighing::new(&Metric::default(), 1, 3);
        for bad in [
            [1.0, 0.0, 2.0, 1.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 1.0, f64::NAN, 1.0],
        ] {
            assert_eq!(
                in_space.take(Weights::Covariances3(&[bad]), 1.0),
                Err(Why::Weights)
            );
        }
    }
}
