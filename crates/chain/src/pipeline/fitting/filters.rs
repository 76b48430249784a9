//! Filters control points over time, with a Kalman filter for each rope.

use super::ropes::Ropes;
use crate::settings;
use lariat_fit::{Filter, FilterOptions, Fitter, Noise, Point, Prediction, Weights};
use lariat_wire::MAX_CONTROL_POINTS;

pub(super) struct Filters<const D: usize = 2> {
    ropes: Ropes<Filter<D>>,
    /// True if all points have the same weight in each fit, so that the residual variance describes
    /// all noise of the fit.
    even: bool,
    covariance: Vec<f64>,
}

impl<const D: usize> Filters<D>
where
    [f64; D]: Point<D>,
{
    /// Creates the filters. `unit_per_px` is the length of a pixel in the unit of the control
    /// points. It converts the filter's options, which are in pixels.
    pub(super) fn new(
        settings: &settings::Fit,
        fitters: [&Fitter<D>; 2],
        unit_per_px: f64,
    ) -> anyhow::Result<Self> {
        let defaults = FilterOptions::default();
        let options = defaults
            .acceleration_px_s2(unit_per_px * settings.acceleration_px_s2)
            .speed_px_s(unit_per_px * defaults.speed_px_s);
        let [open, closed] = fitters;
        let most = [open, closed].map(|fitter| fitter.options().basis.control_points());
        let plain = open.options();
        Ok(Self {
            ropes: Ropes::new(|_| Filter::new(most[0].max(most[1]), options))?,
            even: plain.weights == Weights::Even && plain.ridge == 0.0 && !plain.pin_ends,
            covariance: Vec::with_capacity(MAX_CONTROL_POINTS * MAX_CONTROL_POINTS),
        })
    }

    /// Forgets all ropes, because the next frame shows others.
    pub(super) fn forget(&mut self) {
        self.ropes.forget();
    }

    /// Updates the filter of a track with the last fit, and returns the filtered rope. Returns
    /// `None` if the filter cannot predict.
    pub(super) fn take_in(
        &mut self,
        exposed_ns: u64,
        track: u32,
        fitter: &mut Fitter<D>,
    ) -> Option<&Prediction<D>> {
        let space = fitter.last_space().ok()?;
        let fit = fitter.last();
        let variance_px2 = fit.residual_variance;
        let noise = if self.even {
            Noise::Even { variance_px2 }
        } else {
            self.covariance.clear();
            for row in fit.covariance_factor.row_iter() {
                self.covariance.extend(row.iter().map(|c| variance_px2 * c));
            }
            Noise::Covariance(&self.covariance)
        };
        let filter = self.ropes.of_track(track, exposed_ns, Filter::forget);
        // The time does not increase if a source starts again. The rope is then where it was
        // measured.
        let step = filter.update(exposed_ns, &space, &fit.control_points, noise);
        if step.is_err() {
            filter.forget();
            return None;
        }
        filter.predict(exposed_ns).ok()
    }
}
