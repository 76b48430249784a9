//! Decodes ahead: a thread keeps a few frames ready, so that none is decoded at the moment it is due.
//!
//! The buffers go round: thread → frame in use → thread. A small set that is shown again and again is decoded once
//! and kept.

use std::collections::{HashSet, VecDeque};
use std::thread;

use crossbeam::channel::{Receiver, Sender, bounded};
use lariat_wire::{PixelFormat, SourceKind};

use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::Until;

/// Frames that wait decoded; one more is in the making.
const AHEAD: usize = 3;
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

    /// Decodes the next frame into `pixels`, which it makes exactly as long as the frame.
    fn decode(&mut self, pixels: &mut Vec<u8>) -> Step;
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
}

struct Picture {
    frame: Frame,
    pixels: Vec<u8>,
}

enum Message {
    Picture(Picture),
    Warning(String),
    /// All is decoded; so many sequence numbers were used.
    End(u64),
    Failed(SourceError),
}

/// A source whose frames are decoded ahead.
pub(crate) struct Ahead {
    plan: Plan,
    ready: Receiver<Message>,
    spare: Sender<Vec<u8>>,
    warnings: VecDeque<String>,
    /// Whether all pictures are held, to be shown again; else only the one in use.
    keeps: bool,
    held: Vec<Picture>,
    current: usize,
    /// Whether the first frame is held and not yet shown.
    is_primed: bool,
    /// How many sequence numbers a round has, once the thread has ended.
    round: Option<u64>,
    rounds: u64,
    has_ended: bool,
}

impl Ahead {
    /// Starts to decode, and waits for the first frame: what cannot be decoded at all is known before it is due.
    pub(crate) fn start(decoder: impl Decode, plan: Plan) -> Result<Self, SourceError> {
        let (ready_in, ready) = bounded(AHEAD);
        // Never full: one more than the buffers there are.
        let (spare, spare_out) = bounded(AHEAD + 3);
        let keeps = plan.looped && plan.total_bytes <= KEPT_BYTES;
        let again = plan.looped && !keeps;
        // Not joined: when the source is dropped the thread ends by itself at its next message, and a slow disk must
        // not hold up who stops.
        thread::Builder::new()
            .name("decode".to_owned())
            .spawn(move || decode_ahead(decoder, again, &ready_in, &spare_out))
            .map_err(SourceError::NoThread)?;
        let mut source = Self {
            warnings: plan.warnings.iter().cloned().collect(),
            plan,
            ready,
            spare,
            keeps,
            held: Vec::new(),
            current: 0,
            is_primed: false,
            round: None,
            rounds: 0,
            has_ended: false,
        };
        source.is_primed = source.turn()?;
        Ok(source)
    }

    /// Makes the next picture the current one; `false` at the end.
    fn turn(&mut self) -> Result<bool, SourceError> {
        while self.round.is_none() {
            match self.ready.recv() {
                Ok(Message::Picture(picture)) => {
                    self.hold(picture);
                    return Ok(true);
                }
                Ok(Message::Warning(warning)) => self.warnings.push_back(warning),
                Ok(Message::End(round)) => {
                    self.round = Some(round);
                    self.current = self.held.len();
                }
                Ok(Message::Failed(error)) => return Err(error),
                Err(_) => return Err(SourceError::DecoderGone),
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

    fn hold(&mut self, picture: Picture) {
        if !self.keeps
            && let Some(shown) = self.held.pop()
        {
            // If the thread has ended there is no use for it.
            let _ = self.spare.try_send(shown.pixels);
        }
        self.held.push(picture);
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

    fn advance(&mut self, _until: &Until) -> Result<Next, SourceError> {
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
}

/// The thread: passes over the set, once or again and again, until it fails or nobody listens any more.
fn decode_ahead(
    mut decoder: impl Decode,
    again: bool,
    ready: &Sender<Message>,
    spare: &Receiver<Vec<u8>>,
) {
    let mut sequence = 0;
    // What was said is not said again on the next pass.
    let mut said = HashSet::new();
    loop {
        match one_pass(&mut decoder, &mut sequence, &mut said, ready, spare) {
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
    ready: &Sender<Message>,
    spare: &Receiver<Vec<u8>>,
) -> Option<Result<(), SourceError>> {
    let mut first_reason = None;
    let mut is_empty = true;
    if let Err(error) = decoder.rewind() {
        return Some(Err(error));
    }
    loop {
        // New ones only until enough are on their way round.
        let mut pixels = spare.try_recv().unwrap_or_default();
        let (warning, reason, is_end) = match decoder.decode(&mut pixels) {
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
                ready
                    .send(Message::Picture(Picture { frame, pixels }))
                    .ok()?;
                continue;
            }
            Step::Lost(reason) => {
                *sequence += 1;
                (format!("lost frame {sequence}: {reason}"), reason, false)
            }
            Step::End(Some(reason)) => (reason.clone(), reason, true),
            Step::End(None) => break,
        };
        if said.insert(reason.clone()) {
            ready.send(Message::Warning(warning)).ok()?;
        }
        first_reason.get_or_insert(reason);
        if is_end {
            break;
        }
    }
    if is_empty {
        let reason = first_reason.unwrap_or_else(|| "there is none".to_owned());
        return Some(Err(SourceError::NothingDecoded { reason }));
    }
    Some(Ok(()))
}
