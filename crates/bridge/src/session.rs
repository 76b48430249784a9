//! zenoh: a session that listens or connects, and nothing else: no scouting, no gossip, no shared memory.
//!
//! Everything that goes one way goes under one key: `lariat/<rig>/descriptors` from the camera's machine, `lariat/<rig>/commands` back. (Frames have
//! a session of their own.) Over plain UDP zenoh's own declarations may be lost like any datagram, and are not sent again: a subscription that never
//! arrived would be silence for ever. With one key, answers to questions come only if descriptors would; and who hears no answer makes its session
//! anew (`far`), which declares everything anew.

use anyhow::{Result, anyhow};
use lariat_wire::{Rig, now_ns};
use zenoh::key_expr::KeyExpr;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::Sample;
use zenoh::{Config, Session, Wait};

/// So long does who sends wait until zenoh's thread, which has no core just now, has made room. An answer waits likewise, and is still in time for
/// its question.
const WAIT_US: u32 = 100_000;

/// What goes which way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// From the camera's machine.
    Down,
    /// To it.
    Up,
    /// From it, on the session of frames.
    Pictures,
}

impl Way {
    fn key(self, rig: &Rig) -> Result<KeyExpr<'static>> {
        let channel = match self {
            Self::Down => "descriptors",
            Self::Up => "commands",
            Self::Pictures => "frames",
        };
        KeyExpr::new(format!("lariat/{rig}/{channel}")).map_err(told)
    }
}

/// A session, and where it sends to.
#[derive(Clone)]
pub(crate) struct Wire {
    session: Session,
    to: KeyExpr<'static>,
}

/// How a session comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Open {
    Listen,
    Connect,
}

impl Wire {
    /// Listens at a place, or connects to it: tried once, for 0.4 s. It sends one way.
    ///
    /// # Errors
    /// It cannot be listened there, or nobody answers.
    pub(crate) fn open(how: Open, place: &str, sends: Way, rig: &Rig) -> Result<Self> {
        let place = format!("{place:?}");
        let (listen, connect) = match how {
            Open::Listen => (place.as_str(), ""),
            Open::Connect => ("", place.as_str()),
        };
        // A transport of which nothing is heard is given up after 2 s: by then the far side has long made another. As many descriptors wait for
        // zenoh's thread as it can keep, should that have no core for a while: two, which it keeps by itself, are 2 ms of a camera of 1000 Hz. When it
        // keeps no more, who sends waits: what comes meanwhile waits in shared memory, where the newest wins. zenoh by itself drops it after 1 ms. (Its
        // transport of low latency sends from the thread that asks for it, and saves a third of the way. But it sends each declaration by itself, and
        // on a link that reorders one without the other is no subscription.)
        let config = Config::from_json5(&format!(
            "{{ mode: 'peer',
                listen: {{ endpoints: [{listen}], timeout_ms: 0, exit_on_failure: true }},
                connect: {{ endpoints: [{connect}], timeout_ms: 0, exit_on_failure: true }},
                open: {{ return_conditions: {{ connect_scouted: false, declares: false }} }},
                scouting: {{ multicast: {{ enabled: false }}, gossip: {{ enabled: false }} }},
                transport: {{
                    unicast: {{ open_timeout: 400, accept_timeout: 1000 }},
                    link: {{ tx: {{ lease: 2000, keep_alive: 4, queue: {{ size: {{ real_time: 16 }},
                        congestion_control: {{ drop: {{ wait_before_drop: {WAIT_US} }} }} }} }} }} }} }}"
        ));
        let session = zenoh::open(config.map_err(told)?).wait().map_err(told)?;
        Ok(Self {
            session,
            to: sends.key(rig)?,
        })
    }

    /// Has everything heard that comes one way: `hear` is told the moment and the bytes, in one of zenoh's threads.
    ///
    /// # Errors
    /// zenoh's.
    pub(crate) fn hear(
        &self,
        way: Way,
        rig: &Rig,
        hear: impl Fn(u64, &Sample) + Send + Sync + 'static,
    ) -> Result<()> {
        let heard = move |sample: Sample| hear(now_ns(), &sample);
        let subscriber = self
            .session
            .declare_subscriber(way.key(rig)?)
            .callback(heard)
            .background();
        subscriber.wait().map_err(told)
    }

    /// Sends a datagram at once, before all of a lesser priority. What there is no room for is lost, as on the way.
    pub(crate) fn put(&self, datagram: &[u8], priority: Priority) {
        let put = self.session.put(&self.to, datagram);
        let put = put
            .priority(priority)
            .congestion_control(CongestionControl::Drop)
            .express(true);
        // A session that has ended says nothing more: silence is what the other side goes by.
        let _ = put.wait();
    }

    /// Ends the session.
    pub(crate) fn close(self) {
        let _ = self.session.close().wait();
    }
}

/// The bytes of a sample, part by part.
pub(crate) fn parts(sample: &Sample) -> impl Iterator<Item = &[u8]> {
    sample.payload().slices()
}

fn told(cause: zenoh::Error) -> anyhow::Error {
    let text = cause.to_string();
    // zenoh says in which line of its source it was.
    let text = text.split(" at /").next().unwrap_or(&text);
    anyhow!("{}", text.trim_end_matches('.'))
}
