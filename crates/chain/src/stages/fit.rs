//! The fit process: reads centerlines and sends descriptors. With depth images or a second rig it
//! also sends 3-D descriptors.

use std::panic::resume_unwind;

use lariat_wire::{
    CENTERLINES, Centerlines, DEPTH, DESCRIPTORS, DESCRIPTORS3, Descriptors, Descriptors3, Writer,
    now_ns,
};

use super::companions::{Companions, Words};
use super::handover::Progress;
use super::second::SecondView;
use super::status::Word;
use super::{Inbox, Station, Supervision};
use crate::calibrated::Calibrated;
use crate::pipeline::{Companion, CurveFitter, FrameView, SpaceFitter};
use crate::settings::{Settings, Stage};

/// Fits until a signal arrives.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    let mut station = Station::open(settings, Stage::Fit, supervision)?;
    // Computing the tables takes milliseconds. Open the channels meanwhile.
    let made = settings.clone();
    let curves = std::thread::spawn(move || CurveFitter::new(&made));
    let read = |settings: &Settings| {
        let (camera, size) = (&settings.camera, settings.capture.likely_size());
        anyhow::Ok((Calibrated::load(camera)?, Calibrated::beside(camera, size)?))
    };
    let mut calibrated = read(settings)?;
    let changes = station.listen(settings, move |before, now| {
        // The files of `[camera]` may have changed under the same names.
        let calibrated_now = read(now)?;
        let is_ours = before.fit != now.fit || calibrated != calibrated_now;
        let made = is_ours
            .then(|| anyhow::Ok((CurveFitter::new(now)?, SpaceFitter::new(now)?)))
            .transpose()?;
        calibrated = calibrated_now;
        Ok(made)
    })?;
    let mut space = Space::open(settings, &station)?;
    let mut centerlines = Inbox::open(&station, &CENTERLINES, |seen| seen.trace.extracted)?;
    let descriptors = Writer::<Descriptors>::create(
        &station.domain,
        &station.rig,
        &DESCRIPTORS,
        &station.delivery,
    )?;
    let Progress {
        restarts, mut sent, ..
    } = station.handover.progress();
    let mut curves = curves.join().unwrap_or_else(|cause| resume_unwind(cause))?;
    station.ready()?;
    while let Some((message, started_ns)) = centerlines.receive(&station.stop)? {
        if let Some(changed) = station.change(&changes) {
            let in_space;
            (curves, in_space) = changed;
            if let (Some(space), Some(fitter)) = (&mut space, in_space) {
                space.fitter = fitter;
            }
        }
        // The 3-D descriptors are sent first, so that readers already have them when the
        // descriptors arrive.
        if let Some(space) = &mut space {
            space.answer(&message, started_ns, sent.count + 1, &station)?;
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
        station.handover.note(sent, slot.trace.extracted);
        station.note(slot.send()?);
    }
    if let Some(space) = space {
        space.tell_of_missing(&mut station);
    }
    station.status.say(Word::Sent(sent));
    station.assert_all_delivered()
}

/// Fits ropes in 3-D, if there is a depth camera or a second color camera.
struct Space {
    fitter: SpaceFitter,
    beside: Beside,
    writer: Writer<Descriptors3>,
}

/// Reader of the companions of centerlines.
enum Beside {
    Depths(Box<Companions>),
    Second(Box<SecondView>),
}

impl Space {
    /// Returns `None` if the settings name neither camera.
    fn open(settings: &Settings, station: &Station) -> anyhow::Result<Option<Self>> {
        let Some(fitter) = SpaceFitter::new(settings)? else {
            return Ok(None);
        };
        let words = Words {
            what: "depth image",
            without: "is described in the image only",
            setting: "depth_deadline_us",
        };
        let Station {
            domain,
            rig,
            delivery,
            ..
        } = station;
        let camera = &settings.camera;
        let beside = match camera.second {
            Some(_) => Beside::Second(Box::new(SecondView::open(camera, station)?)),
            None => {
                let deadline = camera.depth_deadline;
                Beside::Depths(Box::new(Companions::open(
                    &DEPTH, words, deadline, station,
                )?))
            }
        };
        Ok(Some(Self {
            fitter,
            beside,
            writer: Writer::<Descriptors3>::create(domain, rig, &DESCRIPTORS3, delivery)?,
        }))
    }

    /// Reports how many frames lacked a depth image or second view. The chain needs the number for
    /// its report; without a chain, a warning is printed if there were any.
    fn tell_of_missing(&self, station: &mut Station) {
        let (missing, what) = match &self.beside {
            Beside::Depths(depths) => (depths.late(), "depth image"),
            Beside::Second(second) => (second.alone(), "second view"),
        };
        station.status.say(Word::Depthless(missing));
        if missing > 0 && !station.status.is_supervised() {
            tracing::warn!("{missing} frames were described in the image only, without a {what}");
        }
    }

    fn answer(
        &mut self,
        seen: &Centerlines,
        mut started_ns: u64,
        fitted: u64,
        station: &Station,
    ) -> anyhow::Result<()> {
        // A frame without an image does not get a companion.
        let companion = match &mut self.beside {
            _ if seen.width == 0 => None,
            Beside::Depths(depths) => {
                let image = depths.of(&seen.trace, &station.stop)?;
                image.map(|image| Companion::Depth(FrameView::new(image.header(), image)))
            }
            Beside::Second(second) => {
                let there = second.of(&seen.trace, &station.stop)?;
                there.map(Companion::Second)
            }
        };
        if companion.is_some() {
            started_ns = started_ns.max(now_ns());
        }
        let mut slot = self.writer.slot()?;
        slot.trace = seen.trace;
        slot.trace.fit_started_ns = started_ns;
        slot.trace.settings = station.version;
        self.fitter.answer(seen, companion, &mut slot);
        (slot.trace.fitted, slot.trace.fitted_ns) = (fitted, now_ns());
        station.note(slot.send()?);
        Ok(())
    }
}
