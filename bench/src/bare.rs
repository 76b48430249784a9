//! The floor of every chain: 64 bytes forwarded by bare iceoryx2, with one publisher, one
//! subscriber and one event per link.
//!
//! It has no slots loaned in advance, no history, no counting, and no second descriptor to wait
//! for. Only the transport's own loan, send, notify, wake and receive remain. It serves
//! measurements only and carries no lariat messages.

use std::fmt;
use std::time::Duration;

use anyhow::{Result, anyhow};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use lariat_wire::Domain;

/// A forwarded message: 64 bytes, one cache line.
pub type RelayMessage = [u64; 8];

/// Maximum number of messages that wait for the receiver.
const WAITING: usize = 16;

fn name(link: usize, what: &str) -> Result<ServiceName> {
    let name = format!("lariat/relay/{link}{what}");
    ServiceName::new(&name).map_err(failed)
}

fn failed<E: fmt::Debug>(cause: E) -> anyhow::Error {
    anyhow!("cannot pass 64 bytes on: {cause:?}")
}

/// The sending end of a link.
#[derive(Debug)]
pub struct RelaySender {
    publisher: Publisher<ipc::Service, RelayMessage, ()>,
    notifier: Notifier<ipc::Service>,
}

impl RelaySender {
    /// Creates the sender of this link.
    ///
    /// # Errors
    /// The transport failed.
    pub fn create(domain: &Domain, link: usize) -> Result<Self> {
        domain.making(|node| {
            let publisher = data(node, link)?.publisher_builder().create();
            let notifier = event(node, link)?.notifier_builder().create();
            Ok(Self {
                publisher: publisher.map_err(failed)?,
                notifier: notifier.map_err(failed)?,
            })
        })?
    }

    /// Sends a message and wakes the receiver.
    ///
    /// # Errors
    /// The transport failed.
    pub fn send(&self, message: RelayMessage) -> Result<()> {
        let sample = self.publisher.loan_uninit().map_err(failed)?;
        sample.write_payload(message).send().map_err(failed)?;
        // This fails if the receiver is gone, which shows anyway as missing messages.
        let _ = self.notifier.notify();
        Ok(())
    }
}

/// The receiving end of a link.
#[derive(Debug)]
pub struct RelayReceiver {
    subscriber: Subscriber<ipc::Service, RelayMessage, ()>,
    listener: Listener<ipc::Service>,
}

impl RelayReceiver {
    /// Creates the receiver of this link.
    ///
    /// # Errors
    /// The transport failed.
    pub fn create(domain: &Domain, link: usize) -> Result<Self> {
        domain.making(|node| {
            let listener = event(node, link)?.listener_builder().create();
            let subscriber = data(node, link)?.subscriber_builder().create();
            Ok(Self {
                subscriber: subscriber.map_err(failed)?,
                listener: listener.map_err(failed)?,
            })
        })?
    }

    /// Returns the next message, sleeping until `timeout` expires. Returns `None` if no message
    /// arrived.
    ///
    /// # Errors
    /// The transport failed.
    pub fn next(&self, timeout: Duration) -> Result<Option<RelayMessage>> {
        if let Some(sample) = self.subscriber.receive().map_err(failed)? {
            return Ok(Some(*sample.payload()));
        }
        self.listener.timed_wait(|_| {}, timeout).map_err(failed)?;
        let sample = self.subscriber.receive().map_err(failed)?;
        Ok(sample.map(|sample| *sample.payload()))
    }
}

type Data =
    iceoryx2::service::port_factory::publish_subscribe::PortFactory<ipc::Service, RelayMessage, ()>;
type Event = iceoryx2::service::port_factory::event::PortFactory<ipc::Service>;

fn data(node: &Node<ipc::Service>, link: usize) -> Result<Data> {
    let service = node.service_builder(&name(link, "")?);
    let service = service
        .publish_subscribe::<RelayMessage>()
        .subscriber_max_buffer_size(WAITING)
        .max_publishers(1)
        .max_subscribers(1)
        .enable_safe_overflow(true);
    service.open_or_create().map_err(failed)
}

fn event(node: &Node<ipc::Service>, link: usize) -> Result<Event> {
    let service = node.service_builder(&name(link, "-ready")?);
    service.event().open_or_create().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_arrives_in_order() {
        let name = format!("r{}", std::process::id());
        let domain = Domain::named(&name).expect("a domain");
        let receiver = RelayReceiver::create(&domain, 0).expect("a receiver");
        let sender = RelaySender::create(&domain, 0).expect("a sender");
        for number in 0..3 {
            sender.send([number; 8]).expect("sent");
        }
        for number in 0..3 {
            let received = receiver.next(Duration::from_secs(10)).expect("readable");
            assert_eq!(received, Some([number; 8]));
        }
        let none = receiver.next(Duration::from_millis(1)).expect("readable");
        assert_eq!(none, None);
        drop((sender, receiver, domain));
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{name}"));
    }
}
