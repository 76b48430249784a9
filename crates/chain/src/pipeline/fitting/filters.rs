//! The control points in time: a Kalman filter for each rope.

use super::ropes::Ropes;
use crate::settings;
use lariat_fit::{Filter, FilterOptions, Fitter, Noise, Weights};
use lariat_wire::{Descriptor, MAX_CONTROL_POINTS, Status};

pub(super) struct Filters {
    ropes: Ropes<Filter<2>>,
    /// Whether the points of each fit all count the same, so that its residual variance says all of its noise.
    even: bool,
    covariance: Vec<f64>,
}

impl Filters {
    /// `unit_per_px`: how long a pixel is in the unit of the control points. What the filter is told in pixels is the same
    /// motion then.
    pub(super) fn new(
        settings: &settings::Fit,
        fitters: [&Fitter; 2],
        unit_per_px: f64,
    ) -> anyhow::Result<Self> {
        let defaults = FilterOptions::default();
        let options = FilterOptions {
            acceleration_px_s2: unit_per_px * settings.acceleration_px_s2,
            speed_px_s: unit_per_px * defaults.speed_px_s,
            ..defaults
        };
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

    /// Replaces a descriptor's control points by the filtered ones, if its rope is seen.
    pub(super) fn apply(
        &mut self,
        exposed_ns: u64,
        fitter: &mut Fitter,
        descriptor: &mut Descriptor,
    ) {
        if descriptor.status() == Some(Status::Lost) {
            return;
        }
        let Ok(space) = fitter.last_space() else {
            return;
        };
        let fit = fitter.last();
        let variance_px2 = fit.residual_variance;
        let noise = if self.even {
            Noise::Even { variance_px2 }
        } else {
            self.covariance.clear();
            let factor = fit.covariance_factor.iter();
            self.covariance.extend(factor.map(|c| variance_px2 * c));
            Noise::Covariance(&self.covariance)
        };
        let track = descriptor.track;
        let filter = self.ropes.of_track(track, exposed_ns, Filter::forget);
        // A moment that is not later, as of a source that began anew: the rope is where it was measured.
        let step = filter.update(exposed_ns, &space, &fit.control_points, noise);
        if step.is_err() {
            filter.forget();
            return;
        }
        let Ok(now) = filter.predict(exposed_ns) else {
            return;
        };
        let count = now.control_points.len();
        descriptor.filtered = 1;
        descriptor.control_points[..count].copy_from_slice(&now.control_points);
        descriptor.velocities[..count].copy_from_slice(&now.velocities_px_s);
        let variances = now.covariance_px2.iter().step_by(count + 1);
        // The filter has one covariance for both axes.
        for (to, &variance) in descriptor.covariances.iter_mut().zip(variances) {
            *to = [variance, 0.0, variance];
        }
    }
}
