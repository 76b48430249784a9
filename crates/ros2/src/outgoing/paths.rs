//! The topics of single ropes.

use anyhow::Result;
use lariat_wire::{Descriptors, MAX_CURVES, Status, now_ns};

use crate::graph::{Graph, Topic};
use crate::messages::{self, Header, Rope};

/// Maximum number of topics: as many as a message has ropes.
const MOST: usize = MAX_CURVES;
/// Time without observation after which a rope's topic is removed.
const ENDS_NS: u64 = 60_000_000_000;

/// A topic for each recently observed rope.
pub(super) struct Paths {
    prefix: String,
    paths: Vec<Path>,
}

struct Path {
    track: u32,
    topic: Topic,
    seen_ns: u64,
}

impl Paths {
    /// Topics of a rig with this prefix.
    pub(super) fn of(prefix: &str) -> Self {
        Self {
            prefix: format!("{prefix}/path"),
            paths: Vec::new(),
        }
    }

    /// Common prefix of their names.
    pub(super) fn prefix(&self) -> &str {
        &self.prefix
    }

    pub(super) fn topics(&self) -> impl Iterator<Item = &Topic> {
        self.paths.iter().map(|path| &path.topic)
    }

    /// Creates the topics of new ropes. This happens before anything is sent, so that a subscriber
    /// that receives a message finds all topics.
    pub(super) fn make(&mut self, graph: &mut Graph, message: &Descriptors) -> Result<()> {
        let now_ns = now_ns();
        for rope in message.curves() {
            if rope.status() == Some(Status::Lost) {
                continue;
            }
            let known = self.paths.iter().position(|path| path.track == rope.track);
            let place = match known {
                Some(place) => place,
                // In RustDDS 0.15, creating a writer deadlocks once its threads have ended.
                None if self.paths.len() < MOST && graph.is_alive() => {
                    let name = format!("{}/rope_{}", self.prefix, rope.track);
                    let topic = graph.publisher(&name, "nav_msgs", "Path")?;
                    self.paths.push(Path {
                        track: rope.track,
                        topic,
                        seen_ns: now_ns,
                    });
                    self.paths.len() - 1
                }
                None => continue,
            };
            self.paths[place].seen_ns = now_ns;
        }
        self.paths
            .retain(|path| now_ns.saturating_sub(path.seen_ns) < ENDS_NS);
        Ok(())
    }

    /// Publishes the ropes' curves to the subscribers.
    pub(super) fn send(
        &mut self,
        graph: &Graph,
        ropes: &[Rope],
        header: &Header,
        buffer: &mut Vec<u8>,
    ) {
        for rope in ropes {
            let known = self.paths.iter_mut().find(|path| path.track == rope.track);
            if let Some(path) = known
                && graph.is_heard(&path.topic)
            {
                messages::path(rope, header, buffer);
                graph.send(&mut path.topic, buffer);
            }
        }
    }
}
