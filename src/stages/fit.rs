//! Fit as a process: centerlines in, descriptors out.

mod filters;
mod place;
mod ropes;
mod steady;

use lariat_fit::{Fit, Judged, Line};
use lariat_wire::{
    Basis, CENTERLINES, CenterlinePoints, Centerlines, Curve, DESCRIPTORS, Descriptor, Descriptors,
    FitQuality, MAX_CONTROL_POINTS, MAX_POINTS, Status, Unit, Writer, now_ns,
};

use super::extract::Warned;
use super::status::Sent;
use super::{Inbox, Seat, Station};
use crate::calibrated::Calibrated;
use crate::settings::{self, Settings};
use filters::Filters;
use place::Placer;
pub(crate) use steady::{Rope, RopeFitter};

/// Fits until a signal comes.
pub(crate) fn run(settings: &Settings, seat: Seat) -> anyhow::Result<()> {
    let mut station = Station::open(settings, "fit", seat)?;
    let mut curves = CurveFitter::new(settings)?;
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = &station;
    let mut centerlines = Inbox::open(&station, &CENTERLINES, |seen| seen.trace.extracted)?;
    let descriptors = Writer::<Descriptors>::create(domain, rig, &DESCRIPTORS, delivery)?;
    station.ready()?;
    let mut sent = Sent::default();
    let mut unfitted = Warned::default();
    while let Some((message, started_ns)) = centerlines.receive(&station.stop)? {
        let mut slot = descriptors.slot()?;
        slot.trace = message.trace;
        slot.trace.fit_started_ns = started_ns;
        fill(&mut slot, &message, &mut curves, &mut unfitted);
        drop(message);
        sent.count += 1;
        sent.last_sequence = slot.trace.sequence;
        slot.trace.fitted = sent.count;
        slot.trace.fitted_ns = now_ns();
        slot.send()?;
    }
    station.status.sent(sent);
    Ok(())
}

/// Writes the descriptors of all curves into a message. A curve that cannot be fitted is left out.
pub(crate) fn fill(
    message: &mut Descriptors,
    seen: &Centerlines,
    curves: &mut CurveFitter,
    unfitted: &mut Warned,
) {
    (message.width, message.height, message.count) = (seen.width, seen.height, 0);
    message.unit = curves.unit() as u32;
    // Without an image the camera is the one of before.
    if seen.width > 0
        && let Err(cause) = curves.turn_to([seen.width, seen.height])
    {
        unfitted.once(&cause);
        return;
    }
    let mut count = 0;
    for curve in seen.curves() {
        let descriptor = &mut message.curves[count];
        match curves.describe(curve, seen.trace.exposed_ns, descriptor) {
            Ok(()) => {
                curves.write_points(curve, &mut message.centerlines[count]);
                count += 1;
            }
            Err(cause) => unfitted.once(&cause),
        }
    }
    message.count = count as u32;
}

/// Fitters of open and closed curves for whatever number of points the centerlines have, the way to where those lie, and
/// the filters of their ropes.
pub(crate) struct CurveFitter {
    settings: settings::Fit,
    placer: Option<Placer>,
    fitter: RopeFitter,
    filters: Option<Filters>,
    points: Box<[[f64; 2]; MAX_POINTS]>,
    hidden: Box<[bool; MAX_POINTS]>,
    weights: Box<[f64; MAX_POINTS]>,
    coarse: Warned,
}

impl CurveFitter {
    /// Precomputes for the settings' number of points, and reads the calibration they name.
    pub(crate) fn new(settings: &Settings) -> anyhow::Result<Self> {
        let mut fitter = Self {
            placer: Calibrated::load(&settings.camera)?.map(Placer::new),
            fitter: RopeFitter::new(&settings.fit, settings.extract.points)?,
            settings: settings.fit.clone(),
            filters: None,
            points: Box::new([[0.0; 2]; MAX_POINTS]),
            hidden: Box::new([false; MAX_POINTS]),
            weights: Box::new([1.0; MAX_POINTS]),
            coarse: Warned::default(),
        };
        fitter.make_filters()?;
        // Most likely the size that is coming; another is told of with its first frame.
        let _ = fitter.turn_to(settings.capture.likely_size());
        Ok(fitter)
    }

    /// What descriptors come in.
    pub(crate) fn unit(&self) -> Unit {
        self.placer.as_ref().map_or(Unit::Pixel, Placer::unit)
    }

    /// Turns to frames of this size.
    ///
    /// # Errors
    /// The calibration is for other images.
    pub(crate) fn turn_to(&mut self, size: [u32; 2]) -> anyhow::Result<()> {
        if let Some(placer) = &mut self.placer
            && placer.turn_to(size)?
        {
            self.make_filters()?;
        }
        Ok(())
    }

    fn make_filters(&mut self) -> anyhow::Result<()> {
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

    /// Extract was started with another number of points: its word counts, and the algebra is done anew, once.
    fn count_anew(&mut self, count: usize) -> anyhow::Result<()> {
        self.fitter = RopeFitter::new(&self.settings, count)?;
        self.make_filters()
    }

    /// Describes one curve, of an image taken at `exposed_ns`.
    pub(crate) fn describe(
        &mut self,
        curve: &Curve,
        exposed_ns: u64,
        descriptor: &mut Descriptor,
    ) -> anyhow::Result<()> {
        let count = curve.points().len();
        if count != self.fitter.points() {
            self.count_anew(count)?;
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
        self.tell(judged, descriptor);
        if let Some(filters) = &mut self.filters {
            let fitter = self.fitter.fitter(curve.closed != 0);
            filters.apply(exposed_ns, fitter, descriptor);
        }
        Ok(())
    }

    /// Writes the points that this curve, the last that was described, was fitted to.
    pub(crate) fn write_points(&self, curve: &Curve, to: &mut CenterlinePoints) {
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

    /// Says what the user or a control loop should know of: each change of a size, and once that a curve does not fit.
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

    fn fit(&mut self, curve: &Curve, exposed_ns: u64) -> anyhow::Result<Judged> {
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
            // A lost rope is where it was then.
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

/// Writes the fitted curve.
fn write_curve(fit: &Fit, descriptor: &mut Descriptor) {
    let count = fit.control_points.len().min(MAX_CONTROL_POINTS);
    descriptor.basis = match fit.basis {
        lariat_fit::Basis::BSpline { .. } => Basis::BSpline,
        lariat_fit::Basis::RationalBezier { .. } => Basis::RationalBezier,
        lariat_fit::Basis::Fourier { .. } => Basis::Fourier,
        lariat_fit::Basis::FeaturePoints { .. } => Basis::FeaturePoints,
        lariat_fit::Basis::CenterOfMass => Basis::CenterOfMass,
        lariat_fit::Basis::Bezier { .. } => Basis::Bezier,
    } as u32;
    descriptor.order = fit.basis.order() as u32;
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
        let variance = fit.residual_variance * fit.covariance_factor[j * (count + 1)];
        *covariance = [variance, 0.0, variance];
    }
    descriptor.velocities[..count].fill([0.0; 2]);
    if let lariat_fit::Basis::BSpline { degree, .. } = fit.basis {
        let inner = &fit.knots[degree + 1..count];
        descriptor.knots[..inner.len()].copy_from_slice(inner);
    }
}

/// Carries over what is known of the rope itself.
fn write_rope(curve: &Curve, descriptor: &mut Descriptor) {
    let count = curve.points().len();
    descriptor.track = curve.track;
    descriptor.status = curve.status;
    descriptor.samples = curve.count;
    descriptor.closed = curve.closed;
    descriptor.border = curve.border;
    descriptor.length = curve.length_px.into();
    descriptor.width = curve.width_px.into();
    descriptor.age_ns = curve.age_ns;
    descriptor.hidden = (0..count).filter(|&i| curve.is_hidden(i)).count() as u32;
}

#[cfg(test)]
mod tests;
