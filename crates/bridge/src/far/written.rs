//! A channel that is written here: messages from the wire, checked as readers check them, with
//! their timestamps on this machine's clock.

use lariat_wire::{
    Centerlines, Channel, Delivery, Descriptors, Descriptors3, Domain, NoShape, Rig, Shape, Trace,
    WireError, Writer, now_ns,
};

use crate::clock::Offset;
use crate::datagram::Datagram;
use crate::pack::unpack;
use crate::say;
use crate::stamps::Stamps;

/// Time between two attempts to become a writer in place of another process.
const RETRY_NS: u64 = 1_000_000_000;

/// A message that can be copied from the wire to a channel.
pub(super) trait Carried: lariat_wire::Payload + lariat_wire::fields::Message {
    fn trace_mut(&mut self) -> &mut Trace;
    /// Returns whether readers would accept the message.
    fn is_sound(&self) -> bool;
    /// Writes the used parts of the message to the channel.
    fn send(&self, to: &Writer<Self>) -> Result<(), WireError>;
    fn write(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<Self>,
    ) -> Result<Writer<Self>, WireError>;
}

macro_rules! carried {
    ($message:ident, |$read:ident| $is_sound:expr) => {
        impl Carried for $message {
            fn trace_mut(&mut self) -> &mut Trace {
                &mut self.trace
            }

            fn is_sound(&self) -> bool {
                let $read = self;
                $is_sound
            }

            fn send(&self, to: &Writer<Self>) -> Result<(), WireError> {
                let mut slot = to.slot()?;
                slot.copy_meant(self);
                slot.send()?;
                Ok(())
            }

            fn write(
                domain: &Domain,
                rig: &Rig,
                channel: &Channel<Self>,
            ) -> Result<Writer<Self>, WireError> {
                Writer::<$message>::create(domain, rig, channel, &Delivery::NewestWins)
            }
        }
    };
}
// The same checks as in readers: a curve must be readable if there is one, and this release must
// know each code.
carried!(Descriptors, |read| read.unit().is_some()
    && read.curves().iter().all(|curve| {
        Shape::of(curve).err() != Some(NoShape::Unreadable)
            && curve.status().is_some()
            && curve.fit().is_some()
    }));
carried!(Descriptors3, |read| read.axes().is_some()
    && read.curves().iter().all(|curve| {
        Shape::in_space(curve).err() != Some(NoShape::Unreadable)
            && curve.status().is_some()
            && curve.fit().is_some()
    }));
carried!(Centerlines, |read| {
    let count = read.curves().len();
    read.curves().iter().all(|curve| curve.status().is_some())
        && read
            .crossings()
            .iter()
            .all(|crossing| (crossing.over.max(crossing.under) as usize) < count)
});

/// A channel that is written here.
pub(super) struct Written<M: Carried + 'static> {
    channel: &'static Channel<M>,
    writer: Option<Writer<M>>,
    message: Box<M>,
    /// Number of messages written.
    count: u64,
    tried_ns: u64,
    said: Option<String>,
}

impl<M: Carried> Written<M> {
    pub(super) fn new(channel: &'static Channel<M>, empty: M) -> Self {
        Self {
            channel,
            writer: None,
            message: Box::new(empty),
            count: 0,
            tried_ns: 0,
            said: None,
        }
    }

    /// Becomes the channel's writer, unless it already is. Readers that joined since the last
    /// message receive that message.
    pub(super) fn open(&mut self, domain: &Domain, rig: &Rig) {
        if let Some(writer) = &self.writer {
            let welcomed = writer.welcome();
            return self.note(welcomed);
        }
        let now_ns = now_ns();
        if self.tried_ns > 0 && now_ns.saturating_sub(self.tried_ns) < RETRY_NS {
            return;
        }
        self.tried_ns = now_ns;
        let made = M::write(domain, rig, self.channel).map(|writer| self.writer = Some(writer));
        self.note(made);
    }

    /// Writes the message in a datagram; `None` if it is not a valid message.
    pub(super) fn take(
        &mut self,
        datagram: &Datagram,
        stamps: &mut Stamps,
        offset: &Offset,
        at_ns: u64,
    ) -> Option<()> {
        unpack(&mut *self.message, datagram.says).ok()?;
        self.message.is_sound().then_some(())?;
        stamps.set(self.message.trace_mut(), offset, at_ns);
        if let Some(writer) = &self.writer {
            self.count += 1;
            self.message.trace_mut().bridged = self.count;
            let sent = self.message.send(writer);
            self.note(sent);
        }
        Some(())
    }

    /// Reports a failure once, and reopens the channel.
    fn note(&mut self, done: Result<(), WireError>) {
        let cause = done.err().map(|cause| cause.to_string());
        if let Some(cause) = &cause {
            self.writer = None;
            if self.said.as_ref() != Some(cause) {
                say(cause);
            }
            self.said = Some(cause.clone());
        }
    }
}
