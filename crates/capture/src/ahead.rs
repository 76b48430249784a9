//! Decodes ahead: a thread keeps a few frames ready, so that none is decoded at the moment it is
//! due.
//!
//! The thread decodes into the slots it is lent. If it is lent none, it uses its own buffers, which
//! circulate between the thread and the frame in use. A small looped set is decoded once and kept.

mod clock;
mod thread;

use std::collections::VecDeque;
use std::thread::JoinHandle;

use crossbeam::channel::{Receiver, Sender, bounded};
use lariat_message::{Centerlines, PixelFormat, SourceKind};

use crate::lent::LentSlot;
use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::Until;
use clock::OwnClock;
use thread::{Room, decode_ahead};

/// Number of decoded frames that are kept ready.
const AHEAD: usize = 3;
/// Number of the thread's own buffers: one for each frame kept ready, one in use, and one being
/// decoded.
const OWN: usize = AHEAD + 2;
/// Number of slots to borrow: one for each frame kept ready, and one being decoded.
const LENT: usize = AHEAD + 1;
/// Maximum decoded size of a looped set that is kept.
pub(crate) const KEPT_BYTES: u64 = 64 << 20;

/// A frame's geometry, without its number.
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

    pub(crate) fn frame(self, sequence: u64) -> Frame {
        let Self {
            width,
            height,
            stride,
            format,
        } = self;
        Frame {
            sequence,
            width,
            height,
            stride,
            format,
            exposed_ns: None,
            slot: None,
        }
    }
}

/// Outcome of one attempt at the next frame.
pub(crate) enum Step {
    /// A frame was decoded.
    Decoded(Layout),
    /// A frame was decoded, with the number and time from its recording.
    Recorded(Layout, Moment),
    /// A frame was lost; the sentence says why.
    Lost(String),
    /// An error; the frame numbers show how many frames it cost. The text is a sentence.
    Wrong(String),
    /// A sentence worth reporting; nothing is lost.
    News(String),
    /// The pass has ended, with a sentence if its end is damaged.
    End(Option<String>),
}

/// Number and time of a frame within its pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Moment {
    /// Number from 1; a gap is a loss.
    pub(crate) number: u64,
    /// Time since the first frame of the pass, in nanoseconds. It increases from frame to frame.
    pub(crate) after_ns: u64,
}

/// Turns files into frames.
pub(crate) trait Decode: Send + 'static {
    /// Moves (back) to the first frame.
    fn rewind(&mut self) -> Result<(), SourceError>;

    /// Decodes the next frame into the start of `pixels`, which has room for the largest one.
    fn decode(&mut self, pixels: &mut [u8]) -> Step;

    /// Fills in the truth of the frame just decoded, as [`FrameSource::truth`] does. Returns
    /// `false` if it is unknown.
    fn truth(&mut self, _truth: &mut Centerlines) -> bool {
        false
    }

    /// Returns a sentence about the frame just decoded that is not an error.
    fn take_news(&mut self) -> Option<String> {
        None
    }

    /// Returns the error for a pass that yielded no frame while nothing failed.
    fn nothing(&self) -> SourceError {
        SourceError::NothingDecoded {
            reason: "there is none".to_owned(),
        }
    }
}

/// Properties of a set of frames that are known before the first frame.
pub(crate) struct Plan {
    pub(crate) kind: SourceKind,
    pub(crate) largest_frame_bytes: usize,
    pub(crate) native_fps: Option<f64>,
    pub(crate) looped: bool,
    /// True if the truth of its frames is known.
    pub(crate) has_truth: bool,
    /// Size of the whole set when decoded, in bytes.
    pub(crate) total_bytes: u64,
    pub(crate) warnings: Vec<String>,
    pub(crate) news: Option<String>,
}

/// Memory that a frame is decoded into.
struct Buffer {
    pixels: Memory,
    /// `None` if the source does not know the truth.
    truth: Option<Box<Truth>>,
}

enum Memory {
    Own(Vec<u8>),
    Lent(LentSlot),
}

/// A frame's truth, if it is known.
struct Truth {
    centerlines: Centerlines,
    is_known: bool,
}

impl Buffer {
    fn pixels(&mut self) -> &mut [u8] {
        match &mut self.pixels {
            Memory::Own(pixels) => pixels,
            Memory::Lent(slot) => slot,
        }
    }
}

struct Picture {
    frame: Frame,
    /// Time since the first frame of its pass, if known.
    after_ns: Option<u64>,
    /// Empty if the frame is in a slot.
    pixels: Vec<u8>,
    truth: Option<Box<Truth>>,
}

enum Message {
    Decoded(Frame, Option<u64>, Buffer),
    Warning(String),
    News(String),
    /// All frames are decoded; contains the number of sequence numbers used.
    End(u64),
    Failed(SourceError),
}

/// A source whose frames are decoded ahead.
pub(crate) struct Ahead {
    plan: Plan,
    /// `None` once the source is dropped; the same holds for `spare`.
    ready: Option<Receiver<Message>>,
    spare: Option<Sender<Buffer>>,
    decoder: Option<JoinHandle<()>>,
    warnings: VecDeque<String>,
    news: VecDeque<String>,
    /// True if all pictures are held so that they can be shown again. Otherwise only the current
    /// picture is held.
    keeps: bool,
    held: Vec<Picture>,
    current: usize,
    /// True if the first frame is held and not yet shown.
    is_primed: bool,
    /// True if there are buffers to decode the other frames into.
    is_supplied: bool,
    /// Number of sequence numbers in a round, once the thread has ended.
    round: Option<u64>,
    rounds: u64,
    clock: OwnClock,
    /// Spare truth buffers.
    spare_truths: Vec<Box<Truth>>,
    has_ended: bool,
}

impl Ahead {
    /// Decodes the first frame, so that a set that cannot be decoded fails before a frame is due.
    /// The other frames follow once there are buffers for them.
    pub(crate) fn start(decoder: impl Decode, plan: Plan) -> Result<Self, SourceError> {
        let (ready_in, ready) = bounded(AHEAD);
        // Never full: it holds all buffers that exist.
        let (spare, spare_out) = bounded(OWN + LENT);
        let keeps = plan.looped && plan.total_bytes <= KEPT_BYTES;
        let again = plan.looped && !keeps;
        let room = Room {
            spare: spare_out,
            bytes: plan.largest_frame_bytes,
            left: None,
        };
        let decoder = std::thread::Builder::new()
            .name("decode".to_owned())
            .spawn(move || decode_ahead(decoder, again, room, &ready_in))
            .map_err(SourceError::NoThread)?;
        let mut source = Self {
            warnings: plan.warnings.iter().cloned().collect(),
            news: plan.news.iter().cloned().collect(),
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
            clock: OwnClock::default(),
            spare_truths: Vec::new(),
            has_ended: false,
        };
        source.supply(Memory::Own(Vec::new()));
        source.is_primed = source.turn()?;
        Ok(source)
    }

    /// Gives the thread a buffer to decode into, unless the thread has ended.
    fn supply(&mut self, pixels: Memory) {
        let none = || {
            Box::new(Truth {
                centerlines: Centerlines::EMPTY,
                is_known: false,
            })
        };
        let truth = self.plan.has_truth;
        let truth = truth.then(|| self.spare_truths.pop().unwrap_or_else(none));
        if let Some(spare) = &self.spare {
            let _ = spare.try_send(Buffer { pixels, truth });
        }
    }

    /// Makes the next picture the current one. Returns `false` at the end.
    fn turn(&mut self) -> Result<bool, SourceError> {
        while self.round.is_none() {
            match self.ready.as_ref().and_then(|ready| ready.recv().ok()) {
                Some(Message::Decoded(frame, after_ns, buffer)) => {
                    self.hold(frame, after_ns, buffer);
                    return Ok(true);
                }
                Some(Message::Warning(warning)) => self.warnings.push_back(warning),
                Some(Message::News(news)) => self.news.push_back(news),
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

    fn hold(&mut self, mut frame: Frame, after_ns: Option<u64>, buffer: Buffer) {
        let pixels = match buffer.pixels {
            Memory::Own(mut pixels) => {
                if self.keeps {
                    pixels.shrink_to_fit();
                }
                pixels
            }
            Memory::Lent(slot) => {
                frame.slot = Some(slot.give_back());
                Vec::new()
            }
        };
        if self.keeps {
            if self.is_supplied {
                self.supply(Memory::Own(Vec::new()));
            }
        } else if let Some(shown) = self.held.pop() {
            self.spare_truths.extend(shown.truth);
            if shown.frame.slot.is_none() && frame.slot.is_none() {
                self.supply(Memory::Own(shown.pixels));
            }
        }
        self.held.push(Picture {
            frame,
            after_ns,
            pixels,
            truth: buffer.truth,
        });
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
        // Kept pictures are copied each time they are shown.
        if self.keeps { 0 } else { LENT }
    }

    fn lend(&mut self, slot: LentSlot) {
        self.is_supplied = true;
        self.supply(Memory::Lent(slot));
    }

    fn advance(&mut self, _until: &Until) -> Result<Next, SourceError> {
        if !std::mem::replace(&mut self.is_supplied, true) {
            (0..OWN).for_each(|_| self.supply(Memory::Own(Vec::new())));
        }
        if self.has_ended {
            return Ok(Next::End);
        }
        if !std::mem::take(&mut self.is_primed) {
            // An error also ends the source.
            self.has_ended = true;
            self.has_ended = !self.turn()?;
        }
        if self.has_ended {
            return Ok(Next::End);
        }
        if let Some(after_ns) = self.held[self.current].after_ns {
            self.clock.advance(after_ns);
        }
        Ok(Next::Frame(self.frame()))
    }

    fn pass_over(&mut self, sequence: u64) -> Result<bool, SourceError> {
        if self.plan.looped {
            return Ok(false);
        }
        let until = Until::forever();
        while let Next::Frame(frame) = self.advance(&until)? {
            if frame.sequence > sequence {
                // This frame is shown at the next call.
                self.is_primed = true;
                break;
            }
        }
        self.clock = OwnClock::default();
        Ok(true)
    }

    fn has_truth(&self) -> bool {
        self.plan.has_truth
    }

    fn truth(&self, truth: &mut Centerlines) -> bool {
        let current = self.held.get(self.current);
        let known = current.and_then(|picture| picture.truth.as_deref());
        let Some(known) = known.filter(|known| known.is_known) else {
            return false;
        };
        let trace = truth.trace;
        *truth = known.centerlines;
        truth.trace = trace;
        true
    }

    fn due_after_ns(&self) -> Option<u64> {
        let current = self.held.get(self.current)?;
        current.after_ns.map(|_| self.clock.due_ns)
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
        self.news.pop_front()
    }
}

impl Drop for Ahead {
    /// Waits until the thread has released its slots. The thread ends at its next message, and may
    /// write into a slot until then.
    fn drop(&mut self) {
        (self.ready, self.spare) = (None, None);
        if let Some(decoder) = self.decoder.take() {
            // A panic of the thread was already reported when its next frame was missing.
            let _ = decoder.join();
        }
    }
}
