//! Decodes ahead: a thread keeps a few frames ready, so that none is decoded at the moment it is due.
//!
//! It decodes into the slots it is lent; where it is lent none, into buffers of its own that go round: thread → frame in
//! use → thread. A small set that is shown again and again is decoded once and kept.

use std::collections::{HashSet, VecDeque};
use std::thread::{self, JoinHandle};

use crossbeam::channel::{Receiver, Sender, bounded};
use lariat_wire::{PixelFormat, SourceKind};

use crate::lent::LentSlot;
use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::Until;

/// Frames that wait decoded.
const AHEAD: usize = 3;
/// Buffers that go round: those, one in use and one in the making.
const OWN: usize = AHEAD + 2;
/// Slots that are lent: one is on its way, and one is in the making.
const LENT: usize = AHEAD + 1;
/// A looped set is kept if it is no larger decoded.
pub(crate) const KEPT_BYTES: u64 = 64 << 20;

/// A frame's geometry, not yet numbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) stride: u32,
    pub(crate) format: PixelFormat,
}

impl Layout {
    pub(crate) fn bytes(&self) -> usize {
        self.format.image_bytes(self.stride, self.height)
    }
}

/// One try at the next frame.
pub(crate) enum Step {
    /// It is decoded.
    Decoded(Layout),
    /// There was one, and it is lost: a sentence that says why.
    Lost(String),
    /// The pass is over: what was wrong with the end of it, if anything was.
    End(Option<String>),
}

/// What turns files into frames.
pub(crate) trait Decode: Send + 'static {
    /// Goes (back) to the first frame.
    fn rewind(&mut self) -> Result<(), SourceError>;

    /// Decodes the next frame into the beginning of `pixels`, which has room for the largest.
    fn decode(&mut self, pixels: &mut [u8]) -> Step;

    /// Why a pass had no frame and nothing was wrong.
    fn nothing(&self) -> SourceError {
        SourceError::NothingDecoded {
            reason: "there is none".to_owned(),
        }
    }
}

/// What is known of a set of frames before the first.
pub(crate) struct Plan {
    pub(crate) kind: SourceKind,
    pub(crate) largest_frame_bytes: usize,
    pub(crate) native_fps: Option<f64>,
    pub(crate) looped: bool,
    /// Decoded bytes of the whole set.
    pub(crate) total_bytes: u64,
    pub(crate) warnings: Vec<String>,
    pub(crate) news: Option<String>,
}

/// Memory that a frame is decoded into.
enum Buffer {
    Own(Vec<u8>),
    Lent(LentSlot),
}

impl Buffer {
    fn pixels(&mut self) -> &mut [u8] {
        match self {
            Self::Own(pixels) => pixels,
            Self::Lent(slot) => slot,
        }
    }
}

/// Where the thread has its buffers from.
struct Room {
    spare: Receiver<Buffer>,
    /// Bytes of each.
    bytes: usize,
    /// That of a frame that was lost.
    left: Option<Buffer>,
}

impl Room {
    /// A buffer, waited for; none if nobody listens any more.
    fn take(&mut self) -> Option<Buffer> {
        let mut buffer = self.left.take().or_else(|| self.spare.recv().ok())?;
        if let Buffer::Own(pixels) = &mut buffer {
            pixels.resize(self.bytes, 0);
        }
        Some(buffer)
    }
}

struct Picture {
    frame: Frame,
    /// None where the frame says which slot it is in.
    pixels: Vec<u8>,
}

enum Message {
    Decoded(Frame, Buffer),
    Warning(String),
    /// All is decoded; so many sequence numbers were used.
    End(u64),
    Failed(SourceError),
}

/// A source whose frames are decoded ahead.
pub(crate) struct Ahead {
    plan: Plan,
    /// Both are none once the source is dropped.
    ready: Option<Receiver<Message>>,
    spare: Option<Sender<Buffer>>,
    decoder: Option<JoinHandle<()>>,
    warnings: VecDeque<String>,
    /// Whether all pictures are held, to be shown again; else only the one in use.
    keeps: bool,
    held: Vec<Picture>,
    current: usize,
    /// Whether the first frame is held and not yet shown.
    is_primed: bool,
    /// Whether there are buffers to decode the others into.
    is_supplied: bool,
    /// How many sequence numbers a round has, once the thread has ended.
    round: Option<u64>,
    rounds: u64,
    has_ended: bool,
}

impl Ahead {
    /// Decodes the first frame, so that what cannot be decoded at all is known before it is due; the others are begun
    /// with when it is known where they belong.
    pub(crate) fn start(decoder: impl Decode, plan: Plan) -> Result<Self, SourceError> {
        let (ready_in, ready) = bounded(AHEAD);
        // Never full: all buffers there are.
        let (spare, spare_out) = bounded(OWN + LENT);
        let keeps = plan.looped && plan.total_bytes <= KEPT_BYTES;
        let again = plan.looped && !keeps;
        let room = Room {
            spare: spare_out,
            bytes: plan.largest_frame_bytes,
            left: None,
        };
        let decoder = thread::Builder::new()
            .name("decode".to_owned())
            .spawn(move || decode_ahead(decoder, again, room, &ready_in))
            .map_err(SourceError::NoThread)?;
        let mut source = Self {
            warnings: plan.warnings.iter().cloned().collect(),
            plan,
            ready: Some(ready),
            spare: Some(spare),
            decoder: Some(decoder),
            keeps,
            held: Vec::new(),
            current: 0,
            is_primed: false,
            is_supplied: false,
            round: None,
            rounds: 0,
            has_ended: false,
        };
        source.supply(Buffer::Own(Vec::new()));
        source.is_primed = source.turn()?;
        Ok(source)
    }

    /// Gives the thread a buffer to decode into. If it has ended there is no use for it.
    fn supply(&self, buffer: Buffer) {
        if let Some(spare) = &self.spare {
            let _ = spare.try_send(buffer);
        }
    }

    /// Makes the next picture the current one; `false` at the end.
    fn turn(&mut self) -> Result<bool, SourceError> {
        while self.round.is_none() {
            match self.ready.as_ref().and_then(|ready| ready.recv().ok()) {
                Some(Message::Decoded(frame, buffer)) => {
                    self.hold(frame, buffer);
                    return Ok(true);
                }
                Some(Message::Warning(warning)) => self.warnings.push_back(warning),
                Some(Message::End(round)) => {
                    self.round = Some(round);
                    self.current = self.held.len();
                }
                Some(Message::Failed(error)) => return Err(error),
                None => return Err(SourceError::DecoderGone),
            }
        }
        if !self.keeps {
            return Ok(false);
        }
        self.current += 1;
        if self.current >= self.held.len() {
            self.current = 0;
            self.rounds += 1;
        }
        Ok(true)
    }

    fn hold(&mut self, mut frame: Frame, buffer: Buffer) {
        let pixels = match buffer {
            Buffer::Own(mut pixels) => {
                if self.keeps {
                    pixels.shrink_to_fit();
                }
                pixels
            }
            Buffer::Lent(slot) => {
                frame.slot = Some(slot.give_back());
                Vec::new()
            }
        };
        if self.keeps {
            if self.is_supplied {
                self.supply(Buffer::Own(Vec::new()));
            }
        } else if let Some(shown) = self.held.pop()
            && shown.frame.slot.is_none()
            && frame.slot.is_none()
        {
            self.supply(Buffer::Own(shown.pixels));
        }
        self.held.push(Picture { frame, pixels });
        self.current = self.held.len() - 1;
    }

    fn frame(&self) -> Frame {
        let mut frame = self.held[self.current].frame;
        frame.sequence += self.rounds * self.round.unwrap_or(0);
        frame
    }
}

impl FrameSource for Ahead {
    fn kind(&self) -> SourceKind {
        self.plan.kind
    }

    fn largest_frame_bytes(&self) -> usize {
        self.plan.largest_frame_bytes
    }

    fn native_fps(&self) -> Option<f64> {
        self.plan.native_fps
    }

    fn slots_wanted(&self) -> usize {
        // What is kept is copied each time it is shown.
        if self.keeps { 0 } else { LENT }
    }

    fn lend(&mut self, slot: LentSlot) {
        self.is_supplied = true;
        self.supply(Buffer::Lent(slot));
    }

    fn advance(&mut self, _until: &Until) -> Result<Next, SourceError> {
        if !std::mem::replace(&mut self.is_supplied, true) {
            (0..OWN).for_each(|_| self.supply(Buffer::Own(Vec::new())));
        }
        if self.has_ended {
            return Ok(Next::End);
        }
        if !std::mem::take(&mut self.is_primed) {
            // An error is an end too.
            self.has_ended = true;
            self.has_ended = !self.turn()?;
        }
        Ok(if self.has_ended {
            Next::End
        } else {
            Next::Frame(self.frame())
        })
    }

    fn write(&mut self, pixels: &mut [u8]) {
        if let Some(picture) = self.held.get(self.current) {
            let count = pixels.len().min(picture.pixels.len());
            pixels[..count].copy_from_slice(&picture.pixels[..count]);
        }
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warnings.pop_front()
    }

    fn take_news(&mut self) -> Option<String> {
        self.plan.news.take()
    }
}

impl Drop for Ahead {
    /// Lets go of what it was lent: the thread ends at its next message, and it may be decoding into a slot until then.
    fn drop(&mut self) {
        (self.ready, self.spare) = (None, None);
        if let Some(decoder) = self.decoder.take() {
            // That it broke off was told where its frames were missing.
            let _ = decoder.join();
        }
    }
}

/// The thread: passes over the set, once or again and again, until it fails or nobody listens any more.
fn decode_ahead(mut decoder: impl Decode, again: bool, mut room: Room, ready: &Sender<Message>) {
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
    if let Err(error) = decoder.rewind() {
        return Some(Err(error));
    }
    loop {
        let mut buffer = room.take()?;
        let (warning, reason, is_end) = match decoder.decode(buffer.pixels()) {
            Step::Decoded(layout) => {
                *sequence += 1;
                is_empty = false;
                let Layout {
                    width,
                    height,
                    stride,
                    format,
                } = layout;
                let frame = Frame {
                    sequence: *sequence,
                    width,
                    height,
                    stride,
                    format,
                    exposed_ns: None,
                    slot: None,
                };
                if let Buffer::Own(pixels) = &mut buffer {
                    pixels.truncate(layout.bytes());
                }
                ready.send(Message::Decoded(frame, buffer)).ok()?;
                continue;
            }
            Step::Lost(reason) => {
                *sequence += 1;
                (format!("lost frame {sequence}: {reason}"), reason, false)
            }
            Step::End(Some(reason)) => (reason.clone(), reason, true),
            Step::End(None) => {
                room.left = Some(buffer);
                break;
            }
        };
        room.left = Some(buffer);
        if said.insert(reason.clone()) {
            ready.send(Message::Warning(warning)).ok()?;
        }
        first_reason.get_or_insert(reason);
        if is_end {
            break;
        }
    }
    if is_empty {
        return Some(Err(match first_reason {
            Some(reason) => SourceError::NothingDecoded { reason },
            None => decoder.nothing(),
        }));
    }
    Some(Ok(()))
}
