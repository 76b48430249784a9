//! The four stages as processes: thin shells that receive, call a library, and send.

#[cfg(test)]
mod allocation;
pub mod arrangement;
pub mod capture;
mod companions;
mod external;
pub mod extract;
pub(crate) mod extract_handover;
pub mod fit;
pub mod handover;
pub mod orders;
mod second;
pub mod sink;
mod slot_lender;
pub mod status;

use std::cell::Cell;
use std::os::fd::AsFd;
use std::time::Instant;

use lariat_wire::{
    Announcement, Channel, Delivery, Domain, Message, Payload, Receiver, Rig, WireError, now_ns,
};

use crate::settings::{Arrangement, Settings, Stage};
use crate::stop::Stop;
use arrangement::Rest;
use handover::Handover;
use orders::{Changes, Orders};
use status::{Status, Word};

/// The environment of a stage: its channels, the stop flag, and the status line to the chain that
/// started it.
pub struct Station {
    /// The rig's domain.
    pub domain: Domain,
    /// The rig, which names the channels.
    pub rig: Rig,
    /// Delivery mode: whether senders wait for readers.
    pub delivery: Delivery,
    /// Flag that ends the stage.
    pub stop: Stop,
    /// Status line to the chain.
    pub status: Status,
    /// Handover state for the successor.
    pub handover: Handover,
    /// Version of the settings in force.
    pub version: u32,
    orders: Orders,
    arrangement: Arrangement,
    /// The stage, or `None` for a program alongside the stages.
    stage: Option<Stage>,
    /// Name under which this process is announced on the rig.
    name: &'static str,
    /// Settings that this process announces to others.
    settings: String,
    /// The channel that this process reads.
    reads: Cell<Option<&'static str>>,
    /// Number of messages that did not reach a reader although this stage waited for it.
    undelivered: Cell<u64>,
    announcement: Option<Announcement>,
}

/// Connection of a stage to the chain that started it, and the stop flag.
pub struct Supervision {
    /// Flag that ends the stage.
    pub stop: Stop,
    /// Status line to the chain.
    pub status: Status,
    /// Settings from the chain.
    pub orders: Orders,
    /// Handover state for the successor.
    pub handover: Handover,
}

impl Supervision {
    /// Returns the supervision of a stage that is this process.
    pub fn of_this_process() -> anyhow::Result<Self> {
        Ok(Self {
            stop: Stop::on_signals()?,
            status: Status::of_the_chain()?,
            orders: Orders::of_the_chain()?,
            handover: Handover::of_the_chain()?,
        })
    }
}

impl Station {
    /// Opens the station of a stage.
    pub fn open(
        settings: &Settings,
        stage: Stage,
        supervision: Supervision,
    ) -> anyhow::Result<Self> {
        let station = Self::beside(settings, stage.name(), supervision)?;
        Ok(Self {
            stage: Some(stage),
            ..station
        })
    }

    /// Notes whether a message reached all readers.
    pub fn note(&self, is_delivered: bool) {
        let undelivered = self.undelivered.get() + u64::from(!is_delivered);
        self.undelivered.set(undelivered);
    }

    /// Checks at the end that all messages of a sending stage were delivered.
    ///
    /// # Errors
    /// Returns an error if a reader missed messages because it did not read while this stage ended.
    pub fn assert_all_delivered(&self) -> anyhow::Result<()> {
        match self.undelivered.get() {
            0 => Ok(()),
            count => anyhow::bail!(
                "{}: {count} message{} did not reach a reader that stood still while this stage ended, although the chain is lossless",
                self.name,
                if count == 1 { "" } else { "s" }
            ),
        }
    }

    /// Opens a station for a program alongside the stages. It has a name, but no arrangement on the
    /// machine.
    pub fn beside(
        settings: &Settings,
        name: &'static str,
        supervision: Supervision,
    ) -> anyhow::Result<Self> {
        let Supervision {
            stop,
            status,
            orders,
            handover,
        } = supervision;
        for (key, value) in settings.changed() {
            tracing::debug!("{name}: {key} = {value}");
        }
        let delivery = if settings.run.lossless {
            Delivery::Lossless { stop: stop.flag() }
        } else {
            Delivery::NewestWins
        };
        Ok(Self {
            domain: Domain::open()?,
            rig: settings.run.rig.parse()?,
            delivery,
            stop,
            status,
            handover,
            version: settings.version,
            orders,
            arrangement: settings.run.arrangement.clone(),
            stage: None,
            name,
            settings: settings.text(),
            reads: Cell::new(None),
            undelivered: Cell::default(),
            announcement: None,
        })
    }

    /// Reports that the stage can receive. All its threads exist by now, so it first applies its
    /// arrangement on the machine, if it has one.
    pub fn ready(&mut self) -> anyhow::Result<()> {
        if let Some(stage) = self.stage {
            let lacks = arrangement::apply(&self.arrangement, stage)?;
            if lacks.any() {
                self.status.say(Word::Lacks(lacks));
            }
        }
        let name = self.name;
        match self.domain.announce(&self.rig, name, &self.settings) {
            Ok(announcement) => self.announcement = Some(announcement),
            Err(cause) => tracing::warn!(
                "{name} is not seen by `lariat doctor` and recorders, as its entry could not be written: {cause}"
            ),
        }
        self.status.say(Word::Ready);
        if let Some(channel) = self.reads.get() {
            self.say_who_is_missing(channel);
        }
        Ok(())
    }

    /// Listens for changes of settings: [`Orders::listen`]. Must be called before
    /// [`ready`](Self::ready), so that the stage's arrangement does not apply to the listening
    /// thread.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be started.
    pub fn listen<T: Send + 'static>(
        &mut self,
        settings: &Settings,
        make: impl FnMut(&Settings, &Settings) -> anyhow::Result<Option<T>> + Send + 'static,
    ) -> anyhow::Result<Changes<T>> {
        std::mem::take(&mut self.orders).listen(settings, make)
    }

    /// Applies settings that have changed since the last call and announces them. Returns the
    /// objects that the stage prepared from them, if they concern it.
    pub fn change<T>(&mut self, changes: &Changes<T>) -> Option<T> {
        let change = changes.take()?;
        self.version = change.version;
        let announced = self.announcement.as_mut();
        if let Some(Err(cause)) = announced.map(|announced| announced.renew(&change.text)) {
            tracing::warn!(
                "others see the settings of before, as the entry could not be written: {cause}"
            );
        }
        change.made
    }

    /// Returns the [`Rest`] that keeps a realtime stage from occupying its core.
    pub fn rest(&self) -> Rest {
        Rest::new(&self.arrangement)
    }

    /// Opens a reader that waits for messages in the way that the settings select.
    pub fn reader<P: Payload + ?Sized>(
        &self,
        channel: &Channel<P>,
    ) -> Result<Receiver<P>, WireError> {
        let mut reader = Receiver::create(&self.domain, &self.rig, channel, Some(&self.delivery))?;
        reader.look_for(self.arrangement.spin());
        self.reads.set(Some(channel.name()));
        Ok(reader)
    }

    /// If the stage was started by hand, prints what it is waiting for.
    pub fn say_who_is_missing(&self, channel: &str) {
        let state = self.domain.channel(&self.rig, channel);
        let ends = state.and_then(|state| state.ends);
        if !self.status.is_supervised() && ends.is_none_or(|ends| ends.writer.is_none()) {
            eprintln!(
                "lariat: waiting for {channel} of rig {} (`lariat run` starts a chain)",
                self.rig
            );
        }
    }
}

/// Detects gaps in the counter of the previous stage.
///
/// A backlog is processed in order. A gap means that the backlog overflowed: the waiting messages
/// are old, and the newest one is worth more than the rest.
#[derive(Default)]
pub struct Backlog {
    last: Option<u64>,
}

impl Backlog {
    /// Takes the counter of a message just received. Returns true if messages before it were lost.
    pub fn overflowed(&mut self, count: u64) -> bool {
        let gap = self.last.is_some_and(|last| count > last + 1);
        self.last = Some(count);
        gap
    }
}

/// Result of waiting for a message.
pub enum Received<P: Payload + ?Sized> {
    /// A message, and the time of its arrival at the stage.
    Message(Message<P>, u64),
    /// The deadline has passed.
    Nothing,
    /// The stage is to end, and no message is waiting.
    End,
}

/// Receives a stage's messages.
pub struct Inbox<P: Payload + ?Sized> {
    reader: Receiver<P>,
    channel: &'static str,
    backlog: Backlog,
    rest: Rest,
    /// Returns the previous stage's counter in a message.
    count: fn(&Message<P>) -> u64,
}

impl<P: Payload + ?Sized> Inbox<P> {
    /// Opens the channel.
    ///
    /// # Errors
    /// Returns an error if the transport fails.
    pub fn open(
        station: &Station,
        channel: &Channel<P>,
        count: fn(&Message<P>) -> u64,
    ) -> Result<Self, WireError> {
        Ok(Self {
            reader: station.reader(channel)?,
            channel: channel.name(),
            backlog: Backlog::default(),
            rest: station.rest(),
            count,
        })
    }

    /// Receives the next message and the time of its arrival at the stage. Sleeps until there is
    /// one. Returns `None` when the stage is to end and no message is waiting.
    pub fn receive(&mut self, stop: &Stop) -> Result<Option<(Message<P>, u64)>, WireError> {
        Ok(match self.receive_by(stop, None)? {
            Received::Message(message, now_ns) => Some((message, now_ns)),
            Received::Nothing | Received::End => None,
        })
    }

    /// Receives like [`receive`](Self::receive), but no later than the deadline.
    pub fn receive_by(
        &mut self,
        stop: &Stop,
        deadline: Option<Instant>,
    ) -> Result<Received<P>, WireError> {
        loop {
            // Check this before reading, so that messages sent before the signal are still
            // received.
            let last_look = stop.asked();
            if let Some(mut message) = self.reader.next()? {
                if self.backlog.overflowed((self.count)(&message)) {
                    message = self.reader.newest_after(message)?;
                    self.backlog.last = Some((self.count)(&message));
                }
                let now_ns = now_ns();
                tracing::trace!("{} {} in hand", self.channel, (self.count)(&message));
                self.rest.if_due(now_ns);
                return Ok(Received::Message(message, now_ns));
            }
            if last_look {
                return Ok(Received::End);
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return Ok(Received::Nothing);
            }
            let reader = &self.reader;
            self.rest
                .while_waiting(|| reader.sleep(deadline, Some(stop.as_fd())))?;
        }
    }
}
