//! Extract as a process: frames in, centerlines out.

use lariat_wire::{CENTERLINES, Centerlines, FRAMES, Writer, now_ns};

use super::external::External;
use super::masks::Masks;
use super::status::{Sent, Word};
use super::{Came, Inbox, Station, Supervision};
use crate::pipeline::{FrameExtractor, FrameView};
use crate::settings::{Settings, Stage};

/// Extracts until a signal comes.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    let mut station = Station::open(settings, Stage::Extract, supervision)?;
    let mut extractor = FrameExtractor::prepared(settings)?;
    let mut masks = Masks::open(settings, &station)?;
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = &station;
    let mut frames = Inbox::open(&station, &FRAMES, |frame| frame.header().trace.captured)?;
    let centerlines = Writer::<Centerlines>::create(domain, rig, &CENTERLINES, delivery)?;
    let mut external = External::of(settings);
    let mut sent = Sent::default();
    station.ready()?;
    loop {
        let deadline = external.as_ref().and_then(External::deadline);
        let (frame, mut started_ns) = match frames.receive_by(&station.stop, deadline)? {
            Came::Message(frame, now_ns) => (frame, now_ns),
            Came::Nothing if external.as_mut().is_some_and(External::wait_on) => continue,
            Came::Nothing | Came::End => break,
        };
        let header = frame.header();
        if external
            .as_mut()
            .is_some_and(|external| !external.takes(&header.trace, &station.stop))
        {
            break;
        }
        let mask = match &mut masks {
            None => None,
            // Nobody makes a mask of nothing.
            Some(_) if header.is_blank() => None,
            Some(masks) => match masks.of(header, &station.stop)? {
                Some(mask) => {
                    // Waiting for it was no work.
                    started_ns = now_ns();
                    Some(mask)
                }
                // Its mask came too late: the frame is not sent on, and counted.
                None => continue,
            },
        };
        let mut slot = centerlines.slot()?;
        slot.trace = header.trace;
        slot.trace.extract_started_ns = started_ns;
        let mask = mask.map(|mask| FrameView::new(mask.header(), mask));
        extractor.answer(FrameView::new(header, &frame), mask, &mut slot);
        // Read, the frame makes room for another.
        let sequence = header.trace.sequence;
        drop(frame);
        sent.count += 1;
        sent.last_sequence = sequence;
        slot.trace.extracted = sent.count;
        slot.trace.extracted_ns = now_ns();
        slot.send()?;
        if external.as_ref().is_some_and(External::has_all) {
            break;
        }
    }
    if let Some(masks) = masks {
        station.status.say(Word::Late(masks.late()));
    }
    if let Some(external) = external {
        if !station.stop.asked() {
            station.status.say(Word::Done);
        }
        station.status.say(Word::Taken(external.taken()));
    }
    station.status.say(Word::Sent(sent));
    Ok(())
}
