//! What each point counts in the law, and how much of a shape is noise.
//!
//! A message has a covariance `Dⱼ` for each point; how two err together is the metric's, `Σⱼₖ = Dⱼ^½ cⱼₖ Dₖ^½` with `c` the
//! correlations of `M⁻¹` (as `lariat-wire` has it). So `W ∝ Σ⁻¹` has the blocks
//!
//! ```text
//! Wⱼₖ = Rⱼ Mⱼₖ Rₖ,      Rⱼ = (Dⱼ/gⱼ)^−½,    gⱼ = (M⁻¹)ⱼⱼ
//! ```
//!
//! scaled so that the mean of the `R²` is 1. With noise that is even along the curve `Dⱼ ∝ gⱼ I`, all `R` are `I`, and `W` is the metric.

use crate::command::{Weights, Why};
use crate::{Coordinates, Features, INPUTS, MAX_FEATURES, MAX_POINTS, Metric};

/// No point counts more than this many times another: a variance told too small, or one point seen by chance, must not steer alone.
const MOST_RATIO: f64 = 100.0;

/// Variances beyond are no measurement, px².
const MOST_VARIANCE_PX2: f64 = 1e12;

/// `W`, from frame to frame.
#[derive(Debug, Clone)]
pub(crate) struct Weighing {
    count: usize,
    gram: [[f64; MAX_POINTS]; MAX_POINTS],
    gains: [f64; MAX_POINTS],
    /// `Rⱼ`: xx, xy, yy.
    roots: [[f64; 3]; MAX_POINTS],
}

impl Weighing {
    pub(crate) fn new(metric: &Metric, count: usize) -> Self {
        let (gram, gains) = metric.matrix(count);
        Self {
            count,
            gram,
            gains,
            roots: [[1.0, 0.0, 1.0]; MAX_POINTS],
        }
    }

    /// Takes a frame's weights. The answer is the mean square distance that noise alone makes, px²: `tr (M ⊗ I₂)Σ`, which is `Σⱼ tr Dⱼ/gⱼ`.
    pub(crate) fn take(&mut self, weights: Weights, noise_px: f64) -> Result<f64, Why> {
        let mut relative = [[0.0; 3]; MAX_POINTS];
        let given = match weights {
            Weights::Even => {
                self.roots = [[1.0, 0.0, 1.0]; MAX_POINTS];
                return Ok(noise_px * noise_px);
            }
            Weights::Points(weights) => weights.len(),
            Weights::Covariances(covariances) => covariances.len(),
        };
        if given != self.count {
            return Err(Why::Weights);
        }
        let mut noise_px2 = 0.0;
        let mut largest = 0.0f64;
        for (j, relative) in relative[..given].iter_mut().enumerate() {
            let [xx, xy, yy] = variance(weights, j).ok_or(Why::Weights)?;
            *relative = [xx, xy, yy].map(|entry| entry / self.gains[j]);
            noise_px2 += relative[0] + relative[2];
            largest = largest.max(relative[0] + relative[2]);
        }
        // All at once without noise: nothing tells them apart.
        if largest == 0.0 {
            return self.take(Weights::Even, 0.0);
        }
        // A little noise in all, so that none counts without bounds.
        let least = 0.5 * largest / MOST_RATIO;
        let mut mean = 0.0;
        for (root, [xx, xy, yy]) in self.roots[..given].iter_mut().zip(relative) {
            *root = root_of_inverse([xx + least, xy, yy + least]);
            mean += 0.5 * (root[0] * root[0] + 2.0 * root[1] * root[1] + root[2] * root[2]);
        }
        let scale = (given as f64 / mean).sqrt();
        let roots = self.roots[..given].as_flattened_mut();
        roots.iter_mut().for_each(|entry| *entry *= scale);
        Ok(noise_px2)
    }

    /// Distance of two shapes with the difference `e`, px: by the metric alone.
    pub(crate) fn distance_px(&self, e: &Features) -> f64 {
        // Below 0 by rounding only.
        dot(e, &self.times_gram(e)).max(0.0).sqrt()
    }

    /// `JᵀWJ` and `JᵀWe`.
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
        for (j, [xx, xy, yy]) in self.roots[..self.count].iter().enumerate() {
            let [x, y] = [column[2 * j], column[2 * j + 1]];
            product[2 * j] = xx * x + xy * y;
            product[2 * j + 1] = xy * x + yy * y;
        }
        product
    }

    fn times_gram(&self, column: &Features) -> Features {
        let mut product = [0.0; MAX_FEATURES];
        for (j, row) in self.gram[..self.count].iter().enumerate() {
            let mut sum = [0.0; 2];
            for (k, entry) in row[..self.count].iter().enumerate() {
                sum[0] += entry * column[2 * k];
                sum[1] += entry * column[2 * k + 1];
            }
            product[2 * j..2 * j + 2].copy_from_slice(&sum);
        }
        product
    }
}

fn dot(a: &Features, b: &Features) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Of point `j`: xx, xy, yy. `None` if that is not a covariance.
fn variance(weights: Weights, j: usize) -> Option<[f64; 3]> {
    match weights {
        Weights::Even => Some([1.0, 0.0, 1.0]),
        Weights::Points(weights) => {
            let within = (1.0 / MOST_VARIANCE_PX2..=MOST_VARIANCE_PX2).contains(&weights[j]);
            within.then(|| [1.0 / weights[j], 0.0, 1.0 / weights[j]])
        }
        Weights::Covariances(covariances) => {
            let [xx, xy, yy] = covariances[j];
            let within = |variance| (0.0..=MOST_VARIANCE_PX2).contains(&variance);
            // Of a matrix that rounding has left with a determinant just below 0, the rest is good.
            let valid = within(xx) && within(yy) && xy * xy <= xx * yy * (1.0 + 1e-9);
            valid.then_some([xx, xy, yy])
        }
    }
}

/// `D^−½`: with `s = √det D` the root of `D` is `(D + sI)/√(tr D + 2s)`, and its inverse that one's adjugate by its determinant, `s`.
fn root_of_inverse([xx, xy, yy]: [f64; 3]) -> [f64; 3] {
    let s = (xx * yy - xy * xy).max(f64::MIN_POSITIVE).sqrt();
    let size = (xx + yy + 2.0 * s).sqrt() * s;
    [(yy + s) / size, -xy / size, (xx + s) / size]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_noise_of_the_curve_weighs_as_the_metric_does() {
        let metric = Metric::bezier(4).expect("a metric");
        let mut weighing = Weighing::new(&metric, 5);
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
        let mut weighing = Weighing::new(&Metric::default(), 3);
        weighing
            .take(Weights::Points(&[1.0, 1.0, 0.01]), 0.0)
            .expect("weights");
        let squares = [0, 1, 2].map(|j| weighing.roots[j][0].powi(2));
        assert!((squares.iter().sum::<f64>() - 3.0).abs() < 1e-12);
        // One hundredth, but for the little noise that is added: (1 + 1)/(100 + 1).
        assert!(
            (squares[2] / squares[0] - 2.0 / 101.0).abs() < 1e-12,
            "{squares:?}"
        );
    }

    #[test]
    fn no_point_counts_without_bounds() {
        let mut weighing = Weighing::new(&Metric::default(), 2);
        weighing
            .take(Weights::Covariances(&[[0.0; 3], [1.0, 0.0, 1.0]]), 0.0)
            .expect("weights");
        let ratio = (weighing.roots[0][0] / weighing.roots[1][0]).powi(2);
        assert!(ratio < MOST_RATIO + 2.0, "{ratio}");
    }

    #[test]
    fn the_root_of_an_inverse_squared_inverts() {
        let [xx, xy, yy] = [2.0, 0.7, 0.5];
        let [a, b, c] = root_of_inverse([xx, xy, yy]);
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
    fn weights_that_are_none_are_refused() {
        let mut weighing = Weighing::new(&Metric::default(), 2);
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
    }
}
