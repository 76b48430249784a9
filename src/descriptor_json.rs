//! A descriptor as the JSON object that `lariat trace` and `lariat fit` print.

use lariat_fit::{Fit, Fitter};
use serde::Serialize;

/// The keys are part of what users build on.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Descriptor {
    pub(crate) basis: String,
    pub(crate) order: usize,
    pub(crate) control_points: Vec<[f64; 2]>,
    pub(crate) rms_px: f64,
    pub(crate) max_px: f64,
    pub(crate) condition: f64,
}

impl Descriptor {
    /// The fitter's descriptor of these points, with every digit.
    ///
    /// # Errors
    /// As [`Fitter::fit`].
    pub(crate) fn of(
        fitter: &mut Fitter,
        points: &[[f64; 2]],
    ) -> Result<Self, lariat_fit::FitError> {
        let Fit {
            control_points,
            rms_px,
            max_px,
            ..
        } = fitter.fit(points)?;
        let (control_points, rms_px, max_px) = (control_points.clone(), *rms_px, *max_px);
        Ok(Self {
            basis: fitter.basis().to_string(),
            order: fitter.options().order,
            control_points,
            rms_px,
            max_px,
            condition: fitter.condition(),
        })
    }

    /// As a person wants to read it: to a thousandth of a pixel.
    pub(crate) fn rounded(mut self) -> Self {
        self.control_points = self
            .control_points
            .iter()
            .map(|p| p.map(thousandths))
            .collect();
        self.rms_px = thousandths(self.rms_px);
        self.max_px = thousandths(self.max_px);
        self.condition = thousandths(self.condition);
        self
    }
}

/// `x` with three decimals, so that it is printed with no more.
pub(crate) fn thousandths(x: f64) -> f64 {
    // Adding 0 makes a 0 of −0.
    (x * 1e3).round() / 1e3 + 0.0
}
