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

/// What every stage has: its place on the wire, the signal that ends it, the line to the chain that started it.
pub struct Station {
    /// Where the rig lives.
    pub domain: Domain,
    /// Its channels.
    pub rig: Rig,
    /// Whether senders wait for readers.
    pub delivery: Delivery,
    /// What ends it.
    pub stop: Stop,
    /// Whom it tells how it is.
    pub status: Status,
    /// What it leaves to its successor.
    pub handover: Handover,
    /// By which settings it goes.
    pub version: u32,
    orders: Orders,
    arrangement: Arrangement,
    /// Which stage it is, if it is one.
    stage: Option<Stage>,
    /// What it is called among those that run on a rig.
    name: &'static str,
    /// What it says of itself to others on the machine.
    settings: String,
    /// The channel that it was made a reader of.
    reads: Cell<Option<&'static str>>,
    /// Messages that did not reach a reader although this stage waited for it.
    undelivered: Cell<u64>,
    announcement: Option<Announcement>,
}

/// What joins a stage to the chain that started it, and what ends it.
pub struct Supervision {
    /// What ends it.
    pub stop: Stop,
    /// Whom it tells how it is.
    pub status: Status,
    /// What it is told.
    pub orders: Orders,
    /// What it leaves to its successor.
    pub handover: Handover,
}

impl Supervision {
    /// Of a stage that is this process.
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
    /// Of a stage.
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

    /// Notes whether a message that was sent reached all readers.
    pub fn note(&self, is_delivered: bool) {
        let undelivered = self.undelivered.get() + u64::from(!is_delivered);
        self.undelivered.set(undelivered);
    }

    /// The last word of a stage that sends.
    ///
    /// # Errors
    /// A reader did not get all that was sent, because it stood still while this stage ended.
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

    /// Of what stands beside the stages, under a name, and has no place of its own on the machine.
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

    /// It can receive, and all its threads are there: it takes its place on the machine, if it has one, and says so.
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

    /// Listens for settings that change: [`Orders::listen`]. Before it is [ready](Self::ready), so that the thread that does has no
    /// part in the stage's place on the machine.
    ///
    /// # Errors
    /// There is no thread to be had.
    pub fn listen<T: Send + 'static>(
        &mut self,
        settings: &Settings,
        make: impl FnMut(&Settings, &Settings) -> anyhow::Result<Option<T>> + Send + 'static,
    ) -> anyhow::Result<Changes<T>> {
        std::mem::take(&mut self.orders).listen(settings, make)
    }

    /// Settings that have changed since it was last asked hold from now on, and others see it. What the stage made of them is
    /// returned, if they concern it.
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

    /// Has the stage rest when it must.
    pub fn rest(&self) -> Rest {
        Rest::new(&self.arrangement)
    }

    /// Becomes a reader that is woken as the settings say.
    pub fn reader<P: Payload + ?Sized>(
        &self,
        channel: &Channel<P>,
    ) -> Result<Receiver<P>, WireError> {
        let mut reader = Receiver::create(&self.domain, &self.rig, channel, Some(&self.delivery))?;
        reader.look_for(self.arrangement.spin());
        self.reads.set(Some(channel.name()));
        Ok(reader)
    }

    /// Started by hand, whoever waits says for what.
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

/// Watches the counter of the stage before for gaps.
///
/// A backlog is worked off in order. But a gap says that the backlog overflowed: what still waits is old then, and the
/// newest message is worth more than the rest.
#[derive(Default)]
pub struct Backlog {
    last: Option<u64>,
}

impl Backlog {
    /// Takes the counter of a message just received; `true` if messages before it were lost.
    pub fn overflowed(&mut self, count: u64) -> bool {
        let gap = self.last.is_some_and(|last| count > last + 1);
        self.last = Some(count);
        gap
    }
}

/// What a wait for a message ended with.
pub enum Received<P: Payload + ?Sized> {
    /// A message, and the moment it was in hand.
    Message(Message<P>, u64),
    /// The deadline.
    Nothing,
    /// The stage is to end, and nothing waits.
    End,
}

/// Where a stage's messages come in.
pub struct Inbox<P: Payload + ?Sized> {
    reader: Receiver<P>,
    channel: &'static str,
    backlog: Backlog,
    rest: Rest,
    /// The counter of the stage before, in a message.
    count: fn(&Message<P>) -> u64,
}

impl<P: Payload + ?Sized> Inbox<P> {
    /// Opens the channel.
    ///
    /// # Errors
    /// The transport refuses.
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

    /// Receives the next message, sleeping until there is one; `None` when the stage is to end and nothing waits.
    ///
    /// Returns the message with the moment it was in hand.
    pub fn receive(&mut self, stop: &Stop) -> Result<Option<(Message<P>, u64)>, WireError> {
        Ok(match self.receive_by(stop, None)? {
            Received::Message(message, now_ns) => Some((message, now_ns)),
            Received::Nothing | Received::End => None,
        })
    }

    /// The same, but no later than the deadline.
    pub fn receive_by(
        &mut self,
        stop: &Stop,
        deadline: Option<Instant>,
    ) -> Result<Received<P>, WireError> {
        loop {
            // Asked before looking: what was sent before the signal is still received.
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
