//! Fits descriptors to the centerlines of a frame.

mod filters;
mod place;
mod ropes;
mod space;
mod steady;

use crate::calibrated::Calibrated;
use crate::settings::{self, Settings};
use anyhow::Result;
use filters::Filters;
use lariat_camera::Mapping;
use lariat_fit::{Fit, Judged, Line, Prediction};
use lariat_wire::{
    Basis, CenterlinePoints, Centerlines, Curve, Descriptor, Descriptors, FitQuality,
    MAX_CONTROL_POINTS, MAX_POINTS, Status, Unit,
};
use place::Placer;
use steady::{Rope, RopeFitter};

pub use space::{Companion, SpaceFitter};

use super::Warned;

/// Fits curves to the centerlines of successive frames. Holds the fitters of open and closed
/// curves, the mapping to the curves' unit, and the filter of each rope.
pub struct CurveFitter {
    settings: settings::Fit,
    placer: Option<Placer>,
    fitter: RopeFitter,
    filters: Option<Filters>,
    points: Box<[[f64; 2]; MAX_POINTS]>,
    hidden: Box<[bool; MAX_POINTS]>,
    weights: Box<[f64; MAX_POINTS]>,
    unfitted: Warned,
    coarse: Warned,
}

impl CurveFitter {
    /// Precomputes the fit for the number of points in the settings, and reads the calibration that
    /// they name.
    pub fn new(settings: &Settings) -> Result<Self> {
        let calibrated = Calibrated::load(&settings.camera)?;
        if let Some(notice) = calibrated.as_ref().and_then(Calibrated::notice) {
            tracing::warn!("{notice}");
        }
        let mut fitter = Self {
            placer: calibrated.map(Placer::new),
            fitter: RopeFitter::new(&settings.fit, settings.extract.points)?,
            settings: settings.fit.clone(),
            filters: None,
            points: Box::new([[0.0; 2]; MAX_POINTS]),
            hidden: Box::new([false; MAX_POINTS]),
            weights: Box::new([1.0; MAX_POINTS]),
            unfitted: Warned::default(),
            coarse: Warned::default(),
        };
        fitter.make_filters()?;
        // Prepare for the most likely frame size. An error for another size is reported with its
        // first frame.
        let _ = fitter.turn_to(settings.capture.likely_size());
        Ok(fitter)
    }

    /// Returns the unit of descriptors.
    pub fn unit(&self) -> Unit {
        self.placer.as_ref().map_or(Unit::Pixel, Placer::unit)
    }

    /// Prepares for frames of this size.
    ///
    /// # Errors
    /// Returns an error if the calibration is for another image size.
    pub fn turn_to(&mut self, size: [u32; 2]) -> Result<()> {
        if let Some(placer) = &mut self.placer
            && placer.turn_to(size)?
        {
            self.make_filters()?;
        }
        Ok(())
    }

    /// Forgets all ropes, because the next frame shows others.
    pub fn forget(&mut self) {
        self.fitter.forget();
        if let Some(filters) = &mut self.filters {
            filters.forget();
        }
    }

    /// Returns the mapping from pixels to the curves' unit for the current frame size. Returns
    /// `None` if curves stay in image pixels.
    pub fn mapping(&self) -> Option<&Mapping> {
        self.placer.as_ref().and_then(Placer::mapping)
    }

    fn make_filters(&mut self) -> Result<()> {
        if self.settings.filter {
            let unit_per_px = self.placer.as_ref().and_then(Placer::unit_per_px);
            let fitters = [&self.fitter.open, &self.fitter.closed];
            self.filters = Some(Filters::new(
                &self.settings,
                fitters,
                unit_per_px.unwrap_or(1.0),
            )?);
        }
        Ok(())
    }

    /// Repeats the precomputation for another number of points. This happens if extract was started
    /// with other settings, because extract's number of points applies.
    fn recount(&mut self, count: usize) -> Result<()> {
        self.fitter = RopeFitter::new(&self.settings, count)?;
        self.make_filters()
    }

    /// Writes the descriptors of a frame's curves into a message. The message's trace is left
    /// unchanged. A curve that cannot be fitted is left out. Warns of the first such curve, and of
    /// everything else that a user or a control loop should know.
    pub fn answer(&mut self, seen: &Centerlines, message: &mut Descriptors) {
        (message.width, message.height, message.count) = (seen.width, seen.height, 0);
        message.unit = self.unit() as u32;
        // A frame without an image keeps the previous frame size.
        if seen.width > 0
            && let Err(cause) = self.turn_to([seen.width, seen.height])
        {
            self.unfitted.once(&cause);
            return;
        }
        let mut count = 0;
        for curve in seen.curves() {
            let descriptor = &mut message.curves[count];
            let described = check_points(seen, curve)
                .and_then(|()| self.describe(curve, seen.trace.exposed_ns, descriptor));
            match described {
                Ok(judged) => {
                    self.tell(judged, descriptor);
                    self.write_points(curve, &mut message.centerlines[count]);
                    count += 1;
                }
                Err(cause) => self.unfitted.once(&cause),
            }
        }
        message.count = count as u32;
    }

    /// Fits a descriptor to one curve of an image exposed at `exposed_ns`.
    ///
    /// # Errors
    /// Returns an error if the curve cannot be fitted or does not lie on the plane.
    pub fn describe(
        &mut self,
        curve: &Curve,
        exposed_ns: u64,
        descriptor: &mut Descriptor,
    ) -> Result<Judged> {
        let count = curve.points().len();
        if count != self.fitter.points() {
            self.recount(count)?;
        }
        match &mut self.placer {
            Some(placer) => self.points[..count].copy_from_slice(placer.place(curve)?),
            None => {
                for (to, from) in self.points.iter_mut().zip(curve.points()) {
                    *to = from.map(f64::from);
                }
            }
        }
        let judged = self.fit(curve, exposed_ns)?;
        let fitter = self.fitter.fitter(curve.closed != 0);
        write_curve(fitter.last(), descriptor);
        write_rope(curve, descriptor);
        if let Some(placer) = &mut self.placer {
            placer.describe(fitter, descriptor);
        }
        descriptor.fit = match judged.is_good {
            true => FitQuality::Good,
            false => FitQuality::Coarse,
        } as u32;
        if let Some(filters) = &mut self.filters
            && descriptor.status() != Some(Status::Lost)
            && let Some(now) = filters.take_in(exposed_ns, descriptor.track, fitter)
        {
            write_filtered(now, descriptor);
        }
        Ok(judged)
    }

    /// Returns the unfiltered fit of this curve, which must be the last one described.
    pub fn last_fit(&mut self, curve: &Curve) -> &Fit {
        self.fitter.fitter(curve.closed != 0).last()
    }

    /// Writes the points to which this curve, the last one described, was fitted.
    fn write_points(&self, curve: &Curve, to: &mut CenterlinePoints) {
        let count = curve.points().len();
        (to.count, to.closed) = (count as u32, curve.closed);
        let Some(placer) = &self.placer else {
            to.hidden = curve.hidden;
            to.points[..count].copy_from_slice(curve.points());
            to.widths[..count].copy_from_slice(curve.widths_px());
            return;
        };
        to.set_hidden((0..count).map(|k| placer.is_hidden(curve, k)));
        for (k, point) in self.points[..count].iter().enumerate() {
            to.points[k] = point.map(|c| c as f32);
            to.widths[k] = placer.width_at(k) as f32;
        }
    }

    /// Warns the user or a control loop of each change of size, and once of a curve that does not
    /// fit.
    fn tell(&mut self, judged: Judged, descriptor: &Descriptor) {
        let Descriptor {
            track, count, max, ..
        } = *descriptor;
        if judged.is_resized {
            tracing::warn!(
                "rope {track}: its curve has not fitted for a second, and has {count} control points from now on"
            );
        }
        if judged.is_hopeless {
            let (rms, worst) = (descriptor.rms / descriptor.width, max / descriptor.width);
            let sentence = self.settings.coarse(rms, worst, count as usize);
            self.coarse
                .once(&anyhow::anyhow!("rope {track}: {sentence}"));
        }
    }

    fn fit(&mut self, curve: &Curve, exposed_ns: u64) -> Result<Judged> {
        let count = self.fitter.points();
        let is_partial = curve.status() == Some(Status::Partial);
        let has_hidden = curve.hidden.iter().any(|&word| word != 0);
        let seen = if is_partial || has_hidden { count } else { 0 };
        for (i, hidden) in self.hidden[..seen].iter_mut().enumerate() {
            *hidden = match &self.placer {
                Some(placer) => placer.is_hidden(curve, i),
                None => curve.is_hidden(i),
            };
            self.weights[i] = f64::from(!*hidden);
        }
        let (width, unit_per_px) = match &self.placer {
            Some(placer) => (placer.width, placer.unit_per_px_along(curve)),
            None => (curve.width_px.into(), 1.0),
        };
        let rope = Rope {
            track: curve.track,
            closed: curve.closed != 0,
            width,
            unit_per_px,
            noise: 0.0,
            // A lost rope is shown as it was when last seen.
            seen_ns: exposed_ns.saturating_sub(curve.age_ns),
        };
        let line = Line {
            points: &self.points[..count],
            weights: (is_partial && self.settings.robust).then_some(&self.weights[..count]),
            hidden: &self.hidden[..seen],
        };
        Ok(self.fitter.fit(rope, &line)?)
    }
}

/// Checks that a curve has as many points as the first curve of its frame. Extract sends no others,
/// and the precomputation for each number of points takes milliseconds.
///
/// # Errors
/// Returns an error if the numbers differ.
fn check_points(seen: &Centerlines, curve: &Curve) -> Result<()> {
    let first = seen
        .curves()
        .first()
        .map_or(0, |first| first.points().len());
    if curve.points().len() != first {
        anyhow::bail!(
            "the curves of a frame have different numbers of points: use the same release for all stages"
        );
    }
    Ok(())
}

/// Replaces the control points by the filtered ones.
fn write_filtered(now: &Prediction<2>, descriptor: &mut Descriptor) {
    let count = now.control_points.len();
    descriptor.filtered = 1;
    descriptor.control_points[..count].copy_from_slice(&now.control_points);
    descriptor.velocities[..count].copy_from_slice(&now.velocities_px_s);
    let variances = now.covariance_px2.iter().step_by(count + 1);
    // The filter uses the same covariance for both axes.
    for (to, &variance) in descriptor.covariances.iter_mut().zip(variances) {
        *to = [variance, 0.0, variance];
    }
}

/// Converts a basis to the type of messages.
fn basis(basis: lariat_fit::Basis) -> Basis {
    match basis {
        lariat_fit::Basis::BSpline { .. } => Basis::BSpline,
        lariat_fit::Basis::RationalBezier { .. } => Basis::RationalBezier,
        lariat_fit::Basis::Fourier { .. } => Basis::Fourier,
        lariat_fit::Basis::FeaturePoints { .. } => Basis::FeaturePoints,
        lariat_fit::Basis::CenterOfMass => Basis::CenterOfMass,
        lariat_fit::Basis::Bezier { .. } => Basis::Bezier,
    }
}

/// Writes the fitted curve.
fn write_curve(fit: &Fit, descriptor: &mut Descriptor) {
    let count = fit.control_points.len().min(MAX_CONTROL_POINTS);
    descriptor.basis = basis(fit.basis) as u32;
    descriptor.degree = fit.basis.order() as u32;
    descriptor.count = count as u32;
    descriptor.rms = fit.rms_px;
    descriptor.max = fit.max_px;
    descriptor.residual_variance = fit.residual_variance;
    descriptor.condition = fit.condition;
    descriptor.filtered = 0;
    descriptor.control_points[..count].copy_from_slice(&fit.control_points[..count]);
    match fit.weights.get(..count) {
        Some(weights) => descriptor.weights[..count].copy_from_slice(weights),
        None => descriptor.weights[..count].fill(1.0),
    }
    for (j, covariance) in descriptor.covariances[..count].iter_mut().enumerate() {
        let variance = fit.residual_variance * fit.covariance_factor[(j, j)];
        *covariance = [variance, 0.0, variance];
    }
    descriptor.velocities[..count].fill([0.0; 2]);
    if let lariat_fit::Basis::BSpline { degree, .. } = fit.basis {
        let inner = &fit.knots[degree + 1..count];
        descriptor.knots[..inner.len()].copy_from_slice(inner);
    }
}

/// Copies the properties of the rope itself.
fn write_rope(curve: &Curve, descriptor: &mut Descriptor) {
    let count = curve.points().len();
    descriptor.track = curve.track;
    descriptor.status = curve.status;
    descriptor.samples = count as u32;
    descriptor.closed = curve.closed;
    descriptor.border = curve.border;
    descriptor.length = curve.length_px.into();
    descriptor.width = curve.width_px.into();
    descriptor.confidence = curve.confidence;
    descriptor.age_ns = curve.age_ns;
    descriptor.hidden = (0..count).filter(|&i| curve.is_hidden(i)).count() as u32;
}

#[cfg(test)]
mod tests;
