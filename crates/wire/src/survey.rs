//! Lists the channels of a domain and the processes at their ends, without becoming a reader.

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::*;
use iceoryx2::service::Service;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::channel::{self, Payload, describe};
use crate::{Domain, Rig, WireError, memory, tidy};

/// State of a channel of a rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelState {
    /// The rig.
    pub rig: Rig,
    /// Name of the channel: `frames`, `masks`, `centerlines`, `descriptors`, `truth` or `commands`.
    pub channel: &'static str,
    /// Versioned name of the messages that it carries.
    pub message: String,
    /// Versioned name of the messages that this program expects.
    pub ours: String,
    /// True if its writer waits for slow readers.
    pub lossless: bool,
    /// Maximum number of messages that wait for a reader.
    pub buffer: usize,
    /// Maximum number of readers.
    pub most_readers: usize,
    /// Processes at its ends; `None` if unknown, because it carries messages of another version.
    pub ends: Option<ChannelEnds>,
}

/// Processes at the ends of a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelEnds {
    /// The writer, if there is one.
    pub writer: Option<ChannelWriter>,
    /// Process ID of each reader, in ascending order. A process with two readers appears twice.
    pub readers: Vec<u32>,
}

/// Writer of a channel, and the shared memory of its messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelWriter {
    /// Process ID.
    pub pid: u32,
    /// Number of messages that fit.
    pub slots: usize,
    /// Size of the largest message in bytes, without its header.
    pub message_bytes: usize,
    /// Shared memory of all slots in bytes.
    pub shared_bytes: u64,
}

impl Domain {
    /// The channels that any process has open, by rig and in the order in which a frame passes
    /// them. This call neither creates a channel nor keeps it open.
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
        // A channel and its event service are two services.
        found.dedup();
        let states = found
            .iter()
            .filter_map(|(rig, place)| self.state(rig, channel::ALL[*place].name));
        Ok(states.collect())
    }

    /// State of one channel of a rig; `None` if no process has it open, or the name is unknown.
    pub fn channel(&self, rig: &Rig, name: &str) -> Option<ChannelState> {
        let passing = self.door.pass().ok()?;
        tidy::remove_half_made(self.config(), &passing);
        self.state(rig, name)
    }

    /// Opens the channel for a moment; the caller must hold the door's pass.
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
        // Opening it as another type would fail.
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

/// The rig and the index into [all channels](channel::ALL) of a service's name, if it belongs to
/// lariat.
fn place_of(service: &str) -> Option<(Rig, usize)> {
    let (rig, channel) = service.strip_prefix("lariat/")?.split_once('/')?;
    let channel = channel.strip_suffix("-ready").unwrap_or(channel);
    let place = channel::ALL
        .iter()
        .position(|known| known.name == channel)?;
    Some((rig.parse().ok()?, place))
}

/// Processes at the ends of a channel whose messages consist of elements of this many bytes.
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
            // For a message of fixed size, the transport reports one element.
            message_bytes: publisher.max_slice_len * element,
            shared_bytes: memory::segment_bytes(&publisher.publisher_id.value().to_string()),
        });
        CallbackProgression::Stop
    });
    ChannelEnds { writer, readers }
}

/// Process ID of a node; 0 if it is not known.
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
