//! The thread that decodes: pass after pass, into whatever memory it is given.

use std::collections::HashSet;

use crossbeam::channel::{Receiver, Sender};

use super::{Buffer, Decode, Memory, Message, Step};
use crate::source::SourceError;

/// Where the thread has its buffers from.
pub(super) struct Room {
    pub(super) spare: Receiver<Buffer>,
    /// Bytes of each.
    pub(super) bytes: usize,
    /// That of a frame that was lost.
    pub(super) left: Option<Buffer>,
}

impl Room {
    /// A buffer, waited for; none if nobody listens any more.
    fn take(&mut self) -> Option<Buffer> {
        let mut buffer = self.left.take().or_else(|| self.spare.recv().ok())?;
        if let Memory::Own(pixels) = &mut buffer.pixels {
            pixels.resize(self.bytes, 0);
        }
        Some(buffer)
    }
}

/// The thread: passes over the set, once or again and again, until it fails or nobody listens any more.
pub(super) fn decode_ahead(
    mut decoder: impl Decode,
    again: bool,
    mut room: Room,
    ready: &Sender<Message>,
) {
    let mut sequence = 0;
    // What was said is not said again on the next pass.
    let mut said = HashSet::new();
    loop {
        match one_pass(&mut decoder, &mut sequence, &mut said, &mut room, ready) {
            Some(Ok(())) if again => {}
            Some(Ok(())) => {
                let _ = ready.send(Message::End(sequence));
                return;
            }
            Some(Err(error)) => {
                let _ = ready.send(Message::Failed(error));
                return;
            }
            None => return,
        }
    }
}

/// From the first frame to the last; `None` if nobody listens any more.
fn one_pass(
    decoder: &mut impl Decode,
    sequence: &mut u64,
    said: &mut HashSet<String>,
    room: &mut Room,
    ready: &Sender<Message>,
) -> Option<Result<(), SourceError>> {
    let mut first_reason = None;
    let mut is_empty = true;
    let before = *sequence;
    if let Err(error) = decoder.rewind() {
        return Some(Err(error));
    }
    loop {
        let mut buffer = room.take()?;
        let (layout, moment) = match decoder.decode(buffer.pixels()) {
            Step::Decoded(layout) => (layout, None),
            Step::Recorded(layout, moment) => (layout, Some(moment)),
            Step::End(None) => {
                room.left = Some(buffer);
                break;
            }
            Step::News(news) => {
                room.left = Some(buffer);
                if said.insert(news.clone()) {
                    ready.send(Message::News(news)).ok()?;
                }
                continue;
            }
            wrong => {
                room.left = Some(buffer);
                let is_end = matches!(wrong, Step::End(_));
                let (warning, reason) = said_of(wrong, sequence);
                if said.insert(reason.clone()) {
                    ready.send(Message::Warning(warning)).ok()?;
                }
                first_reason.get_or_insert(reason);
                if is_end {
                    break;
                }
                continue;
            }
        };
        *sequence = match moment {
            Some(moment) => before + moment.number,
            None => *sequence + 1,
        };
        is_empty = false;
        let frame = layout.frame(*sequence);
        if let Memory::Own(pixels) = &mut buffer.pixels {
            pixels.truncate(layout.bytes());
        }
        if let Some(truth) = &mut buffer.truth {
            truth.is_known = decoder.truth(&mut truth.centerlines);
        }
        if let Some(news) = decoder.take_news()
            && said.insert(news.clone())
        {
            ready.send(Message::News(news)).ok()?;
        }
        let after_ns = moment.map(|moment| moment.after_ns);
        ready.send(Message::Decoded(frame, after_ns, buffer)).ok()?;
    }
    if is_empty {
        return Some(Err(match first_reason {
            Some(reason) => SourceError::NothingDecoded { reason },
            None => decoder.nothing(),
        }));
    }
    Some(Ok(()))
}

/// What to say of a step that made no frame, and what of it is the same on the next pass.
fn said_of(step: Step, sequence: &mut u64) -> (String, String) {
    match step {
        Step::Lost(reason) => {
            *sequence += 1;
            (format!("lost frame {sequence}: {reason}"), reason)
        }
        Step::Wrong(reason) | Step::End(Some(reason)) => (reason.clone(), reason),
        Step::Decoded(_) | Step::Recorded(..) | Step::News(_) | Step::End(None) => {
            Default::default()
        }
    }
}
