//! Channels that a recorder reads.

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use lariat_camera::Mapping;
use lariat_record::Recorder;
use lariat_sink::Ledger;
use lariat_wire::{
    CENTERLINES, Centerlines, Channel, DEPTH, DESCRIPTORS, DESCRIPTORS3, Delivery, Descriptors,
    Descriptors3, FRAMES, FrameHeader, MASKS, Payload, Receiver, TRUTH, WireError, Woken,
    sleep_for_any,
};

use super::looks::Looks;
use lariat_chain::places::pixel;
use lariat_chain::stages::Station;

/// Interval at which a lossless recorder, which every message wakes, checks for other requests.
const LOOKS_UP: Duration = Duration::from_millis(500);

/// All channels of a rig.
pub(crate) struct Channels {
    frames: Receiver<[u8]>,
    masks: Option<Receiver<[u8]>>,
    space: Option<Space>,
    centerlines: Receiver<Centerlines>,
    truth: Receiver<Centerlines>,
    descriptors: Receiver<Descriptors>,
    lossless: bool,
    /// True if frames wake the recorder, as well as descriptors.
    frames_wake: bool,
    looks: Looks,
}

/// Summary of one pass over a rig's channels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Number of frames.
    pub(crate) frames: u64,
    /// Number of messages of any kind.
    pub(crate) messages: u64,
    /// True if a stage appeared for the first time or restarted.
    pub(crate) begun: bool,
    /// Settings version that the newest message was made with.
    pub(crate) settings: Option<u32>,
}

impl Channels {
    /// Opens a reader on each channel. `masks` and `space`: whether there may be masks and 3-D
    /// channels. `is_brief`: whether the source may end with its first frame. The channel of such a
    /// source can only be joined while capture lives, so frames then wake the recorder, too.
    pub(crate) fn open(
        station: &Station,
        masks: bool,
        space: bool,
        is_brief: bool,
    ) -> Result<Self, WireError> {
        let lossless = matches!(station.delivery, Delivery::Lossless { .. });
        let frames_wake = lossless || is_brief;
        Ok(Self {
            frames: open(station, &FRAMES, frames_wake)?,
            masks: masks.then(|| open(station, &MASKS, lossless)).transpose()?,
            space: space.then(|| Space::open(station, lossless)).transpose()?,
            centerlines: open(station, &CENTERLINES, lossless)?,
            truth: open(station, &TRUTH, lossless)?,
            descriptors: open(station, &DESCRIPTORS, true)?,
            lossless,
            frames_wake,
            looks: Looks::new(),
        })
    }

    /// Records all waiting messages. `places` maps the picture to the coordinates of the
    /// descriptors' points, if those are not the picture's.
    pub(crate) fn drain(
        &mut self,
        to: &mut Recorder,
        ledger: &mut Ledger,
        last: &mut Counters,
        mut places: impl FnMut(&Descriptors) -> Option<Mapping>,
    ) -> anyhow::Result<Counts> {
        let mut seen = Counts::default();
        // Frames come first: they are the largest and have the least room to wait.
        while let Some(frame) = self.frames.next()? {
            let header: &FrameHeader = frame.header();
            seen.begun |= last.captured.begins_with(header.trace.captured);
            self.looks
                .frame(header.trace.captured, header.trace.captured_ns);
            to.frame(header, &frame)?;
            seen.frames += 1;
        }
        while let Some(mask) = self.masks.as_ref().map_or(Ok(None), Receiver::next)? {
            to.mask(mask.header(), &mask)?;
            seen.messages += 1;
        }
        if let Some(space) = &self.space {
            while let Some(depth) = space.depths.next()? {
                to.depth(depth.header(), &depth)?;
                seen.messages += 1;
            }
            while let Some(descriptors) = space.descriptors.next()? {
                to.descriptors3(&descriptors)?;
                seen.messages += 1;
            }
        }
        while let Some(truth) = self.truth.next()? {
            to.truth(&truth)?;
            seen.messages += 1;
        }
        while let Some(centerlines) = self.centerlines.next()? {
            seen.begun |= last.extracted.begins_with(centerlines.trace.extracted);
            seen.settings = seen.settings.max(Some(centerlines.trace.settings));
            to.centerlines(&centerlines)?;
            seen.messages += 1;
        }
        while let Some(descriptors) = self.descriptors.next()? {
            seen.begun |= last.fitted.begins_with(descriptors.trace.fitted);
            seen.settings = seen.settings.max(Some(descriptors.trace.settings));
            ledger.received(&descriptors.trace, lariat_wire::now_ns());
            let places = places(&descriptors);
            to.descriptors(&descriptors, |point| {
                pixel(&descriptors, places.as_ref(), point)
            })?;
            seen.messages += 1;
        }
        seen.messages += seen.frames;
        self.looks.looked(seen.messages > 0);
        Ok(seen)
    }

    /// Sleeps until there may be something to record, the recorder is asked to stop, or the
    /// deadline passes.
    pub(crate) fn sleep(
        &self,
        station: &Station,
        deadline: Option<Instant>,
    ) -> Result<(), WireError> {
        let stop = Some(station.stop.as_fd());
        let wait = if self.lossless {
            LOOKS_UP
        } else {
            self.looks.wait()
        };
        let look = Instant::now() + wait;
        let until = Some(deadline.map_or(look, |deadline| deadline.min(look)));
        if !self.frames_wake {
            return self.descriptors.sleep(until, stop);
        }
        if !self.lossless {
            return sleep_for_any([&self.frames, &self.descriptors], until, stop);
        }
        let Self {
            frames,
            centerlines,
            truth,
            descriptors,
            ..
        } = self;
        // An existing channel takes the place of a missing one.
        let masks = self.masks.as_ref().unwrap_or(frames);
        let (depths, in_space): (_, &dyn Woken) = match &self.space {
            Some(space) => (&space.depths, &space.descriptors),
            None => (frames, frames),
        };
        sleep_for_any(
            [
                frames,
                centerlines,
                truth,
                descriptors,
                masks,
                depths,
                in_space,
            ],
            until,
            stop,
        )
    }
}

/// The channels of a rig with a depth camera.
struct Space {
    depths: Receiver<[u8]>,
    descriptors: Receiver<Descriptors3>,
}

impl Space {
    fn open(station: &Station, lossless: bool) -> Result<Self, WireError> {
        Ok(Self {
            depths: open(station, &DEPTH, lossless)?,
            descriptors: open(station, &DESCRIPTORS3, lossless)?,
        })
    }
}

/// Opens a reader that messages wake, or one that polls. Polling costs the writer nothing. A
/// lossless writer waits for each of its readers, so all of them are woken.
fn open<P: Payload + ?Sized>(
    station: &Station,
    channel: &Channel<P>,
    woken: bool,
) -> Result<Receiver<P>, WireError> {
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = station;
    if woken {
        Receiver::create(domain, rig, channel, Some(delivery))
    } else {
        Receiver::create_unwoken(domain, rig, channel, Some(delivery))
    }
}

/// Last counters of the stages.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    captured: Counter,
    extracted: Counter,
    fitted: Counter,
}

#[derive(Debug, Default)]
struct Counter(Option<u64>);

impl Counter {
    /// True if a stage is new, or was restarted.
    fn begins_with(&mut self, count: u64) -> bool {
        self.0.replace(count).is_none_or(|last| count <= last)
    }
}
