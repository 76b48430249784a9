//! Foxglove's protocol on the same port.

use std::collections::BTreeMap;
use std::net::TcpStream;

use lariat_record::{CompressedImageRecord, ImageRecord, Record};
use lariat_wire::{Centerlines, Descriptors};
use rustix::process::Signal;
use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Bytes, Message, WebSocket};

use crate::annotations::assert_polygons_end_where_ropes_do;
use crate::page::Page;
use crate::plane::make_plane;
use crate::rig::Bench;
use crate::viewing::Viewing;

/// A client that has subscribed to channels.
struct Client {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    /// Topics; a subscription's number is its topic's index plus 100.
    topics: Vec<String>,
}

impl Client {
    fn of(viewing: &Viewing, protocol: &str, wanted: impl Fn(&str) -> bool) -> Self {
        let page = Page::open(&viewing.url, None, protocol);
        let mut socket = page.expect("it is let in").0;
        let mut channels: Vec<Value> = loop {
            let Message::Text(text) = socket.read().expect("a message in time") else {
                panic!("nothing was subscribed to");
            };
            let mut said: Value = serde_json::from_str(&text).expect("JSON");
            if said["op"] == "advertise" {
                break serde_json::from_value(said["channels"].take()).expect("channels");
            }
            assert_eq!(said["op"], "serverInfo");
        };
        let topic = |channel: &Value| channel["topic"].as_str().expect("a topic").to_owned();
        channels.retain(|channel| wanted(&topic(channel)));
        let subscriptions: Vec<Value> = (channels.iter().zip(100..))
            .map(|(channel, id)| json!({"id": id, "channelId": channel["id"]}))
            .collect();
        let wish = json!({"op": "subscribe", "subscriptions": subscriptions});
        socket.send(Message::text(wish.to_string())).expect("sent");
        Self {
            socket,
            topics: channels.iter().map(topic).collect(),
        }
    }

    /// Returns the next message of any channel.
    fn next(&mut self) -> (String, Bytes) {
        loop {
            let Message::Binary(bytes) = self.socket.read().expect("a message in time") else {
                continue;
            };
            assert_eq!(bytes[0], 1);
            let id = u32::from_le_bytes(bytes[1..5].try_into().expect("four bytes"));
            return (self.topics[id as usize - 100].clone(), bytes.slice(13..));
        }
    }
}

#[test]
fn foxglove_gets_every_channel_as_a_recording_has_it() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    for protocol in ["foxglove.websocket.v1", "foxglove.sdk.v1"] {
        let mut client = Client::of(&viewing, protocol, |_| true);
        let mut seen = BTreeMap::new();
        while seen.len() < client.topics.len() {
            let (topic, message) = client.next();
            seen.entry(topic).or_insert(message);
        }
        let decoded = |topic: &str, message: &mut dyn FnMut(&[u8])| message(&seen[topic]);
        decoded("/cell/descriptors", &mut |cdr| {
            let mut shapes = Box::new(Descriptors::EMPTY);
            shapes.decode(cdr).expect("descriptors");
            assert!(!shapes.curves().is_empty());
        });
        decoded("/cell/centerlines", &mut |cdr| {
            let mut lines = Box::new(Centerlines::EMPTY);
            lines.decode(cdr).expect("centerlines");
            assert!(!lines.curves().is_empty());
        });
        decoded("/cell/image", &mut |cdr| {
            assert!(ImageRecord::decode(cdr).expect("an image").is_whole());
        });
        decoded("/cell/image/compressed", &mut |cdr| {
            let picture = CompressedImageRecord::decode(cdr).expect("a picture");
            let picture = image::load_from_memory(picture.data).expect("a JPEG");
            assert_eq!((picture.width(), picture.height()), (640, 480));
        });
        decoded("/cell/latency", &mut |json| {
            let latency: Value = serde_json::from_slice(json).expect("JSON");
            let ms = |step: &str| latency[format!("{step}_ms")].as_f64().expect("a number");
            let steps = [
                "capture",
                "wait_for_extract",
                "extract",
                "wait_for_fit",
                "fit",
            ];
            assert!((ms("total") - steps.map(ms).iter().sum::<f64>()).abs() < 1e-6);
        });
    }
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn control_points_in_millimetres_lie_over_the_picture() {
    let bench = Bench::new();
    make_plane(&bench, "table.toml", &[]);
    let mut chain = bench.start(&["--rig", "cell", "--plane", "table.toml"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    let wanted = ["/cell/centerlines", "/cell/annotations/control_points"];
    let mut client = Client::of(&viewing, "foxglove.websocket.v1", |topic| {
        wanted.contains(&topic)
    });
    let mut lines = Box::new(Centerlines::EMPTY);
    // Within a moment, the first message precedes the second, if it has one.
    loop {
        let (topic, message) = client.next();
        if topic == wanted[0] {
            lines.decode(&message).expect("centerlines");
        } else if !lines.curves().is_empty() {
            break assert_polygons_end_where_ropes_do(&message, &lines);
        }
    }
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}
