//! The control points in time: a Kalman filter for each rope.

use crate::settings;
use lariat_fit::{CurveSpace, Filter, FilterOptions, Fit, Fitter, Noise, Weights};
use lariat_wire::{Descriptor, MAX_CONTROL_POINTS, MAX_CURVES, Status};

pub(super) struct Filters {
    ropes: [Rope; MAX_CURVES],
    /// Of open and of closed curves.
    spaces: [CurveSpace; 2],
    /// Whether the points of each fit all count the same, so that its residual variance says all of its noise.
    even: bool,
    covariance: Vec<f64>,
}

/// A rope's filter, and when it was last asked for.
struct Rope {
    track: Option<u32>,
    asked_ns: u64,
    filter: Filter<2>,
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
        let mut ropes = Vec::with_capacity(MAX_CURVES);
        for _ in 0..MAX_CURVES {
            ropes.push(Rope {
                track: None,
                asked_ns: 0,
                filter: Filter::new(most[0].max(most[1]), options)?,
            });
        }
        let plain = open.options();
        Ok(Self {
            ropes: ropes
                .try_into()
                .map_err(|_| anyhow::anyhow!("as many filters as curves"))?,
            spaces: [open.curve_space()?, closed.curve_space()?],
            even: plain.weights == Weights::Even && plain.ridge == 0.0 && !plain.pin_ends,
            covariance: Vec::with_capacity(MAX_CONTROL_POINTS * MAX_CONTROL_POINTS),
        })
    }

    /// Replaces a descriptor's control points by the filtered ones, if its rope is seen.
    pub(super) fn apply(&mut self, exposed_ns: u64, fit: &Fit, descriptor: &mut Descriptor) {
        if descriptor.status() == Some(Status::Lost) {
            return;
        }
        let space = &self.spaces[usize::from(descriptor.closed != 0)];
        let variance_px2 = fit.residual_variance;
        let noise = if self.even {
            Noise::Even { variance_px2 }
        } else {
            self.covariance.clear();
            let factor = fit.covariance_factor.iter();
            self.covariance.extend(factor.map(|c| variance_px2 * c));
            Noise::Covariance(&self.covariance)
        };
        let rope = of_track(&mut self.ropes, descriptor.track);
        rope.asked_ns = exposed_ns;
        // A moment that is not later, as of a source that began anew: the rope is where it was measured.
        let step = rope
            .filter
            .update(exposed_ns, space, &fit.control_points, noise);
        if step.is_err() {
            rope.filter.forget();
            return;
        }
        let Ok(now) = rope.filter.predict(exposed_ns) else {
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

/// The filter of this rope: its own, or that of the rope that was asked for least recently, made to forget it.
fn of_track(ropes: &mut [Rope; MAX_CURVES], track: u32) -> &mut Rope {
    let known = ropes.iter().position(|rope| rope.track == Some(track));
    let index = known.unwrap_or_else(|| {
        let ages = ropes.iter().map(|rope| rope.asked_ns).enumerate();
        let oldest = ages.min_by_key(|&(_, asked_ns)| asked_ns);
        let index = oldest.map_or(0, |(index, _)| index);
        ropes[index].filter.forget();
        ropes[index].track = Some(track);
        index
    });
    &mut ropes[index]
}
