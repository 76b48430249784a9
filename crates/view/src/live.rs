//! What the page and the server say to each other (`lariat.view.v1`).
//!
//! The page says, as JSON:
//!
//! | `type` | with | what |
//! |---|---|---|
//! | `next` | `width` | it has drawn what came last: send the next, which it shows so many pixels wide |
//!
//! The server says, as JSON: `status`, four times a second ([`status`](crate::status)). And in binary a moment: the length of the JSON that
//! follows, 4 bytes, little endian; what is drawn over the picture ([`moment`](crate::moment)); the picture, a JPEG, none if the source has none.

use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::time::Duration;

use serde::Deserialize;
use tungstenite::Message;

use crate::hub::Watcher;
use crate::moment::Moment;
use crate::picture::times_smaller;
use crate::session::{Event, Session};

/// How the WebSocket of the page is called.
pub(crate) const PROTOCOL: &str = "lariat.view.v1";
/// The longest sleep.
const LOOK: Duration = Duration::from_secs(5);

/// What the page says.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Said {
    Next { width: u32 },
}

/// Shows the rig to one page, until either goes.
pub(crate) fn run<S: Read + Write + AsFd>(mut session: Session<S>, watcher: &Watcher) {
    let (mut shown, mut told) = (0, 0);
    let mut width = None;
    while !watcher.is_over() {
        match session.next(watcher.as_fd(), LOOK) {
            Event::Text(text) => match serde_json::from_str(&text) {
                Ok(Said::Next { width: wanted }) => {
                    width = Some(wanted);
                    watcher.want();
                }
                // A newer page may say more.
                Err(_) => {}
            },
            Event::Binary(_) => return,
            Event::Look => watcher.hear(),
            Event::End => return,
        }
        if !session.is_clear() {
            continue;
        }
        if let Some((number, status)) = watcher.status_after(told) {
            told = number;
            if !session.say(Message::text(&*status)) {
                return;
            }
        }
        if let Some(wanted) = width
            && let Some(moment) = watcher.moment_after(shown)
        {
            (shown, width) = (moment.number, None);
            if !session.say(message(&moment, wanted)) {
                return;
            }
        }
    }
}

/// A moment as a message.
fn message(moment: &Moment, wanted: u32) -> Message {
    let said = moment.said();
    let times = times_smaller(moment.descriptors.width, wanted);
    let jpeg = moment.jpeg(times).unwrap_or_default();
    let mut bytes = Vec::with_capacity(4 + said.len() + jpeg.len());
    bytes.extend_from_slice(&(said.len() as u32).to_le_bytes());
    bytes.extend_from_slice(said.as_bytes());
    bytes.extend_from_slice(&jpeg);
    Message::binary(bytes)
}
