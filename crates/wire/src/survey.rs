//! Which channels there are in a domain, and who is at their ends, without becoming a reader of any.

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::*;
use iceoryx2::service::Service;
use iceoryx2::service::port_factory::PortFactory;

use crate::channel::{CENTERLINES, COMMANDS, DESCRIPTORS, FRAMES, MASKS, Payload, TRUTH, describe};
use crate::{Centerlines, Command, Descriptors, Domain, FrameHeader, Rig, WireError, memory};

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

/// All channels of a rig, in the order of a frame's way.
const NAMES: [&str; 6] = [
    FRAMES.name(),
    MASKS.name(),
    CENTERLINES.name(),
    DESCRIPTORS.name(),
    TRUTH.name(),
    COMMANDS.name(),
];

impl Domain {
    /// The channels that some process has open, by rig and in the order of a frame's way. None is made or held.
    ///
    /// # Errors
    /// The transport's folder cannot be read.
    pub fn channels(&self) -> Result<Vec<ChannelState>, WireError> {
        let mut found = Vec::new();
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
            .filter_map(|(rig, place)| self.channel(rig, NAMES[*place]));
        Ok(states.collect())
    }

    /// One channel of a rig as it is; `None` if no process has it open, or there is none of that name.
    pub fn channel(&self, rig: &Rig, name: &str) -> Option<ChannelState> {
        let channel = NAMES.into_iter().find(|known| *known == name)?;
        let name = ServiceName::new(&format!("lariat/{rig}/{channel}")).ok()?;
        let details =
            ipc::Service::details(&name, self.config(), MessagingPattern::PublishSubscribe)
                .ok()??;
        let kept = details.static_details.publish_subscribe();
        let types = kept.message_type_details();
        let message = describe(&types.payload, &types.user_header);
        let images = [FRAMES.name(), MASKS.name()].contains(&channel);
        let (ours, ends): (_, fn(&Self, &ServiceName) -> _) = if images {
            (<[u8]>::types(), ends_of_images)
        } else if channel == DESCRIPTORS.name() {
            (Descriptors::types(), ends_of_descriptors)
        } else if channel == COMMANDS.name() {
            (Command::types(), ends_of_commands)
        } else {
            (Centerlines::types(), ends_of_centerlines)
        };
        // Opened as another type, it would be refused.
        let ends = (message == ours).then(|| ends(self, &name)).flatten();
        Some(ChannelState {
            rig: rig.clone(),
            channel,
            message,
            ours,
            lossless: !kept.has_safe_overflow(),
            buffer: kept.subscriber_max_buffer_size(),
            most_readers: kept.max_subscribers(),
            ends,
        })
    }
}

/// The rig and the place among [`NAMES`] that a service's name stands for, if it is one of lariat's.
fn place_of(service: &str) -> Option<(Rig, usize)> {
    let (rig, channel) = service.strip_prefix("lariat/")?.split_once('/')?;
    let channel = channel.strip_suffix("-ready").unwrap_or(channel);
    let place = NAMES.iter().position(|name| *name == channel)?;
    Some((rig.parse().ok()?, place))
}

macro_rules! ends_of {
    ($function:ident, $payload:ty, $header:ty) => {
        fn $function(domain: &Domain, name: &ServiceName) -> Option<ChannelEnds> {
            let builder = domain.node.service_builder(name);
            let service = builder
                .publish_subscribe::<$payload>()
                .user_header::<$header>()
                .open()
                .ok()?;
            let dynamic = service.dynamic_config();
            let mut readers = Vec::new();
            dynamic.list_subscribers(|reader| {
                readers.push(process(&reader.node_id));
                CallbackProgression::Continue
            });
            readers.sort_unstable();
            let mut writer = None;
            dynamic.list_publishers(|publisher| {
                // Of a message of one size the transport says: one element.
                let element = size_of::<<$payload as Elements>::Element>();
                writer = Some(ChannelWriter {
                    pid: process(&publisher.node_id),
                    slots: publisher.number_of_samples,
                    message_bytes: publisher.max_slice_len * element,
                    shared_bytes: memory::segment_bytes(
                        &publisher.publisher_id.value().to_string(),
                    ),
                });
                CallbackProgression::Stop
            });
            Some(ChannelEnds { writer, readers })
        }
    };
}
ends_of!(ends_of_images, [u8], FrameHeader);
ends_of!(ends_of_centerlines, Centerlines, ());
ends_of!(ends_of_descriptors, Descriptors, ());
ends_of!(ends_of_commands, Command, ());

/// What the transport counts the length of a message in.
trait Elements {
    type Element;
}
impl Elements for [u8] {
    type Element = u8;
}
impl Elements for Centerlines {
    type Element = Self;
}
impl Elements for Descriptors {
    type Element = Self;
}
impl Elements for Command {
    type Element = Self;
}

/// The process that a node is of; 0 if its number does not say.
fn process(node: &UniqueNodeId) -> u32 {
    let pid = node.pid::<ipc::Service>().map_or(0, |pid| pid.value());
    u32::try_from(pid).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_and_its_bell_are_known_by_their_names_and_nothing_else_is() {
        let place = |name: &str| place_of(name).map(|(rig, place)| (rig.to_string(), place));
        let rig = Rig::default();
        for (place_expected, name) in NAMES.iter().enumerate() {
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
