//! A channel of the local rig, read for as long as it has a writer.

use lariat_wire::{Channel, Domain, Message, Payload, Receiver, Rig, WireError};

/// How a reader learns of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Woken {
    Yes,
    /// The reader checks for messages when something else wakes it. It does not join a `--lossless`
    /// channel, whose writer would wait for it.
    No,
}

/// A reader that comes and goes with its writer. A reader that stayed would keep the old channel in
/// existence.
pub(crate) struct Read<P: Payload + ?Sized + 'static> {
    channel: &'static Channel<P>,
    woken: Woken,
    receiver: Option<Receiver<P>>,
    said: Option<String>,
}

impl<P: Payload + ?Sized> Read<P> {
    pub(crate) fn new(channel: &'static Channel<P>, woken: Woken) -> Self {
        Self {
            channel,
            woken,
            receiver: None,
            said: None,
        }
    }

    /// Opens the channel if it is wanted and has a writer, and closes it otherwise. Reports each
    /// obstacle once.
    pub(crate) fn follow(&mut self, domain: &Domain, rig: &Rig, wanted: bool) {
        let state = if wanted {
            domain.channel(rig, self.channel.name())
        } else {
            None
        };
        // If the channel has another version, its ends are unknown. Opening the channel reports
        // that.
        let written =
            state.filter(|state| state.ends.as_ref().is_none_or(|ends| ends.writer.is_some()));
        let opened = match (written, &self.receiver, self.woken) {
            (None, ..) => {
                self.receiver = None;
                Ok(())
            }
            (Some(_), Some(_), _) => Ok(()),
            (Some(_), None, Woken::Yes) => Receiver::create(domain, rig, self.channel, None)
                .map(|new| self.receiver = Some(new)),
            (Some(state), None, Woken::No) if state.lossless => Ok(()),
            (Some(_), None, Woken::No) => Receiver::create_unwoken(domain, rig, self.channel, None)
                .map(|new| self.receiver = Some(new)),
        };
        self.say(opened.err());
    }

    /// Returns the reader, while there is a writer.
    pub(crate) fn receiver(&self) -> Option<&Receiver<P>> {
        self.receiver.as_ref()
    }

    /// Returns the oldest waiting message. A reader that fails is closed, and opened again by the
    /// next [`follow`](Self::follow).
    pub(crate) fn next(&mut self) -> Option<Message<P>> {
        match self.receiver.as_ref()?.next() {
            Ok(message) => message,
            Err(cause) => {
                self.receiver = None;
                self.say(Some(cause));
                None
            }
        }
    }

    fn say(&mut self, cause: Option<WireError>) {
        let cause = cause.map(|cause| cause.to_string());
        if cause.is_some() && cause != self.said {
            crate::say(cause.as_deref().unwrap_or_default());
        }
        self.said = cause;
    }
}
