//! Brown–Conrady distortion as in OpenCV's `calib3d`: radial (with a denominator, "rational"),
//! tangential, thin prism, and a tilted sensor.
//!
//! D. C. Brown, *Decentering distortion of lenses*, 1966. The rational and thin-prism terms and the
//! tilt follow OpenCV's documentation of `calibrateCamera`. With r² = x² + y² of the ideal,
//! normalized point:
//!
//! ```text
//! g  = (1 + k₁r² + k₂r⁴ + k₃r⁶) / (1 + k₄r² + k₅r⁴ + k₆r⁶)
//! x' = x g + 2p₁xy + p₂(r² + 2x²) + s₁r² + s₂r⁴
//! y' = y g + p₁(r² + 2y²) + 2p₂xy + s₃r² + s₄r⁴
//! ```
//!
//! followed by the tilt, a projective map. The derivative is symmetric except for the thin prism.

use crate::jacobian::{self, Place};
use crate::projective::{self, Matrix};

/// Coefficients in OpenCV's order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Brown {
    /// k₁ k₂ p₁ p₂ k₃ k₄ k₅ k₆ s₁ s₂ s₃ s₄
    c: [f64; 12],
    /// τₓ τᵧ
    angles: [f64; 2],
    /// The tilt and its inverse, if the sensor is tilted.
    tilt: Option<[Matrix; 2]>,
}

impl Brown {
    /// Takes up to 14 coefficients; missing ones are 0. Returns `None` if the sensor is tilted too
    /// far to see anything.
    pub(crate) fn new(coefficients: &[f64]) -> Option<Self> {
        let at = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
        let angles = [at(12), at(13)];
        let tilt = if angles == [0.0; 2] {
            None
        } else {
            let tilt = tilt(angles);
            // The center must see the front of the image plane.
            (tilt[2][2] > 1e-3).then_some(())?;
            Some([tilt, projective::inverse(&tilt)?])
        };
        Some(Self {
            c: std::array::from_fn(at),
            angles,
            tilt,
        })
    }

    /// Returns the coefficients in the smallest of OpenCV's sets (5, 8, 12 or 14) that contains all
    /// nonzero ones.
    pub(crate) fn coefficients(&self) -> Vec<f64> {
        let all = [&self.c[..], &self.angles].concat();
        let used = all
            .iter()
            .rposition(|&c| c != 0.0)
            .map_or(0, |last| last + 1);
        let enough = [5, 8, 12].into_iter().find(|&set| set >= used);
        all[..enough.unwrap_or(all.len())].to_vec()
    }

    /// Maps an ideal point to its place before the tilt. `None` if the denominator is not positive.
    pub(crate) fn bend(&self, [x, y]: [f64; 2]) -> Option<Place> {
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4] = self.c;
        let r2 = x * x + y * y;
        let over = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let under = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
        let positive = under > 0.0;
        positive.then_some(())?;
        let g = over / under;
        // dg/dr²
        let over_slope = k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2);
        let under_slope = k4 + r2 * (2.0 * k5 + 3.0 * k6 * r2);
        let slope = (over_slope - g * under_slope) / under;
        let [along_x, along_y] = [2.0 * (s1 + 2.0 * s2 * r2), 2.0 * (s3 + 2.0 * s4 * r2)];
        let shared = 2.0 * (x * y * slope + p1 * x + p2 * y);
        Some(Place {
            point: [
                x * g + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + s2 * r2),
                y * g + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + s4 * r2),
            ],
            jacobian: [
                [
                    g + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x + x * along_x,
                    shared + y * along_x,
                ],
                [
                    shared + x * along_y,
                    g + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x + y * along_y,
                ],
            ],
        })
    }

    /// Applies the tilt after the distortion.
    pub(crate) fn tilted(&self, bent: Place) -> Option<Place> {
        let Some([tilt, _]) = &self.tilt else {
            return Some(bent);
        };
        let place = projective::map(tilt, bent.point)?;
        Some(Place {
            point: place.point,
            jacobian: jacobian::product(&place.jacobian, &bent.jacobian),
        })
    }

    /// Removes the tilt from a distorted point.
    pub(crate) fn upright(&self, point: [f64; 2]) -> Option<Place> {
        match &self.tilt {
            None => Some(Place::itself(point)),
            Some([_, back]) => projective::map(back, point),
        }
    }
}

/// OpenCV's projection onto a sensor tilted about x by `tau_x` and then about y by `tau_y`, in
/// radians (`computeTiltProjectionMatrix`; Louhichi et al. 2007).
fn tilt([tau_x, tau_y]: [f64; 2]) -> Matrix {
    let ((sx, cx), (sy, cy)) = (libm::sincos(tau_x), libm::sincos(tau_y));
    let about_x = [[1.0, 0.0, 0.0], [0.0, cx, sx], [0.0, -sx, cx]];
    let about_y = [[cy, 0.0, -sy], [0.0, 1.0, 0.0], [sy, 0.0, cy]];
    let r = projective::product(&about_y, &about_x);
    let onto = [
        [r[2][2], 0.0, -r[0][2]],
        [0.0, r[2][2], -r[1][2]],
        [0.0, 0.0, 1.0],
    ];
    projective::product(&onto, &r)
}
