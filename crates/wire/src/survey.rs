//! Which channels there are in a domain, and who is at their ends, without becoming a reader of any.

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::*;
use iceoryx2::service::Service;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::channel::{self, Payload, describe};
use crate::{Domain, Rig, WireError, memory, tidy};

/// A channel of a rig, as it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelState {
    /// The rig.
    pub rig: Rig,
    /// The channel's name on it: `frames`, `masks`, `centerlines`, `descriptors`, `truth` or `commands`.
    pub channel: &'static str,
    /// The versioned name of the messages that it carries.
    pub message: String,
    /// The one that this program was made for.
    pub ours: String,
    /// Whether its writer waits for slow readers.
    pub lossless: bool,
    /// How many messages may wait for a reader.
    pub buffer: usize,
    /// How many readers there can be.
    pub most_readers: usize,
    /// Who is there; `None` if that cannot be told, as it carries messages of another version.
    pub ends: Option<ChannelEnds>,
}

/// Who is at the ends of a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelEnds {
    /// The writer, if it is there.
    pub writer: Option<ChannelWriter>,
    /// The process of each reader, in ascending order: one that reads twice is there twice.
    pub readers: Vec<u32>,
}

/// The writer of a channel, and the shared memory of its messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelWriter {
    /// Its process.
    pub pid: u32,
    /// How many messages there is room for.
    pub slots: usize,
    /// Bytes of the largest message, without what stands beside it.
    pub message_bytes: usize,
    /// Bytes of shared memory that all slots take.
    pub shared_bytes: u64,
}

impl Domain {
    /// The channels that some process has open, by rig and in the order of a frame's way. None is made or held.
    ///
    /// # Errors
    /// The transport's folder cannot be read.
    pub fn channels(&self) -> Result<Vec<ChannelState>, WireError> {
        let mut found = Vec::new();
        let passing = self.door.pass()?;
        tidy::remove_half_made(self.config(), &passing);
        let listed = ipc::Service::list(self.config(), |service| {
            found.extend(place_of(service.static_details.name().as_str()));
            CallbackProgression::Continue
        });
        listed.map_err(|cause| WireError::transport("listing the channels", cause))?;
        found.sort_by(|a: &(Rig, usize), b| (a.0.as_str(), a.1).cmp(&(b.0.as_str(), b.1)));
        // A channel and its bell are two services.
        found.dedup();
        let states = found
            .iter()
            .filter_map(|(rig, place)| self.state(rig, channel::ALL[*place].name));
        Ok(states.collect())
    }

    /// One channel of a rig as it is; `None` if no process has it open, or there is none of that name.
    pub fn channel(&self, rig: &Rig, name: &str) -> Option<ChannelState> {
        let passing = self.door.pass().ok()?;
        tidy::remove_half_made(self.config(), &passing);
        self.state(rig, name)
    }

    /// To be called while passing: it opens the channel for a moment.
    fn state(&self, rig: &Rig, name: &str) -> Option<ChannelState> {
        let channel = channel::ALL.iter().find(|known| known.name == name)?;
        let name = ServiceName::new(&format!("lariat/{rig}/{name}")).ok()?;
        let details =
            ipc::Service::details(&name, self.config(), MessagingPattern::PublishSubscribe)
                .ok()??;
        let kept = details.static_details.publish_subscribe();
        let types = kept.message_type_details();
        let message = describe(&types.payload, &types.user_header);
        let ours = (channel.types)();
        // Opened as another type, it would be refused.
        let ends = (message == ours)
            .then(|| (channel.ends)(self, &name))
            .flatten();
        Some(ChannelState {
            rig: rig.clone(),
            channel: channel.name,
            message,
            ours,
            lossless: !kept.has_safe_overflow(),
            buffer: kept.subscriber_max_buffer_size(),
            most_readers: kept.max_subscribers(),
            ends,
        })
    }
}

/// The rig and the place among [all channels](channel::ALL) that a service's name stands for, if it is one of lariat's.
fn place_of(service: &str) -> Option<(Rig, usize)> {
    let (rig, channel) = service.strip_prefix("lariat/")?.split_once('/')?;
    let channel = channel.strip_suffix("-ready").unwrap_or(channel);
    let place = channel::ALL
        .iter()
        .position(|known| known.name == channel)?;
    Some((rig.parse().ok()?, place))
}

/// Who is at the ends of a channel whose messages are of elements of so many bytes.
pub(crate) fn ends_of<P: Payload + ?Sized>(
    service: &PortFactory<ipc::Service, P, P::Header>,
    element: usize,
) -> ChannelEnds {
    let dynamic = service.dynamic_config();
    let mut readers = Vec::new();
    dynamic.list_subscribers(|reader| {
        readers.push(process(&reader.node_id));
        CallbackProgression::Continue
    });
    readers.sort_unstable();
    let mut writer = None;
    dynamic.list_publishers(|publisher| {
        writer = Some(ChannelWriter {
            pid: process(&publisher.node_id),
            slots: publisher.number_of_samples,
            // Of a message of one size the transport says: one element.
            message_bytes: publisher.max_slice_len * element,
            shared_bytes: memory::segment_bytes(&publisher.publisher_id.value().to_string()),
        });
        CallbackProgression::Stop
    });
    ChannelEnds { writer, readers }
}

/// The process that a node is of; 0 if its number does not say.
fn process(node: &UniqueNodeId) -> u32 {
    let pid = node.pid::<ipc::Service>().map_or(0, |pid| pid.value());
    u32::try_from(pid).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FRAMES;

    #[test]
    fn a_channel_and_its_bell_are_known_by_their_names_and_nothing_else_is() {
        let place = |name: &str| place_of(name).map(|(rig, place)| (rig.to_string(), place));
        let rig = Rig::default();
        for (place_expected, name) in channel::ALL.iter().map(|known| known.name).enumerate() {
            let full = format!("lariat/{rig}/{name}");
            assert_eq!(place(&full), Some(("default".into(), place_expected)));
            assert_eq!(place(&format!("{full}-ready")), place(&full));
        }
        assert_eq!(FRAMES.on(&rig), "lariat/default/frames");
        for other in [
            "lariat/default/",
            "lariat/A/frames",
            "other/default/frames",
            "lariat/frames",
        ] {
            assert_eq!(place(other), None, "{other}");
        }
    }
}
