//! A page's messages to the server, and the answers.

use std::net::TcpStream;
use std::time::Duration;

use rustix::process::Signal;
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::rig::{Bench, Running};
use crate::viewing::Viewing;

/// Longer than any step of these tests.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);
pub(crate) const PROTOCOL: &str = "lariat.view.v1";

/// A page's WebSocket, with a given origin.
pub(crate) struct Page(pub(crate) WebSocket<MaybeTlsStream<TcpStream>>);

impl Page {
    pub(crate) fn open(
        url: &str,
        origin: Option<&str>,
        protocol: &str,
    ) -> Result<Self, tungstenite::Error> {
        let address = format!("{}live", url.replacen("http", "ws", 1));
        let mut request = address.into_client_request().expect("an address");
        let headers = request.headers_mut();
        headers.insert("Sec-WebSocket-Protocol", protocol.parse().expect("plain"));
        if let Some(origin) = origin {
            headers.insert("Origin", origin.parse().expect("plain"));
        }
        let (mut socket, _) = tungstenite::connect(request)?;
        if let MaybeTlsStream::Plain(stream) = socket.get_mut() {
            stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        }
        Ok(Self(socket))
    }

    pub(crate) fn of(viewing: &Viewing) -> Self {
        Self::open(&viewing.url, None, PROTOCOL).expect("it is let in")
    }

    pub(crate) fn ask(&mut self) {
        let next = r#"{"type":"next","width":4000}"#;
        self.0.send(Message::text(next)).expect("sent");
    }

    /// Returns the next moment: its description and its picture. Status messages are skipped.
    pub(crate) fn moment(&mut self) -> (Value, Vec<u8>) {
        loop {
            if let Message::Binary(bytes) = self.0.read().expect("a message in time") {
                let (said, jpeg, _) = parts(&bytes);
                return (said, jpeg);
            }
        }
    }

    /// Returns the mask of the next moment.
    pub(crate) fn mask(&mut self) -> Vec<u8> {
        loop {
            if let Message::Binary(bytes) = self.0.read().expect("a message in time") {
                return parts(&bytes).2;
            }
        }
    }

    /// Returns the answer to a wish, or the reason for its refusal. Other messages are skipped.
    pub(crate) fn wish(&mut self, wish: Value) -> Result<Value, String> {
        self.0
            .send(Message::text(asked(1, wish).to_string()))
            .expect("sent");
        loop {
            let Message::Text(text) = self.0.read().expect("a message in time") else {
                continue;
            };
            let mut said: Value = serde_json::from_str(&text).expect("JSON");
            if said["type"] == "answer" && said["id"] == 1 {
                return match said["refused"].as_str() {
                    Some(why) => Err(why.to_owned()),
                    None => Ok(said["said"].take()),
                };
            }
        }
    }

    /// Returns the next status that meets a condition. Moments are skipped.
    pub(crate) fn status(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().expect("a message in time") {
                let status: Value = serde_json::from_str(&text).expect("JSON");
                if status["type"] == "status" && holds(&status) {
                    return status;
                }
            }
        }
    }
}

/// Starts a chain and its own page, which has received a moment.
pub(crate) fn shown(bench: &Bench, flags: &[&str]) -> (Running, Viewing, Page) {
    let mut chain = bench.start(&[&["--rig", "cell", "--seed", "3"], flags].concat());
    chain.wait_for_frames();
    let viewing = Viewing::start(bench, &["--rig", "cell"]);
    let own = viewing.url.trim_end_matches('/').to_owned();
    let mut page = Page::open(&viewing.url, Some(&own), PROTOCOL).expect("it is let in");
    page.ask();
    page.moment();
    (chain, viewing, page)
}

/// Ends the chain and the page.
pub(crate) fn end(chain: Running, viewing: Viewing) {
    viewing.end();
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

/// Splits a moment's message into its description, its picture, and its mask.
pub(crate) fn parts(bytes: &[u8]) -> (Value, Vec<u8>, Vec<u8>) {
    let (said, rest) = bytes.split_first_chunk().expect("a length");
    let (jpeg, rest) = rest.split_first_chunk().expect("a length");
    let (said, rest) = rest.split_at(u32::from_le_bytes(*said) as usize);
    let (jpeg, mask) = rest.split_at(u32::from_le_bytes(*jpeg) as usize);
    let said = serde_json::from_slice(said).expect("JSON");
    (said, jpeg.to_vec(), mask.to_vec())
}

/// Formats a wish as the page does.
pub(crate) fn asked(id: u64, mut wish: Value) -> Value {
    wish["type"] = "ask".into();
    wish["id"] = id.into();
    wish
}

/// Checks that every rope of a moment has a curve with nine of ten points on the rendered rope,
/// which is much bluer than its table.
pub(crate) fn assert_curves_lie_on_the_rope(said: &Value, jpeg: &[u8]) {
    let picture = image::load_from_memory(jpeg).expect("a JPEG").into_rgb8();
    let (right, bottom) = (picture.width() - 1, picture.height() - 1);
    let is_on_rope = |point: &&Value| {
        let at = |i: usize| point[i].as_f64().expect("a number").round().max(0.0) as u32;
        let [red, _, blue] = picture
            .get_pixel(at(0).min(right), at(1).min(bottom))
            .0
            .map(i32::from);
        blue - red > 30
    };
    let ropes = said["ropes"].as_array().expect("ropes");
    assert!(!ropes.is_empty());
    for rope in ropes {
        let curve = rope["curve"].as_array().expect("points");
        let on_rope = curve.iter().filter(is_on_rope).count();
        assert!(
            curve.len() > 1 && on_rope * 10 >= curve.len() * 9,
            "{on_rope} of {} points lie on the rope",
            curve.len()
        );
    }
}
