//! The least-squares problem of a basis, set up once: which columns are solved for, and which are
//! given.

use crate::basis::Basis;
use crate::factor::Qr;
use crate::matrix::product;
use faer::Mat;

/// `A s' ≈ [c̄; 0] − E [c₁; c_N]`: `s'` are the control points that are solved for, all of them or,
/// with the ends pinned, those between. `A` is their columns of `B` with the ridge's rows below,
/// and `E` the columns of the two pinned ones.
pub(crate) struct System {
    /// `B`, N × m.
    pub(crate) b: Mat<f64>,
    /// The ridge's rows `√λ D`, if any.
    pub(crate) penalty: Mat<f64>,
    /// `A`, (N + the penalty's rows) × (m − 2·pinned).
    pub(crate) a: Mat<f64>,
    /// `E`: two columns, or none.
    pub(crate) pinned: Mat<f64>,
}

/// The linear map from points to control points, and its consequences for any noise.
pub(crate) struct Estimator {
    /// `P`, m × N: `s = P c̄`.
    pub(crate) p: Mat<f64>,
    /// `C = P Pᵀ`: with independent noise of variance σ² in the points' coordinates, the control
    /// points' covariance is `σ² C`. Without ridge or pins it is `(BᵀB)⁻¹`.
    pub(crate) covariance: Mat<f64>,
    /// Expected sum of squared residuals of one coordinate, divided by σ²: `‖I − BP‖²`, which is N
    /// − m without ridge or pins.
    pub(crate) freedom: f64,
}

impl System {
    pub(crate) fn new(basis: Basis, b: Mat<f64>, ridge: f64, pin_ends: bool) -> Self {
        let (points, count) = (b.nrows(), b.ncols());
        let penalty = if ridge > 0.0 {
            differences(basis, ridge.sqrt())
        } else {
            Mat::zeros(0, count)
        };
        let stacked = Mat::from_fn(points + penalty.nrows(), count, |i, j| {
            if i < points {
                b[(i, j)]
            } else {
                penalty[(i - points, j)]
            }
        });
        let (a, pinned) = if pin_ends {
            let ends = Mat::from_fn(stacked.nrows(), 2, |i, end| stacked[(i, end * (count - 1))]);
            (stacked.subcols(1, count - 2).to_owned(), ends)
        } else {
            (stacked, Mat::zeros(0, 0))
        };
        Self {
            b,
            penalty,
            a,
            pinned,
        }
    }

    /// Number of control points before the first that is solved for: 0 or 1.
    pub(crate) fn offset(&self) -> usize {
        usize::from(self.pinned.ncols() > 0)
    }

    /// `P`, from the pseudoinverse `A⁺` of `factors`.
    pub(crate) fn estimator(&self, factors: Option<&Qr>) -> Mat<f64> {
        let (points, count) = (self.b.nrows(), self.b.ncols());
        let offset = self.offset();
        let mut p = Mat::zeros(count, points);
        if let Some(factors) = factors {
            let inverse = factors.pseudoinverse();
            for i in 0..points {
                p.col_as_slice_mut(i)[offset..count - offset]
                    .copy_from_slice(inverse.col_as_slice(i));
            }
            if offset > 0 {
                // Subtracts what the pinned ends explain.
                let explained = product(inverse.as_ref(), self.pinned.as_ref());
                for j in 0..count - 2 {
                    p[(j + 1, 0)] -= explained[(j, 0)];
                    p[(j + 1, points - 1)] -= explained[(j, 1)];
                }
            }
        }
        if offset > 0 {
            p[(0, 0)] = 1.0;
            p[(count - 1, points - 1)] = 1.0;
        }
        p
    }
}

impl Estimator {
    pub(crate) fn new(p: Mat<f64>, b: &Mat<f64>, exact: bool) -> Self {
        let covariance = product(p.as_ref(), p.transpose());
        let (points, count) = (b.nrows(), b.ncols());
        let freedom = if exact {
            (points - count) as f64
        } else {
            // ‖I − BP‖² = N − 2 tr(PB) + tr(PPᵀ BᵀB).
            let (hat, gram) = (
                product(p.as_ref(), b.as_ref()),
                product(b.transpose(), b.as_ref()),
            );
            let mut freedom = points as f64;
            for i in 0..count {
                freedom -= 2.0 * hat[(i, i)];
                for j in 0..count {
                    freedom += covariance[(i, j)] * gram[(j, i)];
                }
            }
            // Rounding may leave a tiny number instead of 0.
            if freedom < 1e-6 { 0.0 } else { freedom }
        };
        Self {
            p,
            covariance,
            freedom,
        }
    }
}

/// `P` of the bases that are not regressions: points of the centerline itself, and the mean of all
/// points.
pub(crate) fn selection(basis: Basis, points: usize) -> Option<Mat<f64>> {
    match basis {
        Basis::FeaturePoints { count } => {
            let mut p = Mat::zeros(count, points);
            for j in 0..count {
                let place = (j * (points - 1)) as f64 / (count - 1) as f64;
                let before = (place as usize).min(points - 1);
                let share = place - before as f64;
                p[(j, before)] = 1.0 - share;
                if share > 0.0 {
                    p[(j, before + 1)] = share;
                }
            }
            Some(p)
        }
        Basis::CenterOfMass => Some(Mat::from_fn(1, points, |_, _| 1.0 / points as f64)),
        _ => None,
    }
}

/// The ridge's rows: second differences of the control points, or a Fourier series' coefficients
/// times the square of their harmonic.
fn differences(basis: Basis, root: f64) -> Mat<f64> {
    let count = basis.control_points();
    if let Basis::Fourier { .. } = basis {
        return Mat::from_fn(count - 1, count, |i, j| {
            let harmonic = (j.div_ceil(2)) as f64;
            if j == i + 1 {
                root * harmonic * harmonic
            } else {
                0.0
            }
        });
    }
    Mat::from_fn(count.saturating_sub(2), count, |i, j| {
        match j.checked_sub(i) {
            Some(0 | 2) => root,
            Some(1) => -2.0 * root,
            _ => 0.0,
        }
    })
}
