//! What errors of points that are each known by an ellipsoid of its own do to the control points: in space, where distances
//! are less sure than directions.
//!
//! [`Fitter::propagate`] follows each pixel through the resampling, exactly and in time N m per point's neighbors. Here the points are
//! taken at equal steps as they are: what an error along the curve does is left out of each point (it slides, and the curve stays), and
//! comes in by the ends, between which everything is stretched. With `tₖ` the direction at point `k`, `Nₖ = I − tₖtₖᵀ`, `Sₖ` the ellipsoid,
//! `σ₀` and `σ₁` how sure the ends are along the curve, and `s = P c`,
//!
//! ```text
//! Cov(sⱼ) = ν Σₖ Pⱼₖ² Nₖ Sₖ Nₖ + σ₀² aⱼ aⱼᵀ + σ₁² bⱼ bⱼᵀ,    aⱼ = Σₖ Pⱼₖ (1 − ρₖ) tₖ,    bⱼ = Σₖ Pⱼₖ ρₖ tₖ
//! ```
//!
//! where `ν` says how many neighbors err alike.

use crate::basis::MAX_CONTROL_POINTS;
use crate::fitter::Fitter;
use crate::noise::Square;
use crate::options::MAX_POINTS;

/// Points to each side that a direction is taken from.
const ASIDE: usize = 3;

/// The errors of a line's points.
#[derive(Debug, Clone, Copy)]
pub struct Spread<'a, const D: usize> {
    /// The covariance of each point.
    pub squares: &'a [Square<D>],
    /// The standard deviation of each end along the line; of a closed one, of where it begins.
    pub ends: [f64; 2],
    /// How many neighbors err alike, 1 or more.
    pub alike: f64,
}

/// Room for what each point does.
#[derive(Debug, Clone)]
pub(crate) struct Points<const D: usize> {
    tangents: Vec<[f64; D]>,
    across: Vec<Square<D>>,
}

impl<const D: usize> Points<D> {
    pub(crate) fn new() -> Self {
        Self {
            tangents: vec![[0.0; D]; MAX_POINTS],
            across: vec![[[0.0; D]; D]; MAX_POINTS],
        }
    }
}

impl<const D: usize> Fitter<D> {
    /// The covariances of the last fit's control points, where its `points`, at equal steps, err so. Residuals that are larger than
    /// the points' own ellipsoids say make all of them larger. Allocates nothing.
    ///
    /// None is written if there are other numbers of points than the fitter's.
    pub fn spread(
        &mut self,
        points: &[[f64; D]],
        spread: &Spread<D>,
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    ) {
        let count = self.options.points;
        if points.len() != count || spread.squares.len() != count || count < 2 {
            return;
        }
        let closed = self.options.basis.is_closed();
        let mut expected = 0.0;
        for k in 0..count {
            let [from, to] = match closed {
                true => [(k + count - ASIDE.min(count)) % count, (k + ASIDE) % count],
                false => [k.saturating_sub(ASIDE), (k + ASIDE).min(count - 1)],
            };
            let way: [f64; D] = std::array::from_fn(|axis| points[to][axis] - points[from][axis]);
            let size = way.iter().map(|c| c * c).sum::<f64>().sqrt();
            let tangent = way.map(|c| if size > 0.0 { c / size } else { 0.0 });
            let across = without(&spread.squares[k], tangent);
            expected += (0..D).map(|axis| across[axis][axis]).sum::<f64>();
            self.of_points.tangents[k] = tangent;
            self.of_points.across[k] = across;
        }
        let linear = &self.sizes[self.shown].linear;
        let residuals = self.fit.residual_variance * (D * count) as f64 / expected;
        let alike = spread.alike * residuals.max(1.0);
        let last = (count - 1) as f64;
        let controls = self.fit.control_points.len();
        for (j, covariance) in covariances.iter_mut().enumerate().take(controls) {
            let mut sum = [[0.0; D]; D];
            let [mut first, mut second] = [[0.0; D]; 2];
            for (k, &p) in linear.matrix.column(j).iter().enumerate() {
                let (across, tangent) = (&self.of_points.across[k], &self.of_points.tangents[k]);
                let (square, rho) = (p * p, k as f64 / last);
                for a in 0..D {
                    for b in a..D {
                        sum[a][b] += square * across[a][b];
                    }
                    first[a] += p * (1.0 - rho) * tangent[a];
                    second[a] += p * rho * tangent[a];
                }
            }
            let [one, other] = spread.ends.map(|sigma| sigma * sigma);
            for a in 0..D {
                for b in a..D {
                    let ends = one * first[a] * first[b] + other * second[a] * second[b];
                    covariance[a][b] = alike * sum[a][b] + ends;
                    covariance[b][a] = covariance[a][b];
                }
            }
        }
    }
}

/// What of a covariance is across a direction.
fn without<const D: usize>(square: &Square<D>, along: [f64; D]) -> Square<D> {
    let times: [f64; D] =
        std::array::from_fn(|a| (0..D).map(|b| square[a][b] * along[b]).sum::<f64>());
    let twice = (0..D).map(|a| along[a] * times[a]).sum::<f64>();
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            square[a][b] - along[a] * times[b] - times[a] * along[b] + twice * along[a] * along[b]
        })
    })
}
