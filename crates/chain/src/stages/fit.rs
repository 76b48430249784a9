//! Fit as a process: centerlines in, descriptors out.

use std::panic::resume_unwind;

use lariat_wire::{CENTERLINES, DESCRIPTORS, Descriptors, Writer, now_ns};

use super::heirloom::Progress;
use super::status::Word;
use super::{Inbox, Station, Supervision};
use crate::calibrated::Calibrated;
use crate::pipeline::CurveFitter;
use crate::settings::{Settings, Stage};

/// Fits until a signal comes.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    let mut station = Station::open(settings, Stage::Fit, supervision)?;
    // Its tables take 8 ms, in which the channels are opened.
    let made = settings.clone();
    let curves = std::thread::spawn(move || CurveFitter::new(&made));
    let mut calibrated = Calibrated::load(&settings.camera)?;
    let changes = station.listen(settings, move |before, now| {
        // The files that `[camera]` names may be others under the same names.
        let calibrated_now = Calibrated::load(&now.camera)?;
        let is_ours = before.fit != now.fit || calibrated != calibrated_now;
        let made = is_ours.then(|| CurveFitter::new(now)).transpose()?;
        calibrated = calibrated_now;
        Ok(made)
    })?;
    let mut centerlines = Inbox::open(&station, &CENTERLINES, |seen| seen.trace.extracted)?;
    let descriptors = Writer::<Descriptors>::create(
        &station.domain,
        &station.rig,
        &DESCRIPTORS,
        &station.delivery,
    )?;
    let Progress {
        restarts, mut sent, ..
    } = station.heirloom.progress();
    let mut curves = curves.join().unwrap_or_else(|cause| resume_unwind(cause))?;
    station.ready()?;
    while let Some((message, started_ns)) = centerlines.receive(&station.stop)? {
        if let Some(changed) = station.change(&changes) {
            curves = changed;
        }
        let mut slot = descriptors.slot()?;
        slot.trace = message.trace;
        slot.trace.fit_started_ns = started_ns;
        slot.trace.settings = station.version;
        slot.trace.set_restarts(2, restarts);
        curves.answer(&message, &mut slot);
        drop(message);
        sent.count += 1;
        sent.last_sequence = slot.trace.sequence;
        slot.trace.fitted = sent.count;
        slot.trace.fitted_ns = now_ns();
        station.heirloom.note(sent, slot.trace.extracted);
        slot.send()?;
    }
    station.status.say(Word::Sent(sent));
    Ok(())
}
