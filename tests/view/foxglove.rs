//! Foxglove's protocol on the same port.

use lariat_record::{CompressedImageRecord, ImageRecord, Record};
use lariat_wire::{Centerlines, Descriptors};
use rustix::process::Signal;
use serde_json::{Value, json};
use tungstenite::Message;

use crate::page::Page;
use crate::rig::Bench;
use crate::viewing::Viewing;

#[test]
fn foxglove_gets_every_channel_as_a_recording_has_it() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--rig", "cell"]);
    chain.wait_for_frames();
    let viewing = Viewing::start(&bench, &["--rig", "cell"]);
    for protocol in ["foxglove.websocket.v1", "foxglove.sdk.v1"] {
        let mut client = Page::open(&viewing.url, None, protocol)
            .expect("it is let in")
            .0;
        let channels = loop {
            let Message::Text(text) = client.read().expect("a message in time") else {
                panic!("nothing was subscribed to");
            };
            let said: Value = serde_json::from_str(&text).expect("JSON");
            if said["op"] == "advertise" {
                break said["channels"].as_array().expect("channels").clone();
            }
            assert_eq!(said["op"], "serverInfo");
        };
        let subscriptions: Vec<Value> = (channels.iter().zip(100..))
            .map(|(channel, id)| json!({"id": id, "channelId": channel["id"]}))
            .collect();
        let wish = json!({"op": "subscribe", "subscriptions": subscriptions});
        client.send(Message::text(wish.to_string())).expect("sent");
        let mut seen = std::collections::BTreeMap::new();
        while seen.len() < channels.len() {
            let Message::Binary(bytes) = client.read().expect("a message in time") else {
                continue;
            };
            assert_eq!(bytes[0], 1);
            let id = u32::from_le_bytes(bytes[1..5].try_into().expect("four bytes"));
            let topic = channels[id as usize - 100]["topic"]
                .as_str()
                .expect("a topic");
            seen.entry(topic.to_owned()).or_insert(bytes.slice(13..));
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
