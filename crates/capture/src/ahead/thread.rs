//! The decoder thread. It decodes pass after pass into the memory it is given.

use std::collections::HashSet;

use crossbeam::channel::{Receiver, Sender};

use super::{Buffer, Decode, Memory, Message, Step};
use crate::source::SourceError;

/// Source of the thread's buffers.
pub(super) struct Room {
    pub(super) spare: Receiver<Buffer>,
    /// Size of each buffer, in bytes.
    pub(super) bytes: usize,
    /// Buffer left over from a lost frame.
    pub(super) left: Option<Buffer>,
}

impl Room {
    /// Waits for a buffer; `None` if the receiver is gone.
    fn take(&mut self) -> Option<Buffer> {
        let mut buffer = self.left.take().or_else(|| self.spare.recv().ok())?;
        if let Memory::Own(pixels) = &mut buffer.pixels {
            pixels.resize(self.bytes, 0);
        }
        Some(buffer)
    }
}

/// Body of the thread: decodes the set once or repeatedly, until it fails or the receiver is gone.
pub(super) fn decode_ahead(
    mut decoder: impl Decode,
    again: bool,
    mut room: Room,
    ready: &Sender<Message>,
) {
    let mut sequence = 0;
    // A sentence that was reported is not repeated on the next pass.
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

/// Decodes from the first frame to the last; `None` if the receiver is gone.
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

/// The sentence for a step without a frame, and the part of it that repeats on the next pass.
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
