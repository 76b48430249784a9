//! What the page and the server say to each other (`lariat.view.v1`).
//!
//! The page says, as JSON:
//!
//! | `type` | with | what |
//! |---|---|---|
//! | `next` | `width` | of a rig: it has drawn what came last; send the next, which it shows so many pixels wide |
//! | `frame` | `place`, `width` | of a recording: send the frame of this place, from 0 |
//!
//! The server says, as JSON: `status`, of a rig four times a second ([`status`](crate::status)); `missing`, with `place`: there is no such frame, or it is
//! damaged. And in binary a moment: the length of the JSON that
//! follows, 4 bytes, little endian; what is drawn over the picture ([`moment`](crate::moment)); the picture, a JPEG, none if the source has none.

use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::time::Duration;

use serde::Deserialize;
use serde_json::json;
use tungstenite::Message;

use crate::film::Film;
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
    Next {
        width: u32,
    },
    Frame {
        place: u64,
        width: u32,
    },
    /// What a newer page may say.
    #[serde(other)]
    Other,
}

/// Shows the rig to one page, until either goes.
pub(crate) fn show_rig<S: Read + Write + AsFd>(mut session: Session<S>, watcher: &Watcher) {
    let (mut shown, mut told) = (0, 0);
    let mut width = None;
    while !watcher.is_over() {
        match session.next(Some(watcher.as_fd()), LOOK) {
            Event::Text(text) => match serde_json::from_str(&text) {
                Ok(Said::Next { width: wanted }) => {
                    width = Some(wanted);
                    watcher.want();
                }
                Ok(_) => {}
                Err(_) => return,
            },
            Event::Look => watcher.hear(),
            Event::Binary(_) | Event::End => return,
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

/// Shows a recording to one page, until it goes.
pub(crate) fn show_film<S: Read + Write + AsFd>(mut session: Session<S>, film: &Film) {
    let Ok(mut reel) = film.reel() else {
        return;
    };
    if !session.say(Message::text(&*film.status)) {
        return;
    }
    let mut wanted = None;
    loop {
        match session.next(None, LOOK) {
            Event::Text(text) => match serde_json::from_str(&text) {
                // The last that is asked for is what is to be seen.
                Ok(Said::Frame { place, width }) => wanted = Some((place, width)),
                Ok(_) => {}
                Err(_) => return,
            },
            Event::Look => {}
            Event::Binary(_) | Event::End => return,
        }
        if session.is_clear()
            && let Some((place, width)) = wanted.take()
        {
            let said = match reel.moment(place) {
                Ok(Some(moment)) => message(&moment, width),
                Ok(None) | Err(_) => {
                    Message::text(json!({ "type": "missing", "place": place }).to_string())
                }
            };
            if !session.say(said) {
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
