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

/// How late the transport's timers may be. RustDDS has one for each of its writers (a heartbeat each second, where it is reliable, and some housekeeping) and for
/// some tasks; those within this time of each other are one waking, and stay together from then on. What it sends again it sends by a timer, too:
/// so not for who asks for that. What is published, and who listens, waits for none.
const TIMER_SLACK_NS: u64 = 100_000_000;
/// Messages that a reliable publisher keeps for those who missed some: two seconds at 30 in one.
const KEPT: usize = 64;

/// This process in the graph. It leaves when it is dropped.
pub(crate) struct Graph {
    // Dropped in this order: the node tells its spinner to end, which then is waited for; the context says goodbye last.
    node: Option<Node>,
    spinner: Option<JoinHandle<()>>,
    context: Context,
    /// The transport's, by their numbers.
    threads: Vec<PathBuf>,
    names: Names,
    reliable: bool,
    max_bytes: usize,
}

/// A publisher of one topic.
pub(crate) struct Topic {
    publisher: Publisher<Body>,
    name: String,
    /// Whether it was said that a message was too large.
    said: bool,
    /// Messages that found no room, or were too large.
    unsent: u64,
}

impl Graph {
    /// Enters the graph.
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

    /// A publisher of a topic, by its name within the namespace, of messages such as `sensor_msgs` `PointCloud2`.
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

    /// A subscription to a topic, by its name within the namespace, to what is made of its messages; and the topic's whole name.
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

    /// Makes the parameters these; those that are so already stay.
    pub(crate) fn set_parameters(&self, all: BTreeMap<String, ParameterValue>) {
        let Some(node) = &self.node else {
            return;
        };
        for known in node.list_parameters() {
            // What ROS has for every node is no setting.
            if known.contains('.') && !all.contains_key(&known) {
                node.undeclare_parameter(&known);
            }
        }
        for (name, value) in all {
            if node.get_parameter(&name).as_ref() != Some(&value) {
                // Whatever the chain says is taken.
                let _ = node.set_parameter(&name, value);
            }
        }
    }

    /// The types by which nodes publish a topic of this whole name, such as `sensor_msgs::msg::dds_::Image_`.
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

    /// Whether the transport still works: RustDDS 0.15 ends its threads without a word when a process that was stopped (Ctrl-Z, a
    /// debugger) goes on, as it takes the interrupted wait for a failure.
    pub(crate) fn is_alive(&self) -> bool {
        self.threads.iter().all(|thread| thread.exists())
    }

    /// Whether somebody listens.
    pub(crate) fn is_heard(&self, topic: &Topic) -> bool {
        let node = self.node.as_ref();
        node.is_some_and(|node| topic.publisher.get_subscription_count(node) > 0)
    }

    /// Whether somebody listens to a topic below this one, whether it is there or not.
    pub(crate) fn is_heard_below(&self, name: &str) -> bool {
        let below = format!("rt{}/", self.names.topic(name));
        let readers = self.context.domain_participant().discovered_readers();
        let mut names = readers
            .iter()
            .map(|reader| reader.subscription_topic_data.topic_name());
        names.any(|name| name.starts_with(&below))
    }

    /// Sends a message. One that is too large or finds no room among those that listeners have not taken is not sent, and counted.
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
    /// Messages that were not sent.
    pub(crate) fn unsent(&self) -> u64 {
        self.unsent
    }
}

impl Drop for Graph {
    fn drop(&mut self) {
        self.node = None;
        if let Some(spinner) = self.spinner.take() {
            // It has said what went wrong, if anything did.
            let _ = spinner.join();
        }
    }
}

/// How messages are received.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Delivery {
    /// Whether what is lost on the way is sent again; best-effort publishers are not matched then.
    pub(crate) reliable: bool,
    /// How many wait for this process.
    pub(crate) kept: usize,
}

/// The threads of this process.
fn threads() -> Result<Vec<PathBuf>> {
    let listed = fs::read_dir("/proc/self/task")?.map(|entry| Ok(entry?.path()));
    listed.collect()
}

/// Makes something, whose threads have timers that may be late, if they may.
fn with_timer_slack<T>(may_be_late: bool, make: impl FnOnce() -> T) -> T {
    // A thread has that of the one that started it. Where the kernel has none, timers are as they are.
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
        // Nobody waits for a listener: what it does not take is told of, and the chain is read on.
        qos.reliability_reliable(WhenFull::Fail)
            .history(History::KeepLast { depth: KEPT })
    } else {
        qos.reliability_best_effort()
            .history(History::KeepLast { depth: 5 })
    }
}

/// A name with nothing but what ROS allows in one: letters, digits and `_`, no digit first.
pub(crate) fn in_ros(name: &str) -> String {
    let allowed = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(allowed).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) {
        return format!("_{name}");
    }
    name
}

/// A message that is encoded already, with its head of four bytes, for a transport that would encode it.
struct Body(Vec<u8>);

impl Serialize for Body {
    /// As many numbers of eight bytes as there are, and then bytes: encoded by the same rules they are what they were, because
    /// the head is left out, and the first lies at a multiple of eight.
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
