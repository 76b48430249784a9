//! Fit as a process: centerlines in, descriptors out.

use lariat_fit::Fitter;
use lariat_wire::{
    Basis, CENTERLINES, Centerlines, Curve, DESCRIPTORS, Descriptor, Descriptors,
    MAX_CONTROL_POINTS, MAX_POINTS, Reader, Writer, now_ns,
};

use super::extract::Warned;
use super::status::Sent;
use super::{Backlog, Station, receive};
use crate::settings::Settings;

/// Fits until a signal comes.
pub(crate) fn run(settings: &Settings) -> anyhow::Result<()> {
    let mut station = Station::open(settings)?;
    let mut curves = CurveFitter::new(settings.fit.options(settings.extract.points))?;
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = &station;
    let centerlines = Reader::create(domain, rig, &CENTERLINES, Some(delivery))?;
    let descriptors = Writer::<Descriptors>::create(domain, rig, &DESCRIPTORS, delivery)?;
    station.status.ready();
    let mut sent = Sent::default();
    let mut backlog = Backlog::default();
    let mut unfitted = Warned::default();
    while let Some((message, started_ns)) = receive(
        &centerlines,
        &mut backlog,
        |message| message.trace.extracted,
        &station.stop,
    )? {
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
    (message.width, message.height, message.reserved) = (seen.width, seen.height, 0);
    let mut count = 0;
    for curve in seen.curves() {
        match curves.fit(curve, &mut message.curves[count]) {
            Ok(()) => count += 1,
            Err(cause) => unfitted.once(&cause),
        }
    }
    message.count = count as u32;
}

/// A fitter for whatever number of points the centerlines have.
pub(crate) struct CurveFitter {
    options: lariat_fit::Options,
    fitter: Fitter,
    points: Box<[[f64; 2]; MAX_POINTS]>,
}

impl CurveFitter {
    /// Precomputes for the number of points in `options`.
    pub(crate) fn new(options: lariat_fit::Options) -> anyhow::Result<Self> {
        Ok(Self {
            options,
            fitter: Fitter::new(options)?,
            points: Box::new([[0.0; 2]; MAX_POINTS]),
        })
    }

    /// Fits one curve.
    pub(crate) fn fit(&mut self, curve: &Curve, descriptor: &mut Descriptor) -> anyhow::Result<()> {
        let points = curve.points();
        if points.len() != self.options.points {
            // Extract was started with another number: its word counts, and the algebra is done anew, once.
            let options = lariat_fit::Options {
                points: points.len(),
                ..self.options
            };
            self.fitter = Fitter::new(options)?;
            self.options = options;
        }
        for (to, from) in self.points.iter_mut().zip(points) {
            *to = from.map(f64::from);
        }
        let condition = self.fitter.condition();
        let fit = self.fitter.fit(&self.points[..points.len()])?;
        let count = fit.control_points.len().min(MAX_CONTROL_POINTS);
        descriptor.track = curve.track;
        descriptor.status = curve.status;
        descriptor.basis = Basis::Bezier as u32;
        descriptor.order = self.options.order as u32;
        descriptor.count = count as u32;
        descriptor.samples = curve.count;
        descriptor.closed = curve.closed;
        descriptor.border = curve.border;
        descriptor.rms_px = fit.rms_px;
        descriptor.max_px = fit.max_px;
        descriptor.residual_variance = fit.residual_variance;
        descriptor.condition = condition;
        descriptor.length_px = curve.length_px.into();
        descriptor.width_px = curve.width_px.into();
        descriptor.age_ns = curve.age_ns;
        let hidden = (0..points.len()).filter(|&i| curve.is_hidden(i));
        descriptor.hidden = hidden.count() as u32;
        descriptor.reserved = 0;
        descriptor.control_points[..count].copy_from_slice(&fit.control_points[..count]);
        descriptor.weights[..count].fill(1.0);
        Ok(())
    }
}
