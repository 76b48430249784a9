//! A mixture of isotropic Gaussians, fitted by expectation-maximization (A. Dempster, N. Laird and
//! D. Rubin, Maximum Likelihood from Incomplete Data via the EM Algorithm, Journal of the Royal
//! Statistical Society B 39, 1977).
//!
//! ```text
//! p(x)  = Σₖ wₖ N(x; μₖ, vₖI)
//! rᵢₖ   = wₖ N(xᵢ; μₖ, vₖI) / p(xᵢ)                                       (expectation)
//! nₖ    = Σᵢ rᵢₖ,  wₖ = nₖ/N,  μₖ = Σᵢ rᵢₖ xᵢ/nₖ,  vₖ = Σᵢ rᵢₖ|xᵢ − μₖ|²/2nₖ + ε  (maximization)
//! ```
//!
//! This is scikit-learn's `GaussianMixture(covariance_type="spherical")` with its defaults. At the
//! start, each pixel belongs to its nearest center. The first maximization computes weights, means
//! and variances from that. scikit-learn does the same with the labels of its k-means.
//!
//! A Gaussian's density vanishes far from its mean. The pixels of a tile (`tiles`) are evaluated
//! only for Gaussians whose share somewhere in the tile reaches a float's last bit. The number of
//! these depends on the density of the centers, not on K.

mod expectation;

use lariat_portable::Arch;

use super::extent::Extent;
use super::seeding::Seeding;
use super::tiles::{LANES, Tiles};
use super::{Outcome, Pixels, Start};
use expectation::{Expectation, Memory};

/// scikit-learn's defaults: the maximum number of rounds, the gain in log-likelihood per pixel
/// below which the rounds end, and the constant added to each variance, in px².
const MOST_ROUNDS: u32 = 100;
const TOLERANCE: f64 = 1e-3;
const REGULARIZATION: f64 = 1e-6;
/// Initial variance of all Gaussians, in px². It is so small that each pixel belongs to its nearest
/// center, or in equal parts to several equidistant ones.
const POINTED: f64 = 1e-4;
/// A Gaussian with less than this share of all pixels is given up and stays where it is.
const LEAST_PIXELS: f64 = 1e-9;

/// A weighted isotropic Gaussian.
#[derive(Clone, Copy, Debug)]
struct Gaussian {
    weight: f64,
    mean: [f64; 2],
    variance: f64,
}

/// Sums of a round for one Gaussian: Σr, Σrx, Σry, Σr|x|².
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    first: [f64; 2],
    second: f64,
}

/// A mixture of isotropic Gaussians. It keeps its memory from run to run.
#[derive(Debug, Default)]
pub struct Mixture {
    seeding: Seeding,
    tiles: Tiles,
    gaussians: Vec<Gaussian>,
    sums: Vec<Sums>,
    memory: Memory,
}

impl Mixture {
    /// Fits one Gaussian per center to `pixels`. Their means replace `centers`.
    ///
    /// The rounds end when one adds less than 0.001 to the log-likelihood, and after 100 at the
    /// latest. Each Gaussian starts with the variance and the weight of the pixels nearest to it.
    /// This also holds for [`Start::Given`], since only centers are given. Means stay within the
    /// bounding box of the pixels. A Gaussian without pixels stays where it is. Without pixels
    /// nothing changes.
    ///
    /// The objective is the mean log-likelihood of a pixel in nats, before the last round moved the
    /// Gaussians: scikit-learn's `lower_bound_`.
    pub fn run(&mut self, pixels: &Pixels, start: Start, centers: &mut [[f32; 2]]) -> Outcome {
        let mut outcome = Outcome {
            rounds: 0,
            objective: 0.0,
        };
        self.seeding.begin(pixels, start, centers);
        let Some(extent) = Extent::of(pixels).filter(|_| !centers.is_empty()) else {
            return outcome;
        };
        extent.confine(centers);
        self.tiles.fill(pixels);
        self.gaussians.clear();
        self.gaussians.extend(centers.iter().map(|c| Gaussian {
            weight: 1.0,
            mean: c.map(f64::from),
            variance: POINTED,
        }));
        self.sums.clear();
        self.sums.resize(centers.len(), Sums::default());
        self.round(pixels.len());
        outcome.objective = f64::NEG_INFINITY;
        while outcome.rounds < MOST_ROUNDS {
            let before = outcome.objective;
            outcome.objective = self.round(pixels.len());
            outcome.rounds += 1;
            if (outcome.objective - before).abs() < TOLERANCE {
                break;
            }
        }
        for (center, gaussian) in centers.iter_mut().zip(&self.gaussians) {
            *center = gaussian.mean.map(|c| c as f32);
        }
        // Rounding may have moved a mean just outside the box.
        extent.confine(centers);
        outcome
    }

    /// Runs both steps. Returns the mean log-likelihood before the second.
    fn round(&mut self, pixels: usize) -> f64 {
        self.memory.take(&self.gaussians);
        self.sums.fill(Sums::default());
        let bits = Arch::new().dispatch(Expectation {
            tiles: &self.tiles,
            gaussians: &self.gaussians,
            memory: &mut self.memory,
            sums: &mut self.sums,
        });
        for (gaussian, sums) in self.gaussians.iter_mut().zip(&self.sums) {
            gaussian.maximize(sums, pixels as f64);
        }
        bits * std::f64::consts::LN_2 / pixels as f64
    }
}

impl Gaussian {
    fn maximize(&mut self, sums: &Sums, pixels: f64) {
        self.weight = sums.count / pixels;
        if sums.count < LEAST_PIXELS {
            self.weight = 0.0;
            return;
        }
        self.mean = sums.first.map(|first| first / sums.count);
        let [x, y] = self.mean;
        let spread = sums.second / sums.count - (x * x + y * y);
        self.variance = 0.5 * spread.max(0.0) + REGULARIZATION;
    }

    /// Returns `level` and `fall` of its weighted density: at distance d from the mean, log₂ =
    /// level − fall·d².
    fn shape(&self) -> [f64; 2] {
        let level = libm::log2(self.weight / (std::f64::consts::TAU * self.variance));
        [level, 0.5 * std::f64::consts::LOG2_E / self.variance]
    }
}
