//! A descriptor as the JSON object that `lariat trace` and `lariat fit` print.

use lariat_fit::{Basis, Curve, Fit};
use lariat_wire::FitQuality;
use serde::Serialize;

/// Users rely on these keys.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Descriptor {
    pub(crate) basis: &'static str,
    pub(crate) degree: usize,
    pub(crate) control_points: Vec<[f64; 2]>,
    /// Weights of the control points; only for rational curves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) weights: Vec<f64>,
    /// Full knot vector, from 0 to 1; only for B-splines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) knots: Vec<f64>,
    /// In the points' unit, as are all lengths here.
    pub(crate) rms: f64,
    pub(crate) max: f64,
    /// σ²: variance of one coordinate.
    pub(crate) residual_variance: f64,
    /// Standard deviation of the least certain control point, in units of σ.
    pub(crate) noise_gain: f64,
    pub(crate) condition: f64,
    /// Distance between the curve and its points.
    #[serde(flatten)]
    pub(crate) quality: Option<Quality>,
    /// Unit, and length of the centerline in it; only for points that lariat found itself.
    #[serde(flatten)]
    pub(crate) measure: Option<Measure>,
    #[serde(skip)]
    family: Basis,
}

/// Fit quality, in widths of the rope.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Quality {
    /// `good` or `coarse`.
    pub(crate) fit: &'static str,
    pub(crate) rms_widths: f64,
    pub(crate) worst_widths: f64,
}

impl Quality {
    /// Judges a fit. `width` is in the points' unit.
    pub(crate) fn of(fit: &Fit, is_good: bool, width: f64) -> Self {
        Self {
            fit: if is_good {
                FitQuality::Good.name()
            } else {
                FitQuality::Coarse.name()
            },
            rms_widths: fit.rms_px / width,
            worst_widths: fit.max_px / width,
        }
    }
}

/// A length and its unit.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Measure {
    pub(crate) unit: &'static str,
    pub(crate) length: f64,
}

impl Descriptor {
    /// Converts the fitter's descriptor with full precision.
    pub(crate) fn of(fit: &Fit) -> Self {
        Self {
            basis: fit.basis.name(),
            degree: fit.basis.order(),
            control_points: fit.control_points.clone(),
            weights: fit.weights.clone(),
            knots: fit.knots.clone(),
            rms: fit.rms_px,
            max: fit.max_px,
            residual_variance: fit.residual_variance,
            noise_gain: fit.noise_gain(),
            condition: fit.condition,
            quality: None,
            measure: None,
            family: fit.basis,
        }
    }

    /// Returns the curve, if the descriptor is a valid one.
    pub(crate) fn curve(&self) -> Option<Curve<'_>> {
        Curve::new(
            self.family,
            &self.control_points,
            &self.weights,
            &self.knots,
        )
        .ok()
    }

    /// Rounds to a thousandth of the unit, for people to read.
    pub(crate) fn rounded(mut self) -> Self {
        self.control_points = self
            .control_points
            .iter()
            .map(|p| p.map(thousandths))
            .collect();
        for number in [
            &mut self.rms,
            &mut self.max,
            &mut self.residual_variance,
            &mut self.noise_gain,
            &mut self.condition,
        ] {
            *number = thousandths(*number);
        }
        if let Some(quality) = &mut self.quality {
            quality.rms_widths = thousandths(quality.rms_widths);
            quality.worst_widths = thousandths(quality.worst_widths);
        }
        if let Some(measure) = &mut self.measure {
            measure.length = thousandths(measure.length);
        }
        self
    }
}

/// Rounds `x` to three decimals, so that no more are printed.
pub(crate) fn thousandths(x: f64) -> f64 {
    // Adding 0 turns −0 into 0.
    (x * 1e3).round() / 1e3 + 0.0
}
