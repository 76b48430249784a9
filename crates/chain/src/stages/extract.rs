//! The extract process: reads frames and sends centerlines.

use lariat_extract::Mask;
use lariat_wire::{CENTERLINES, Centerlines, FRAMES, MASKS, Writer, now_ns};

use super::companions::{Companions, Words};
use super::external::External;
use super::extract_handover::{self, HandoverWriter};
use super::handover::Progress;
use super::status::Word;
use super::{Inbox, Received, Station, Supervision};
use crate::pipeline::{FrameExtractor, FrameView};
use crate::settings::{Settings, Stage};

/// Extracts until a signal arrives.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    let mut station = Station::open(settings, Stage::Extract, supervision)?;
    let changes = station.listen(settings, |before, now| {
        let is_ours = before.extract != now.extract;
        is_ours.then(|| FrameExtractor::prepared(now)).transpose()
    })?;
    let mut extractor = FrameExtractor::prepared(settings)?;
    if let Some(past) = extract_handover::read(&station.handover) {
        extractor.go_on_after(past.past, &past.last);
    }
    let mut masks = masks(settings, &station)?;
    let mut frames = Inbox::open(&station, &FRAMES, |frame| frame.header().trace.captured)?;
    let centerlines = Writer::<Centerlines>::create(
        &station.domain,
        &station.rig,
        &CENTERLINES,
        &station.delivery,
    )?;
    let mut external = External::of(settings);
    let Progress {
        restarts, mut sent, ..
    } = station.handover.progress();
    let mut writer = HandoverWriter::default();
    station.ready()?;
    loop {
        let deadline = external.as_ref().and_then(External::deadline);
        let (frame, mut started_ns) = match frames.receive_by(&station.stop, deadline)? {
            Received::Message(frame, now_ns) => (frame, now_ns),
            Received::Nothing if external.as_mut().is_some_and(External::wait_on) => continue,
            Received::Nothing | Received::End => break,
        };
        if let Some(mut changed) = station.change(&changes) {
            changed.go_on_from(&extractor);
            extractor = changed;
        }
        let header = frame.header();
        if external
            .as_mut()
            .is_some_and(|external| !external.takes(&header.trace, &station.stop))
        {
            break;
        }
        let mask = match &mut masks {
            None => None,
            // A blank frame has no mask.
            Some(_) if header.is_blank() => None,
            Some(masks) => match masks.of(&header.trace, &station.stop)? {
                Some(mask) => {
                    // Waiting for the mask was not work.
                    started_ns = now_ns();
                    Some(mask)
                }
                // The mask was too late. The frame is counted and not sent on.
                None => continue,
            },
        };
        let mut slot = centerlines.slot()?;
        slot.trace = header.trace;
        slot.trace.extract_started_ns = started_ns;
        slot.trace.settings = station.version;
        slot.trace.set_restarts(1, restarts);
        let mask = mask.map(|mask| FrameView::new(mask.header(), mask));
        extractor.answer(FrameView::new(header, &frame), mask, &mut slot);
        // Release the frame to make room for another.
        let trace = header.trace;
        drop(frame);
        sent.count += 1;
        sent.last_sequence = trace.sequence;
        slot.trace.extracted = sent.count;
        slot.trace.extracted_ns = now_ns();
        let left = station.handover.state();
        if left.is_some() {
            writer.keep(&slot);
        }
        station.handover.note(sent, trace.captured);
        station.note(slot.send()?);
        if let Some(left) = left {
            writer.leave(extractor.past(), &left);
        }
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
    station.assert_all_delivered()
}

/// Opens the reader of masks, if the settings select external masks.
fn masks(settings: &Settings, station: &Station) -> anyhow::Result<Option<Companions>> {
    if settings.extract.mask != Mask::External {
        return Ok(None);
    }
    let words = Words {
        what: "mask",
        without: "was skipped",
        setting: "mask_deadline_us",
    };
    let deadline = settings.extract.mask_deadline;
    Companions::open(&MASKS, words, deadline, station).map(Some)
}
