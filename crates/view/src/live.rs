//! The protocol between the page and the server (`lariat.view.v1`).
//!
//! The page sends JSON:
//!
//! | `type` | with | meaning |
//! |---|---|---|
//! | `next` | `width` | for a rig: the page has drawn the last moment; send the next, which it shows this many pixels wide |
//! | `frame` | `place`, `width` | for a recording: send the frame at this index, from 0 |
//! | `ask` | `id`, `wish` and its fields ([`tuning`]) | the server sends an `answer` with this `id`, and what was `said` or why it was `refused` |
//!
//! A binary message of the page is a picture file to be traced. It is shown as a moment of number
//! 0, or answered by `undropped`, with the reason `why`.
//!
//! The server sends JSON: `status`, for a rig four times per second ([`status`](crate::status)),
//! and `missing`, with `place`, if a frame does not exist or is damaged.
//!
//! A binary message of the server is a moment:
//!
//! - the lengths of the JSON and of the JPEG that follow, 4 bytes each, little endian
//! - what is drawn over the picture, as JSON ([`moment`](crate::moment))
//! - the picture, as JPEG, empty if there is none
//! - the part of it in the requested mask, as PNG, empty if none was requested

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail, ensure};
use lariat_chain::settings::settings_of;
use lariat_chain::stages::arrangement::give_way;
use lariat_extract::Mask;
use lariat_wire::{Rig, members};
use serde::Deserialize;
use serde_json::{Value, json};
use tungstenite::{Bytes, Message};

use crate::calibrating;
use crate::dropped;
use crate::film::Film;
use crate::gather::stage_of;
use crate::hub::Watcher;
use crate::moment::Moment;
use crate::picture::times_smaller;
use crate::session::{Event, Session};
use crate::tuning::{self, Wish};
use crate::worker::Worker;

/// Name of the page's WebSocket protocol.
pub(crate) const PROTOCOL: &str = "lariat.view.v1";
/// Longest sleep.
const LOOK: Duration = Duration::from_secs(5);

/// Reason why a client that is not our own page is refused.
const FOREIGN: &str = "this connection may not change anything: open the page by its address";
const NO_CHAIN: &str = "no chain is running";
/// Number of moments that the page may still refer to: the one on its screen, and those after it.
const HELD: usize = 3;

/// Messages of the page.
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
    Ask {
        id: u64,
        #[serde(flatten)]
        wish: Wish,
    },
    /// A message of a newer page.
    #[serde(other)]
    Other,
}

/// A request of a page that takes a long time to answer.
enum Task {
    /// Shows a moment, this many pixels wide.
    Show(Arc<Moment>, u32),
    /// Answers a wish.
    Answer {
        id: u64,
        wish: Wish,
        rig: Option<Rig>,
    },
    /// Traces a picture file, with the settings of the rig.
    Trace { file: Bytes, rig: Option<Rig> },
}

/// A page's request, or another event on its connection.
enum Heard {
    Nothing,
    /// There is news from elsewhere.
    News,
    /// The page is ready for the next moment of a rig, this wide.
    Next(u32),
    /// The page wants a frame of a recording.
    Frame {
        place: u64,
        width: u32,
    },
    Task(Task),
    Over,
}

/// Interprets an event. `rig` returns the rig that the page shows, if it shows one.
fn heard(event: Event, rig: impl FnOnce() -> Option<Rig>) -> Heard {
    let text = match event {
        Event::Text(text) => text,
        Event::Binary(file) => return Heard::Task(Task::Trace { file, rig: rig() }),
        Event::News => return Heard::News,
        Event::End => return Heard::Over,
    };
    match serde_json::from_str(&text) {
        Ok(Said::Next { width }) => Heard::Next(width),
        Ok(Said::Frame { place, width }) => Heard::Frame { place, width },
        Ok(Said::Ask { id, wish }) => Heard::Task(Task::Answer {
            id,
            wish,
            rig: rig(),
        }),
        Ok(Said::Other) => Heard::Nothing,
        Err(_) => Heard::Over,
    }
}

/// Shows one page the rig, until the page or the server ends.
pub(crate) fn show_rig<S: Read + Write + AsFd>(
    mut session: Session<S>,
    may_write: bool,
    watcher: &Watcher,
) {
    let mut desk = Desk::new(may_write);
    let Ok(mut worker) = Worker::start(watcher.bell(), move |task| desk.work(task)) else {
        return;
    };
    let (mut shown, mut told) = (0, 0);
    let mut width = None;
    while !watcher.is_over() {
        let mut task = None;
        match heard(session.next(Some(watcher.as_fd()), LOOK), || watcher.rig()) {
            Heard::Next(wanted) => {
                width = Some(wanted);
                watcher.want();
            }
            Heard::Task(asked) => task = Some(asked),
            Heard::News => watcher.hear(),
            Heard::Frame { .. } | Heard::Nothing => {}
            Heard::Over => return,
        }
        let moment = width.and_then(|wanted| Some((watcher.moment_after(shown)?, wanted)));
        let show = moment.map(|(moment, wanted)| {
            (shown, width) = (moment.number, None);
            Task::Show(moment, wanted)
        });
        for task in [task, show].into_iter().flatten() {
            let added = worker.add(task);
            if !added.is_some_and(|messages| say_all(&mut session, messages)) {
                return;
            }
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
        while let Some(messages) = worker.next() {
            if !say_all(&mut session, messages) {
                return;
            }
        }
    }
}

/// Shows one page a recording, until the page ends.
pub(crate) fn show_film<S: Read + Write + AsFd>(
    mut session: Session<S>,
    may_write: bool,
    film: &Film,
) {
    // Let a chain on this machine go first.
    give_way();
    let mut desk = Desk::new(may_write);
    let Ok(mut playback) = film.playback() else {
        return;
    };
    if !session.say(Message::text(&*film.status)) {
        return;
    }
    let mut wanted = None;
    loop {
        match heard(session.next(None, LOOK), || None) {
            // Only the last frame that the page asks for is shown.
            Heard::Frame { place, width } => wanted = Some((place, width)),
            Heard::Task(task) => {
                if !say_all(&mut session, desk.work(task)) {
                    return;
                }
            }
            Heard::Next(_) | Heard::News | Heard::Nothing => {}
            Heard::Over => return,
        }
        if session.is_clear()
            && let Some((place, width)) = wanted.take()
        {
            let messages = match playback.moment(place) {
                Ok(Some(moment)) => desk.work(Task::Show(Arc::new(moment), width)),
                Ok(None) | Err(_) => {
                    let missing = json!({ "type": "missing", "place": place });
                    vec![Message::text(missing.to_string())]
                }
            };
            if !say_all(&mut session, messages) {
                return;
            }
        }
    }
}

/// Sends all messages. Returns false if the connection is over.
fn say_all<S: Read + Write + AsFd>(session: &mut Session<S>, messages: Vec<Message>) -> bool {
    messages.into_iter().all(|message| session.say(message))
}

/// Does the tasks of one page.
struct Desk {
    may_write: bool,
    /// The moments that were shown last, the newest at the back.
    held: VecDeque<Arc<Moment>>,
    /// Width at which the page shows them.
    width: u32,
    /// Mask that is drawn with each moment.
    mask: Option<Mask>,
}

impl Desk {
    fn new(may_write: bool) -> Self {
        Self {
            may_write,
            held: VecDeque::new(),
            width: 0,
            mask: None,
        }
    }

    fn work(&mut self, task: Task) -> Vec<Message> {
        match task {
            Task::Show(moment, width) => vec![self.show(moment, width)],
            Task::Answer { id, wish, rig } => self.answer(id, wish, rig.as_ref().map(Rig::as_str)),
            Task::Trace { file, rig } => vec![self.trace(&file, rig.as_ref().map(Rig::as_str))],
        }
    }

    fn show(&mut self, moment: Arc<Moment>, width: u32) -> Message {
        self.width = width;
        let message = message(&moment, width, self.mask.as_ref());
        if self
            .held
            .back()
            .is_none_or(|last| last.number != moment.number)
        {
            self.held.push_back(moment);
        }
        if self.held.len() > HELD {
            self.held.pop_front();
        }
        message
    }

    /// Traces a picture file.
    fn trace(&mut self, file: &[u8], rig: Option<&str>) -> Message {
        // Without a chain, the default settings apply.
        let settings = rig.and_then(|rig| {
            let members = members().ok()?;
            settings_of(stage_of(&members, rig, "fit")?).ok()
        });
        let traced = match self.may_write {
            true => dropped::trace(file, settings.unwrap_or_default()),
            false => Err(anyhow!(FOREIGN)),
        };
        match traced {
            Ok(moment) => self.show(Arc::new(moment), self.width),
            Err(why) => {
                let why = json!({ "type": "undropped", "why": format!("{why:#}") });
                Message::text(why.to_string())
            }
        }
    }

    /// Answers a wish, and shows the picture again if the wish changes it.
    fn answer(&mut self, id: u64, wish: Wish, rig: Option<&str>) -> Vec<Message> {
        let mut messages = Vec::new();
        let answer = match self.grant(wish, rig, &mut messages) {
            Ok(said) => json!({ "type": "answer", "id": id, "said": said }),
            Err(why) => json!({ "type": "answer", "id": id, "refused": format!("{why:#}") }),
        };
        messages.push(Message::text(answer.to_string()));
        messages
    }

    /// Fails unless the points were clicked in pictures of the current size.
    fn check_size(&self, size: [u32; 2]) -> Result<()> {
        let shown = self.held.back().map(|moment| &moment.descriptors);
        ensure!(
            shown.is_some_and(|shown| [shown.width, shown.height] == size),
            "the points were clicked in pictures of another size: click them again"
        );
        Ok(())
    }

    fn grant(
        &mut self,
        wish: Wish,
        rig: Option<&str>,
        messages: &mut Vec<Message>,
    ) -> Result<Value> {
        if wish.writes() && !self.may_write {
            bail!(FOREIGN);
        }
        match wish {
            Wish::Pick { number, at } => {
                let moment = self.held.iter().find(|moment| moment.number == number);
                let moment =
                    moment.context("this frame is too old to pick from: go to the newest one")?;
                let (answer, mask) = tuning::colours(moment, &at)?;
                let moment = moment.clone();
                self.mask = Some(mask);
                messages.push(self.show(moment, self.width));
                Ok(answer)
            }
            Wish::Mask { mask } => {
                self.mask = mask.as_deref().map(tuning::mask).transpose()?;
                if let Some(newest) = self.held.back().cloned() {
                    messages.push(self.show(newest, self.width));
                }
                Ok(Value::Null)
            }
            Wish::Plane { points, size } => {
                self.check_size(size)?;
                calibrating::judge(rig, &points, size)
            }
            Wish::WritePlane { points, size } => {
                self.check_size(size)?;
                calibrating::write(rig.context(NO_CHAIN)?, &points, size)
            }
            wish => tuning::of_chain(rig.context(NO_CHAIN)?, &wish),
        }
    }
}

/// Encodes a moment as a message.
fn message(moment: &Moment, wanted: u32, mask: Option<&Mask>) -> Message {
    let said = moment.said();
    let times = times_smaller(moment.descriptors.width, wanted);
    let jpeg = moment.jpeg(times).unwrap_or_default();
    let png = mask
        .and_then(|mask| tuning::drawn(moment, mask))
        .unwrap_or_default();
    let mut bytes = Vec::with_capacity(8 + said.len() + jpeg.len() + png.len());
    bytes.extend_from_slice(&(said.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&(jpeg.len() as u32).to_le_bytes());
    bytes.extend_from_slice(said.as_bytes());
    bytes.extend_from_slice(&jpeg);
    bytes.extend_from_slice(&png);
    Message::binary(bytes)
}
