//! The rig's channels, read while there is a writer and a subscriber.

use std::time::{Duration, Instant};

use lariat_chain::stop::Stop;
use lariat_wire::{
    CENTERLINES, Centerlines, Channel, ChannelState, DESCRIPTORS, DESCRIPTORS3, Descriptors,
    Descriptors3, Domain, FRAMES, FrameHeader, Message, Payload, Receiver, Rig, WireError, now_ns,
};
use std::os::fd::AsFd;

/// Interval at which writers and subscribers are checked.
const CHECK: Duration = Duration::from_millis(250);
/// The same interval while nothing is read; each wakeup costs about 70 µs.
const CHECK_AT_REST: Duration = Duration::from_millis(500);

/// The channels that are needed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Wanted {
    /// Includes descriptors in space if the rig has a depth camera.
    pub(crate) descriptors: bool,
    pub(crate) centerlines: bool,
    pub(crate) frames: bool,
}

/// A frame's shapes in space.
pub(crate) enum Space {
    /// The rig lacks a depth camera.
    None,
    /// The rig has a depth camera, but this frame's message did not arrive.
    Missing,
    Of(Message<Descriptors3>),
}

/// The reading ends of the channels.
///
/// Descriptors wake this process once per frame, when the frame is complete. The other messages of
/// the frame were sent before and are read then. A reader must not outlive its writer, because it
/// would keep the old channel alive. It is therefore closed when its writer ends.
pub(crate) struct Channels<'d> {
    domain: &'d Domain,
    rig: &'d Rig,
    descriptors: Option<Receiver<Descriptors>>,
    descriptors3: Option<Receiver<Descriptors3>>,
    /// True if the rig has a depth camera, whichever channels are read.
    is_in_space: bool,
    centerlines: Option<Receiver<Centerlines>>,
    frames: Option<Receiver<[u8]>>,
    checked: Option<Instant>,
    /// The error that keeps a channel from being read, reported once.
    said: Option<String>,
}

impl<'d> Channels<'d> {
    pub(crate) fn new(domain: &'d Domain, rig: &'d Rig) -> Self {
        Self {
            domain,
            rig,
            descriptors: None,
            descriptors3: None,
            is_in_space: false,
            centerlines: None,
            frames: None,
            checked: None,
            said: None,
        }
    }

    /// Returns whether writers and subscribers should be checked now.
    pub(crate) fn is_check_due(&self) -> bool {
        self.checked.is_none_or(|at| at.elapsed() >= self.pause())
    }

    /// Time between two checks.
    fn pause(&self) -> Duration {
        if self.is_open() { CHECK } else { CHECK_AT_REST }
    }

    /// Opens the channels that are needed and have a writer, and closes the others.
    pub(crate) fn check(&mut self, wanted: Wanted) {
        self.checked = Some(Instant::now());
        let (domain, rig) = (self.domain, self.rig);
        let descriptors = &mut self.descriptors;
        let looked = follow(domain, rig, &DESCRIPTORS, wanted.descriptors, descriptors);
        self.is_in_space =
            descriptors.is_some() && written(domain, rig, DESCRIPTORS3.name()).is_some();
        let looked = [
            looked,
            follow(
                domain,
                rig,
                &DESCRIPTORS3,
                self.is_in_space,
                &mut self.descriptors3,
            ),
            follow(
                domain,
                rig,
                &CENTERLINES,
                wanted.centerlines,
                &mut self.centerlines,
            ),
            follow(domain, rig, &FRAMES, wanted.frames, &mut self.frames),
        ];
        let obstacle = looked.into_iter().find_map(Result::err);
        let obstacle = obstacle.map(|error| error.to_string());
        if obstacle.is_some() && obstacle != self.said {
            eprintln!("lariat-ros2: {}", obstacle.as_deref().unwrap_or_default());
        }
        self.said = obstacle;
    }

    /// Returns whether descriptors are read.
    pub(crate) fn is_open(&self) -> bool {
        self.descriptors.is_some()
    }

    /// Sleeps until descriptors may have arrived, until the next check, or until a signal.
    pub(crate) fn sleep(&mut self, stop: &Stop) {
        let due = self.checked.unwrap_or_else(Instant::now) + self.pause();
        if let Some(reader) = &self.descriptors {
            if reader.sleep(Some(due), Some(stop.as_fd())).is_ok() {
                return;
            }
            self.descriptors = None;
        }
        let left = due.saturating_duration_since(Instant::now());
        let ns = u64::try_from(left.as_nanos()).unwrap_or(u64::MAX);
        stop.sleep_until(now_ns().saturating_add(ns));
    }

    /// The oldest waiting descriptors.
    pub(crate) fn next(&mut self) -> Option<Message<Descriptors>> {
        take(&mut self.descriptors, |reader| reader.next())
    }

    /// The shapes in space of the frame with this source number. They are sent before its
    /// descriptors.
    pub(crate) fn space_of(&mut self, sequence: u64) -> Space {
        let came = take(&mut self.descriptors3, |reader| {
            until(reader, sequence, |message| message.trace.sequence)
        });
        match came {
            Some(message) => Space::Of(message),
            None if self.is_in_space => Space::Missing,
            None => Space::None,
        }
    }

    /// The centerlines of the frame with this source number, if they arrived.
    pub(crate) fn centerlines_of(&mut self, sequence: u64) -> Option<Message<Centerlines>> {
        take(&mut self.centerlines, |reader| {
            until(reader, sequence, |message| message.trace.sequence)
        })
    }

    /// The frame with this source number, if it arrived.
    pub(crate) fn frame_of(&mut self, sequence: u64) -> Option<Message<[u8]>> {
        let sequence_of = |message: &Message<[u8]>| -> u64 {
            let header: &FrameHeader = message.header();
            header.trace.sequence
        };
        take(&mut self.frames, |reader| {
            until(reader, sequence, sequence_of)
        })
    }
}

/// Returns the waiting message of this frame and discards earlier ones. If the next message is of a
/// later frame, that message is lost, and so are the other messages of its frame. The same happens
/// to an image after an overflow.
fn until<P: Payload + ?Sized>(
    reader: &Receiver<P>,
    sequence: u64,
    sequence_of: impl Fn(&Message<P>) -> u64,
) -> Result<Option<Message<P>>, WireError> {
    while let Some(message) = reader.next()? {
        let came = sequence_of(&message);
        if came >= sequence {
            return Ok((came == sequence).then_some(message));
        }
    }
    Ok(None)
}

/// Reads from a reader. A reader that fails is closed, and opened again at the next check.
fn take<P: Payload + ?Sized, T>(
    reader: &mut Option<Receiver<P>>,
    read: impl FnOnce(&Receiver<P>) -> Result<Option<T>, WireError>,
) -> Option<T> {
    let result = read(reader.as_ref()?);
    if result.is_err() {
        *reader = None;
    }
    result.ok().flatten()
}

fn follow<P: Payload + ?Sized>(
    domain: &Domain,
    rig: &Rig,
    channel: &Channel<P>,
    wanted: bool,
    reader: &mut Option<Receiver<P>>,
) -> Result<(), WireError> {
    let state = wanted.then(|| written(domain, rig, channel.name()));
    match (state.flatten(), &reader) {
        (None, _) => *reader = None,
        (Some(_), Some(_)) => {}
        (Some(_), None) if channel.name() == DESCRIPTORS.name() => {
            *reader = Some(Receiver::create(domain, rig, channel, None)?);
        }
        // A lossless writer waits for its readers, but this reader reads only when descriptors
        // arrive. It must therefore only read channels whose messages always come just before
        // descriptors.
        (Some(state), None) if state.lossless && channel.name() != DESCRIPTORS3.name() => {}
        (Some(_), None) => *reader = Some(Receiver::create_unwoken(domain, rig, channel, None)?),
    }
    Ok(())
}

/// The state of the channel if it has a writer.
fn written(domain: &Domain, rig: &Rig, channel: &str) -> Option<ChannelState> {
    // The ends of a channel of another version are unknown; opening it reports the mismatch.
    let state = domain.channel(rig, channel);
    state.filter(|state| state.ends.as_ref().is_none_or(|ends| ends.writer.is_some()))
}
