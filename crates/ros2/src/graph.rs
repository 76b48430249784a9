//! The node, its publishers and its subscriptions.

use std::collections::BTreeMap;
use std::fs;
use std::net::Ipv4Addr;
use std::num::NonZeroU64;
use std::path::PathBuf;
use std::thread::JoinHandle;

use anyhow::{Context as _, Result, anyhow};
use ros2_client::dds::rustdds::{DomainParticipantBuilder, Topic as RosTopic};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, MessageTypeName, Name, Node, NodeName, ParameterValue, Publisher, QosProfile,
    Subscription,
};
use rustix::thread::{current_timer_slack, set_current_timer_slack};
use serde::ser::{Serialize, SerializeTuple, Serializer};

use crate::args::{Args, Names};
use crate::parameters;

/// Timer slack of the transport's threads. RustDDS has one timer per writer (housekeeping, and a
/// heartbeat each second if reliable) and some for other tasks. Timers that differ by less than
/// this time expire in one wakeup and then stay together. Retransmission uses a timer too, so exact
/// timers are kept for reliable delivery. Publishing and discovery do not wait for a timer.
const TIMER_SLACK_NS: u64 = 100_000_000;
/// Messages that a reliable publisher keeps for retransmission: two seconds at 30 fps.
const KEPT: usize = 64;

/// This process in the graph. Dropping it leaves the graph.
pub(crate) struct Graph {
    // Dropped in this order: the node stops its spinner, whose thread is then joined; the context
    // leaves last.
    node: Option<Node>,
    spinner: Option<JoinHandle<()>>,
    context: Context,
    /// Threads of the transport, as paths in `/proc`.
    threads: Vec<PathBuf>,
    names: Names,
    reliable: bool,
    max_bytes: usize,
}

/// A publisher of one topic.
pub(crate) struct Topic {
    publisher: Publisher<Body>,
    name: String,
    /// True after a message that is too large has been reported.
    said: bool,
    /// Number of messages that were too large or for which no space was free.
    unsent: u64,
}

impl Graph {
    /// Joins the graph.
    pub(crate) fn enter(args: &Args) -> Result<Self> {
        let id = args.domain_id()?;
        let about = || format!("the ROS 2 domain {id} could not be entered");
        let mut participant = DomainParticipantBuilder::new(id);
        if std::env::var("ROS_AUTOMATIC_DISCOVERY_RANGE").is_ok_and(|range| range == "LOCALHOST")
            || std::env::var("ROS_LOCALHOST_ONLY").is_ok_and(|only| only == "1")
        {
            participant = participant.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let before = threads()?;
        let participant = with_timer_slack(args.best_effort, || participant.build())
            .map_err(|e| anyhow!("{e}"))
            .with_context(about)?;
        let mut threads = threads()?;
        threads.retain(|thread| !before.contains(thread));
        let context = Context::from_domain_participant(participant)
            .map_err(|e| anyhow!("{e}"))
            .with_context(about)?;
        let usual = format!("lariat_{}", in_ros(args.rig.as_str()));
        let (namespace, name) = (args.names.namespace(), args.names.node(&usual));
        let node_name = NodeName::new(namespace, name)
            .map_err(|e| anyhow!("{namespace} and {name} are not valid names for a node: {e}"))?;
        let mut node = context
            .new_node(node_name, parameters::options(&args.rig))
            .map_err(|e| anyhow!("{e}"))
            .with_context(about)?;
        let spin = node
            .spinner()
            .map_err(|e| anyhow!("{e}"))
            .with_context(about)?;
        let spinner = std::thread::Builder::new()
            .name("ros-discovery".to_owned())
            .spawn(move || {
                if let Err(error) = futures::executor::block_on(spin.spin()) {
                    eprintln!("lariat-ros2: who listens is not known any more: {error}");
                }
            })?;
        Ok(Self {
            node: Some(node),
            spinner: Some(spinner),
            context,
            threads,
            names: args.names.clone(),
            reliable: !args.best_effort,
            max_bytes: args.max_bytes,
        })
    }

    /// Creates a publisher of a topic, by its name within the namespace, of messages such as
    /// `sensor_msgs` `PointCloud2`.
    pub(crate) fn publisher(&mut self, name: &str, package: &str, kind: &str) -> Result<Topic> {
        let name = self.names.topic(name);
        let qos = sent(self.reliable);
        let (topic, node) = self.topic(&name, package, kind, &qos)?;
        let publisher = node
            .create_publisher(&topic, None)
            .map_err(|e| anyhow!("{e}"))
            .with_context(|| failure(&name))?;
        Ok(Topic {
            publisher,
            name,
            said: false,
            unsent: 0,
        })
    }

    /// Creates a subscription to a topic, by its name within the namespace. Also returns the
    /// topic's full name.
    pub(crate) fn subscription<M: 'static>(
        &mut self,
        name: &str,
        package: &str,
        kind: &str,
        delivery: Delivery,
    ) -> Result<(String, Subscription<M>)> {
        let name = self.names.topic(name);
        let (topic, node) = self.topic(&name, package, kind, &received(delivery))?;
        let subscription = node
            .create_subscription(&topic, None)
            .map_err(|e| anyhow!("{e}"))
            .with_context(|| failure(&name))?;
        Ok((name, subscription))
    }

    fn topic(
        &mut self,
        name: &str,
        package: &str,
        kind: &str,
        qos: &QosProfile,
    ) -> Result<(RosTopic, &mut Node)> {
        let ros_name = Name::parse(name)
            .map_err(|e| anyhow!("{e:?}"))
            .with_context(|| failure(name))?;
        let node = self.node.as_mut().context("the graph was left")?;
        let topic = node
            .create_topic(&ros_name, MessageTypeName::new(package, kind), qos)
            .map_err(|e| anyhow!("{e}"))
            .with_context(|| failure(name))?;
        Ok((topic, node))
    }

    /// Sets the node's parameters; unchanged ones stay.
    pub(crate) fn set_parameters(&self, all: BTreeMap<String, ParameterValue>) {
        let Some(node) = &self.node else {
            return;
        };
        for known in node.list_parameters() {
            // ROS's own parameters of every node are not settings.
            if known.contains('.') && !all.contains_key(&known) {
                node.undeclare_parameter(&known);
            }
        }
        for (name, value) in all {
            if node.get_parameter(&name).as_ref() != Some(&value) {
                // The chain's values are always accepted.
                let _ = node.set_parameter(&name, value);
            }
        }
    }

    /// Types under which nodes publish a topic of this full name, such as
    /// `sensor_msgs::msg::dds_::Image_`.
    pub(crate) fn published(&self, topic: &str) -> Vec<String> {
        let name = format!("rt{topic}");
        let writers = self.context.domain_participant().discovered_writers();
        let data = writers
            .into_iter()
            .map(|writer| writer.publication_topic_data);
        data.filter(|data| data.topic_name == name)
            .map(|data| data.type_name)
            .collect()
    }

    /// Returns whether the transport still works. When a process is suspended (Ctrl-Z, a debugger)
    /// and continues, RustDDS 0.15 silently ends its threads, because it treats the interrupted
    /// wait as a failure.
    pub(crate) fn is_alive(&self) -> bool {
        self.threads.iter().all(|thread| thread.exists())
    }

    /// Returns whether the topic has a subscriber.
    pub(crate) fn is_heard(&self, topic: &Topic) -> bool {
        let node = self.node.as_ref();
        node.is_some_and(|node| topic.publisher.get_subscription_count(node) > 0)
    }

    /// Returns whether a topic below this name has a subscriber, whether or not the topic exists.
    pub(crate) fn is_heard_below(&self, name: &str) -> bool {
        let below = format!("rt{}/", self.names.topic(name));
        let readers = self.context.domain_participant().discovered_readers();
        let mut names = readers
            .iter()
            .map(|reader| reader.subscription_topic_data.topic_name());
        names.any(|name| name.starts_with(&below))
    }

    /// Sends a message. A message is counted but not sent if it is too large, or if subscribers
    /// have not taken enough of the earlier ones.
    pub(crate) fn send(&self, topic: &mut Topic, message: &[u8]) {
        if message.len() > self.max_bytes {
            topic.unsent += 1;
            if !std::mem::replace(&mut topic.said, true) {
                eprintln!(
                    "lariat-ros2: a message of {} bytes for {} is not sent, nor are others over {}: give the chain a smaller \
                     picture, or say --max-bytes",
                    message.len(),
                    topic.name,
                    self.max_bytes
                );
            }
            return;
        }
        if topic.publisher.publish(Body(message.to_vec())).is_err() {
            topic.unsent += 1;
        }
    }
}

impl Topic {
    /// Number of messages that were not sent.
    pub(crate) fn unsent(&self) -> u64 {
        self.unsent
    }
}

impl Drop for Graph {
    fn drop(&mut self) {
        self.node = None;
        if let Some(spinner) = self.spinner.take() {
            // The thread has already reported its error, if there was one.
            let _ = spinner.join();
        }
    }
}

/// Delivery of received messages.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Delivery {
    /// True if lost messages are sent again; best-effort publishers are then not matched.
    pub(crate) reliable: bool,
    /// Number of messages that may wait for this process.
    pub(crate) kept: usize,
}

/// Threads of this process.
fn threads() -> Result<Vec<PathBuf>> {
    let listed = fs::read_dir("/proc/self/task")?.map(|entry| Ok(entry?.path()));
    listed.collect()
}

/// Runs `make` with timer slack for the threads that it starts, if `may_be_late`.
fn with_timer_slack<T>(may_be_late: bool, make: impl FnOnce() -> T) -> T {
    // A thread inherits the slack of the one that started it. Without support in the kernel, timers
    // stay exact.
    let usual = current_timer_slack().ok();
    if may_be_late && usual.is_some() {
        let _ = set_current_timer_slack(NonZeroU64::new(TIMER_SLACK_NS));
    }
    let made = make();
    let _ = set_current_timer_slack(usual.and_then(NonZeroU64::new));
    made
}

fn failure(topic: &str) -> String {
    format!("the topic {topic} could not be made")
}

fn received(Delivery { reliable, kept }: Delivery) -> QosProfile {
    let qos = QosProfile::subscription_default().history(History::KeepLast { depth: kept });
    if reliable {
        qos.reliability_reliable(WhenFull::Fail)
    } else {
        qos
    }
}

fn sent(reliable: bool) -> QosProfile {
    let qos = QosProfile::publisher_default().durability(Durability::Volatile);
    if reliable {
        // Never wait for a subscriber: count what it does not take, and continue to read the chain.
        qos.reliability_reliable(WhenFull::Fail)
            .history(History::KeepLast { depth: KEPT })
    } else {
        qos.reliability_best_effort()
            .history(History::KeepLast { depth: 5 })
    }
}

/// Converts a name to what ROS allows: letters, digits and `_`, not starting with a digit.
pub(crate) fn in_ros(name: &str) -> String {
    let allowed = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(allowed).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) {
        return format!("_{name}");
    }
    name
}

/// A message that is already encoded, with its four-byte header, for a transport that would encode
/// it again.
struct Body(Vec<u8>);

impl Serialize for Body {
    /// Serializes as many eight-byte numbers as fit, and then single bytes. The result equals the
    /// encoded message, because the header is left out and the first number is aligned to eight.
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let body = self.0.get(4..).unwrap_or_default();
        let (words, rest) = body.as_chunks::<8>();
        let mut tuple = to.serialize_tuple(words.len() + rest.len())?;
        for word in words {
            tuple.serialize_element(&u64::from_le_bytes(*word))?;
        }
        for byte in rest {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_rigs_become_names_of_ros() {
        assert_eq!(in_ros("left"), "left");
        assert_eq!(in_ros("cell-2.b"), "cell_2_b");
        assert_eq!(in_ros("2nd"), "_2nd");
    }
}
