//! The control points in time: a Kalman filter for each rope.

use super::ropes::Ropes;
use crate::settings;
use lariat_fit::{Filter, FilterOptions, Fitter, Noise, Point, Prediction, Weights};
use lariat_wire::MAX_CONTROL_POINTS;

pub(super) struct Filters<const D: usize = 2> {
    ropes: Ropes<Filter<D>>,
    /// Whether the points of each fit all count the same, so that its residual variance says all of its noise.
    even: bool,
    covariance: Vec<f64>,
}

impl<const D: usize> Filters<D>
where
    [f64; D]: Point<D>,
{
    /// `unit_per_px`: how long a pixel is in the unit of the control points. What the filter is told in pixels is the same
    /// motion then.
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

    /// The ropes that come are others.
    pub(super) fn forget(&mut self) {
        self.ropes.forget();
    }

    /// The rope of this track as its filter has it, once that has taken in the last fit; `None` if it has nothing to say.
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
        // A moment that is not later, as of a source that began again: the rope is where it was measured.
        let step = filter.update(exposed_ns, &space, &fit.control_points, noise);
        if step.is_err() {
            filter.forget();
            return None;
        }
        filter.predict(exposed_ns).ok()
    }
}
