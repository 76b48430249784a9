//! Fit as a process: centerlines in, descriptors out.

use lariat_wire::{CENTERLINES, DESCRIPTORS, Descriptors, Writer, now_ns};

use super::status::{Sent, Word};
use super::{Inbox, Station, Supervision};
use crate::pipeline::CurveFitter;
use crate::settings::{Settings, Stage};

/// Fits until a signal comes.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    let mut station = Station::open(settings, Stage::Fit, supervision)?;
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
    while let Some((message, started_ns)) = centerlines.receive(&station.stop)? {
        let mut slot = descriptors.slot()?;
        slot.trace = message.trace;
        slot.trace.fit_started_ns = started_ns;
        curves.answer(&message, &mut slot);
        drop(message);
        sent.count += 1;
        sent.last_sequence = slot.trace.sequence;
        slot.trace.fitted = sent.count;
        slot.trace.fitted_ns = now_ns();
        slot.send()?;
    }
    station.status.say(Word::Sent(sent));
    Ok(())
}
