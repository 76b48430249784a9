//! A reader of any channel, and the common properties of messages of all channels.

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use anyhow::Result;
use lariat_wire::{
    CENTERLINES, Centerlines, Channel, DEPTH, DESCRIPTORS, DESCRIPTORS3, Descriptors, Descriptors3,
    Domain, FRAMES, FrameHeader, MASKS, Payload, Receiver, Rig, TRUTH, TRUTH3, Trace, WireError,
    now_ns,
};

use super::poll_interval::PollInterval;
use super::{ChannelName, Place, with_a_hint};
use lariat_chain::stop::Stop;

/// A message of any channel.
#[derive(Debug, Clone, Copy)]
pub(super) enum Any<'a> {
    Image(&'a FrameHeader, &'a [u8]),
    Centerlines(&'a Centerlines),
    Descriptors(&'a Descriptors),
    Descriptors3(&'a Descriptors3),
}

impl Any<'_> {
    pub(super) fn trace(&self) -> &Trace {
        match self {
            Self::Image(header, _) => &header.trace,
            Self::Centerlines(message) => &message.trace,
            Self::Descriptors(message) => &message.trace,
            Self::Descriptors3(message) => &message.trace,
        }
    }

    /// Returns whether the source had no image to give.
    pub(super) fn is_blank(&self) -> bool {
        match self {
            Self::Image(header, _) => header.is_blank(),
            Self::Centerlines(message) => message.width == 0,
            Self::Descriptors(message) => message.width == 0,
            // The message does not say.
            Self::Descriptors3(_) => false,
        }
    }

    /// Size of the message in bytes; an image includes its header.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Image(_, pixels) => size_of::<FrameHeader>() + pixels.len(),
            Self::Centerlines(_) => size_of::<Centerlines>(),
            Self::Descriptors(_) => size_of::<Descriptors>(),
            Self::Descriptors3(_) => size_of::<Descriptors3>(),
        }
    }
}

enum Reader {
    Images(Receiver<[u8]>),
    Centerlines(Receiver<Centerlines>),
    Descriptors(Receiver<Descriptors>),
    Descriptors3(Receiver<Descriptors3>),
}

/// Reader of the inspected channel.
pub(super) struct Probe {
    reader: Reader,
    /// Poll interval of a reader that is not woken.
    poll_interval: Option<PollInterval>,
    came: usize,
}

impl Probe {
    /// Opens a reader of the existing channel. `woken`: each message wakes it.
    pub(super) fn open(place: &Place, woken: bool, buffer: usize) -> Result<Self> {
        let Place { domain, rig, .. } = place;
        let reader = match place.channel {
            ChannelName::Frames => Reader::Images(open(domain, rig, &FRAMES, woken)?),
            ChannelName::Masks => Reader::Images(open(domain, rig, &MASKS, woken)?),
            ChannelName::Depth => Reader::Images(open(domain, rig, &DEPTH, woken)?),
            ChannelName::Centerlines => {
                Reader::Centerlines(open(domain, rig, &CENTERLINES, woken)?)
            }
            ChannelName::Truth => Reader::Centerlines(open(domain, rig, &TRUTH, woken)?),
            ChannelName::Descriptors => {
                Reader::Descriptors(open(domain, rig, &DESCRIPTORS, woken)?)
            }
            ChannelName::Descriptors3 => {
                Reader::Descriptors3(open(domain, rig, &DESCRIPTORS3, woken)?)
            }
            ChannelName::Truth3 => Reader::Descriptors3(open(domain, rig, &TRUTH3, woken)?),
        };
        Ok(Self {
            reader,
            poll_interval: (!woken).then(|| PollInterval::new(buffer)),
            came: 0,
        })
    }

    /// Passes the oldest waiting message to `see`, with the time at which it was received; `None`
    /// if no message waits.
    pub(super) fn next<T>(
        &mut self,
        see: impl FnOnce(Any, u64) -> T,
    ) -> Result<Option<T>, WireError> {
        let seen = match &self.reader {
            Reader::Images(reader) => reader
                .next()?
                .map(|message| see(Any::Image(message.header(), &message), now_ns())),
            Reader::Centerlines(reader) => reader
                .next()?
                .map(|message| see(Any::Centerlines(&message), now_ns())),
            Reader::Descriptors(reader) => reader
                .next()?
                .map(|message| see(Any::Descriptors(&message), now_ns())),
            Reader::Descriptors3(reader) => reader
                .next()?
                .map(|message| see(Any::Descriptors3(&message), now_ns())),
        };
        self.came += usize::from(seen.is_some());
        Ok(seen)
    }

    /// Sleeps until the next poll, the deadline, or a signal.
    pub(super) fn sleep(&mut self, deadline: Instant, stop: &Stop) -> Result<(), WireError> {
        let came = std::mem::take(&mut self.came);
        if let Some(poll_interval) = &mut self.poll_interval {
            let left = deadline.saturating_duration_since(Instant::now());
            sleep_for(poll_interval.after(came).min(left), stop);
            return Ok(());
        }
        let (deadline, stop) = (Some(deadline), Some(stop.as_fd()));
        match &self.reader {
            Reader::Images(reader) => reader.sleep(deadline, stop),
            Reader::Centerlines(reader) => reader.sleep(deadline, stop),
            Reader::Descriptors(reader) => reader.sleep(deadline, stop),
            Reader::Descriptors3(reader) => reader.sleep(deadline, stop),
        }
    }
}

/// Sleeps for this long, or until a signal comes.
pub(super) fn sleep_for(time: Duration, stop: &Stop) {
    let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
    stop.sleep_until(now_ns().saturating_add(ns));
}

fn open<P: Payload + ?Sized>(
    domain: &Domain,
    rig: &Rig,
    channel: &Channel<P>,
    woken: bool,
) -> Result<Receiver<P>> {
    with_a_hint(if woken {
        Receiver::create(domain, rig, channel, None)
    } else {
        Receiver::create_unwoken(domain, rig, channel, None)
    })
}
