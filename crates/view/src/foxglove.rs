//! Foxglove's protocol, which its own app, Lichtblick and libraries in several languages speak. It
//! serves the rig's messages as channels, with the schemas and the encoding of recordings
//! (`lariat_record`). It also serves the latency of each frame as JSON, to be plotted.
//!
//! In [the protocol](https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md), the server
//! advertises channels and the client subscribes to some. Messages are binary. Clients cannot write
//! anything. Newest wins: a client gets the next moment when it has received the previous one, and
//! only channels that it has subscribed to are encoded.

use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::time::Duration;

use lariat_record::{
    Clock, ENCODING, Record, SCHEMA_ENCODING, Topic, encode_compressed_image,
    encode_control_points, encode_image, encode_ropes,
};
use lariat_wire::{Rig, Trace};
use serde::Deserialize;
use serde_json::{Value, json};
use tungstenite::Message;

use crate::hub::Watcher;
use crate::moment::Moment;
use crate::session::{Event, Session};
use crate::worker::Worker;

/// Names of the WebSocket protocol: the older one, and that of the app's newer releases. The parts
/// used here are the same.
pub(crate) const PROTOCOLS: [&str; 2] = ["foxglove.websocket.v1", "foxglove.sdk.v1"];
/// Longest sleep.
const LOOK: Duration = Duration::from_secs(5);
/// Maximum number of subscriptions of one client.
const MOST_SUBSCRIPTIONS: usize = 64;
/// First byte of a binary message with a channel's data.
const MESSAGE_DATA: u8 = 1;

/// A channel of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    /// A topic of recordings.
    Recorded(Topic),
    /// Duration of each step of a frame.
    Latency,
}

/// All channels; a channel's number is its index.
const CHANNELS: [Channel; 9] = [
    Channel::Recorded(Topic::Frames),
    Channel::Recorded(Topic::Image),
    Channel::Recorded(Topic::Picture),
    Channel::Recorded(Topic::Centerlines),
    Channel::Recorded(Topic::Descriptors),
    Channel::Recorded(Topic::Ropes),
    Channel::Recorded(Topic::ControlPoints),
    Channel::Recorded(Topic::Losses),
    Channel::Latency,
];

impl Channel {
    /// Returns the channel's advertisement.
    fn said(self, id: usize, rig: &str) -> Value {
        match self {
            Self::Recorded(topic) => {
                let schema = topic.schema();
                // In a recording, this topic has one kind of image. Here it has both.
                let more = if topic == Topic::Picture {
                    "/compressed"
                } else {
                    ""
                };
                json!({
                    "id": id, "topic": topic.on(rig) + more, "encoding": ENCODING,
                    "schemaName": schema.name, "schema": schema.text, "schemaEncoding": SCHEMA_ENCODING,
                })
            }
            Self::Latency => json!({
                "id": id, "topic": format!("/{rig}/latency"), "encoding": "json",
                "schemaName": "lariat.Latency", "schema": latency_schema(), "schemaEncoding": "jsonschema",
            }),
        }
    }

    /// True for channels of pictures, which take long to encode.
    fn is_picture(self) -> bool {
        matches!(self, Self::Recorded(Topic::Image | Topic::Picture))
    }

    /// Writes the channel's message of a moment into a buffer, which is cleared first. Returns its
    /// time; `None` if the moment has nothing for this channel.
    fn encode(self, moment: &Moment, rig: &str, clock: Clock, into: &mut Vec<u8>) -> Option<u64> {
        let shapes = &*moment.descriptors;
        let trace = &shapes.trace;
        let stamp_ns = clock.wall_ns(trace.exposed_ns);
        let Self::Recorded(topic) = self else {
            into.clear();
            into.extend(latency(trace).to_string().bytes());
            return Some(clock.wall_ns(trace.fitted_ns));
        };
        let at_ns = match topic {
            Topic::Frames => {
                moment.image.as_ref()?.header.encode(into);
                trace.captured_ns
            }
            Topic::Image => {
                let image = moment.image.as_ref()?;
                encode_image(&image.header, &image.bytes, stamp_ns, rig, into)
                    .then_some(trace.captured_ns)?
            }
            Topic::Picture => {
                encode_compressed_image(&moment.jpeg(1)?, "jpeg", stamp_ns, rig, into);
                trace.captured_ns
            }
            Topic::Centerlines => {
                let seen = moment.centerlines.as_deref()?;
                seen.encode(into);
                seen.trace.extracted_ns
            }
            Topic::Descriptors => {
                shapes.encode(into);
                trace.fitted_ns
            }
            Topic::Ropes => {
                let seen = moment.centerlines.as_deref()?;
                encode_ropes(seen, stamp_ns, into);
                trace.extracted_ns
            }
            Topic::ControlPoints => {
                encode_control_points(shapes, |point| moment.pixel(point), stamp_ns, into);
                trace.fitted_ns
            }
            Topic::Losses => {
                moment.losses.encode(into);
                moment.losses.at_ns
            }
            Topic::Masks | Topic::MaskImage | Topic::MaskPicture | Topic::Truth => return None,
            Topic::Depth | Topic::DepthImage | Topic::Descriptors3 => return None,
        };
        Some(clock.wall_ns(at_ns))
    }
}

/// The steps of a frame, in ms.
const STEPS: [&str; 6] = [
    "total",
    "capture",
    "wait_for_extract",
    "extract",
    "wait_for_fit",
    "fit",
];

fn latency(trace: &Trace) -> Value {
    let ms = |from: u64, to: u64| to.saturating_sub(from) as f64 / 1e6;
    let times = [
        ms(trace.exposed_ns, trace.fitted_ns),
        ms(trace.exposed_ns, trace.captured_ns),
        ms(trace.captured_ns, trace.extract_started_ns),
        ms(trace.extract_started_ns, trace.extracted_ns),
        ms(trace.extracted_ns, trace.fit_started_ns),
        ms(trace.fit_started_ns, trace.fitted_ns),
    ];
    let mut said = json!({ "frame": trace.sequence });
    for (step, time) in STEPS.iter().zip(times) {
        said[format!("{step}_ms")] = time.into();
    }
    said
}

fn latency_schema() -> String {
    let mut properties = json!({ "frame": { "type": "integer" } });
    for step in STEPS {
        properties[format!("{step}_ms")] = json!({ "type": "number" });
    }
    json!({ "title": "lariat.Latency", "type": "object", "properties": properties }).to_string()
}

/// Messages of a client that are handled.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
enum Said {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
    #[serde(other)]
    Other,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Subscription {
    id: u32,
    channel_id: usize,
}

/// The pictures of a moment, each for a subscription.
struct Pictures {
    moment: Arc<Moment>,
    wanted: Vec<Subscription>,
    rig: Rig,
    clock: Clock,
}

impl Pictures {
    fn messages(self) -> Vec<Message> {
        let mut encoded = Vec::new();
        let message = |subscription| {
            message_data(
                subscription,
                &self.moment,
                &self.rig,
                self.clock,
                &mut encoded,
            )
        };
        self.wanted.into_iter().filter_map(message).collect()
    }
}

/// Encodes a moment for a subscription, using `encoded` as a buffer; `None` if the moment has
/// nothing for the channel.
fn message_data(
    subscription: Subscription,
    moment: &Moment,
    rig: &Rig,
    clock: Clock,
    encoded: &mut Vec<u8>,
) -> Option<Message> {
    let channel = CHANNELS[subscription.channel_id];
    let at_ns = channel.encode(moment, rig.as_str(), clock, encoded)?;
    let mut message = Vec::with_capacity(13 + encoded.len());
    message.push(MESSAGE_DATA);
    message.extend(subscription.id.to_le_bytes());
    message.extend(at_ns.to_le_bytes());
    message.extend_from_slice(encoded);
    Some(Message::binary(message))
}

/// Serves one client, until it or the server ends.
pub(crate) fn run<S: Read + Write + AsFd>(mut session: Session<S>, watcher: &Watcher) {
    let Ok(worker) = Worker::start(watcher.bell(), Pictures::messages) else {
        return;
    };
    let mut client = Client {
        subscriptions: Vec::new(),
        rig: None,
        shown: 0,
        clock: Clock::now(),
        encoded: Vec::new(),
        worker,
    };
    let about = json!({
        "op": "serverInfo", "name": format!("lariat {}", env!("CARGO_PKG_VERSION")), "capabilities": [],
        "supportedEncodings": [], "metadata": {}, "sessionId": client.clock.wall_ns(lariat_wire::now_ns()).to_string(),
    });
    if !session.say(Message::text(about.to_string())) {
        return;
    }
    while !watcher.is_over() {
        match session.next(Some(watcher.as_fd()), LOOK) {
            Event::Text(text) => {
                let answer = client.hear(&text);
                if answer.is_some_and(|answer| !session.say(Message::text(answer.to_string()))) {
                    return;
                }
            }
            // Clients cannot publish here.
            Event::Binary(_) | Event::End => return,
            Event::News => watcher.hear(),
        }
        if session.is_clear() && !client.tell(&mut session, watcher) {
            return;
        }
    }
}

struct Client {
    subscriptions: Vec<Subscription>,
    /// The rig whose channels the client knows.
    rig: Option<Rig>,
    shown: u64,
    clock: Clock,
    encoded: Vec<u8>,
    worker: Worker<Pictures>,
}

impl Client {
    /// Handles a client's message. Returns the reply, if there is one.
    fn hear(&mut self, text: &str) -> Option<Value> {
        let warning =
            |message: String| Some(json!({ "op": "status", "level": 1, "message": message }));
        match serde_json::from_str(text) {
            Ok(Said::Subscribe { subscriptions }) => {
                for subscription in subscriptions {
                    if subscription.channel_id >= CHANNELS.len() {
                        return warning(format!(
                            "There is no channel {}.",
                            subscription.channel_id
                        ));
                    }
                    if self.subscriptions.len() >= MOST_SUBSCRIPTIONS {
                        return warning(format!(
                            "There are at most {MOST_SUBSCRIPTIONS} subscriptions."
                        ));
                    }
                    self.subscriptions
                        .retain(|known| known.id != subscription.id);
                    self.subscriptions.push(subscription);
                }
                None
            }
            Ok(Said::Unsubscribe { subscription_ids }) => {
                self.subscriptions
                    .retain(|known| !subscription_ids.contains(&known.id));
                None
            }
            Ok(Said::Other) => None,
            Err(_) => warning("This is not a message of the protocol.".to_owned()),
        }
    }

    /// Sends what is new. Returns false if the connection is over.
    fn tell<S: Read + Write + AsFd>(
        &mut self,
        session: &mut Session<S>,
        watcher: &Watcher,
    ) -> bool {
        let rig = watcher.rig();
        if rig.is_some() && rig != self.rig && !self.make_known(session, rig) {
            return false;
        }
        let Some(rig) = self.rig.as_ref().filter(|_| !self.subscriptions.is_empty()) else {
            return true;
        };
        if let Some(moment) = watcher.moment_after(self.shown) {
            self.shown = moment.number;
            let (pictures, others): (Vec<_>, Vec<_>) = (self.subscriptions.iter().copied())
                .partition(|wanted| CHANNELS[wanted.channel_id].is_picture());
            for wanted in others {
                let message = message_data(wanted, &moment, rig, self.clock, &mut self.encoded);
                if message.is_some_and(|message| !session.say(message)) {
                    return false;
                }
            }
            // Pictures of moments that come while others are encoded are left out.
            if !pictures.is_empty() && self.worker.is_idle() {
                let pictures = Pictures {
                    moment,
                    wanted: pictures,
                    rig: rig.clone(),
                    clock: self.clock,
                };
                if self.worker.add(pictures).is_none() {
                    return false;
                }
            }
        }
        while let Some(messages) = self.worker.next() {
            if !messages.into_iter().all(|message| session.say(message)) {
                return false;
            }
        }
        watcher.want();
        true
    }

    fn make_known<S: Read + Write + AsFd>(
        &mut self,
        session: &mut Session<S>,
        rig: Option<Rig>,
    ) -> bool {
        if self.rig.is_some() {
            self.subscriptions.clear();
            let ids: Vec<usize> = (0..CHANNELS.len()).collect();
            let gone = json!({ "op": "unadvertise", "channelIds": ids });
            if !session.say(Message::text(gone.to_string())) {
                return false;
            }
        }
        self.rig = rig;
        let name = self.rig.as_ref().map_or("", Rig::as_str);
        let channels: Vec<Value> = CHANNELS
            .iter()
            .enumerate()
            .map(|(id, channel)| channel.said(id, name))
            .collect();
        session.say(Message::text(
            json!({ "op": "advertise", "channels": channels }).to_string(),
        ))
    }
}
