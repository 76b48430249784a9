//! Writes frames that arrive as JPEG to the rig, as RGB, and masks unchanged, with their timestamps
//! on this machine's clock.

use std::io::Cursor;
use std::os::fd::AsFd;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};
use lariat_chain::stages::arrangement;
use lariat_chain::stop::Stop;
use lariat_wire::{Delivery, Domain, FrameHeader, PixelFormat, Rig, WireError, Writer, now_ns};

use super::Upward;
use crate::args::Place;
use crate::chunks::Assembly;
use crate::clock::Offset;
use crate::datagram::{Datagram, Incoming, Kind, Outgoing};
use crate::key;
use crate::pack::unpack;
use crate::question::{Answer, Question};
use crate::say;
use crate::socket::{LARGEST_DATAGRAM, Rank, Socket, sleep};
use crate::stamps::Stamps;
use crate::tally::Tally;

/// Largest picture in bytes: 8192 by 8192 RGB pixels.
const LARGEST: u64 = 3 << 26;
/// Interval between two questions. The near side opens this port only after frames or masks were
/// asked for at the other port.
const ASK_NS: u64 = 250_000_000;
/// The bridge reconnects after this time without a picture.
const SILENCE_NS: u64 = 3_000_000_000;

/// The question that asks for frames and masks.
pub(super) struct Asks {
    outgoing: Arc<Outgoing>,
    question: Question,
}

impl Asks {
    pub(super) fn new(outgoing: Arc<Outgoing>, also: u8, frames_ms: u16) -> Self {
        let question = Question {
            token: 0,
            cookie: 0,
            also,
            frames_ms,
        };
        Self { outgoing, question }
    }

    /// Writes the next question.
    fn write(&mut self, into: &mut Vec<u8>) -> Result<()> {
        self.question.token = key::random_number()?;
        let question = &self.question;
        self.outgoing
            .write(Kind::Ask, into, |to| question.write(to));
        Ok(())
    }

    /// Takes an answer to the last question. Returns whether its cookie is new and must be repeated
    /// at once.
    fn take(&mut self, answer: &Answer) -> bool {
        answer.token == self.question.token
            && answer.cookie != std::mem::replace(&mut self.question.cookie, answer.cookie)
    }
}

/// Takes frames and masks until told to stop. Returns the number of each.
pub(super) fn run(
    rig: &Rig,
    place: &Place,
    asks: Asks,
    incoming: Incoming,
    upward: &Mutex<Upward>,
    stop: &Stop,
) -> [u64; 2] {
    arrangement::give_way();
    match Pictures::new(rig, asks, incoming)
        .and_then(|mut pictures| pictures.carry(place, upward, stop))
    {
        Ok(taken) => taken,
        Err(cause) => {
            say(&format!("no frames and masks are taken: {cause:#}"));
            [0; 2]
        }
    }
}

/// Result of handling a datagram.
enum Took {
    /// A part of a picture.
    Picture,
    /// A new cookie, to be repeated at once.
    AskAgain,
}

/// The rig's frames and masks, written here.
struct Pictures<'a> {
    rig: &'a Rig,
    asks: Asks,
    incoming: Incoming,
    /// The process that sends them.
    process: u64,
    stamps: Stamps,
    // Before the domain, so that they are dropped first.
    frames: Written,
    masks: Written,
    domain: Domain,
}

/// A channel of pictures, written here.
#[derive(Default)]
struct Written {
    assembly: Assembly,
    tally: Tally,
    /// The writer, and its largest picture in bytes.
    writer: Option<(usize, Writer<[u8]>)>,
    said: Option<String>,
    taken: u64,
}

impl<'a> Pictures<'a> {
    fn new(rig: &'a Rig, asks: Asks, incoming: Incoming) -> Result<Self> {
        Ok(Self {
            rig,
            asks,
            incoming,
            process: 0,
            stamps: Stamps::default(),
            frames: Written::default(),
            masks: Written::default(),
            domain: Domain::open()?,
        })
    }

    fn carry(&mut self, place: &Place, upward: &Mutex<Upward>, stop: &Stop) -> Result<[u64; 2]> {
        let place = place
            .of_frames()
            .context("its port is the last: choose another one")?;
        let (mut buffer, mut datagram) = (vec![0; LARGEST_DATAGRAM], Vec::new());
        let mut attempt = 0;
        while !stop.asked() {
            let address = place.addresses().map(|all| all[attempt % all.len()]);
            let opened = address.and_then(|at| Ok((Socket::toward(at, Rank::Last)?, at)));
            attempt += 1;
            let Ok((socket, at)) = opened else {
                stop.sleep_until(now_ns() + ASK_NS);
                continue;
            };
            let (mut ask_ns, mut silent_ns) = (0, now_ns() + SILENCE_NS);
            while !stop.asked() && now_ns() < silent_ns {
                if now_ns() >= ask_ns {
                    ask_ns = now_ns() + ASK_NS;
                    self.asks.write(&mut datagram)?;
                    socket.send(&datagram, at);
                }
                let Some((bytes, _)) = socket.next(&mut buffer) else {
                    sleep([socket.as_fd(), stop.as_fd()], ask_ns.min(silent_ns));
                    continue;
                };
                let near = upward.lock().unwrap_or_else(PoisonError::into_inner).near;
                match self.take(bytes, now_ns(), near) {
                    Some(Took::Picture) => silent_ns = now_ns() + SILENCE_NS,
                    Some(Took::AskAgain) => ask_ns = 0,
                    None => {}
                }
            }
        }
        Ok([self.frames.taken, self.masks.taken])
    }

    /// Takes a datagram; `None` if it is not from the process that answers, says nothing new, or
    /// makes no sense.
    fn take(&mut self, bytes: &mut [u8], at_ns: u64, near: Option<(u64, Offset)>) -> Option<Took> {
        let datagram = self.incoming.read(bytes).ok()?;
        let (process, offset) = near.filter(|(process, _)| *process == datagram.process)?;
        match datagram.kind {
            Kind::Answer => {
                let answer = Answer::read(datagram.says)?;
                self.asks.take(&answer).then_some(Took::AskAgain)
            }
            Kind::Picture | Kind::Mask => {
                if self.process != process {
                    self.process = process;
                    self.frames.tally = Tally::default();
                    self.masks.tally = Tally::default();
                }
                self.take_part(&datagram, &offset, at_ns)
            }
            _ => None,
        }
    }

    fn take_part(&mut self, datagram: &Datagram, offset: &Offset, at_ns: u64) -> Option<Took> {
        let is_mask = datagram.kind == Kind::Mask;
        let written = if is_mask {
            &mut self.masks
        } else {
            &mut self.frames
        };
        written.tally.receive(datagram.count).then_some(())?;
        if let Some(picture) = written.assembly.take(datagram.says) {
            let (mut header, body) = begin(picture)?;
            let pixels = if is_mask {
                unpack_mask(&header, body)?
            } else {
                decode(&mut header, body)?
            };
            self.stamps.set(&mut header.trace, offset, at_ns);
            let write = if is_mask {
                Writer::masks
            } else {
                Writer::frames
            };
            written.write(&header, &pixels, |largest| {
                write(&self.domain, self.rig, &Delivery::NewestWins, largest)
            });
        }
        Some(Took::Picture)
    }
}

impl Written {
    fn write(
        &mut self,
        header: &FrameHeader,
        pixels: &[u8],
        create: impl FnOnce(usize) -> Result<Writer<[u8]>, WireError>,
    ) {
        let written = self.try_write(header, pixels, create);
        let cause = written.err().map(|cause| cause.to_string());
        match &cause {
            None => self.taken += 1,
            Some(cause) => {
                self.writer = None;
                if self.said.as_ref() != Some(cause) {
                    say(cause);
                }
                self.said = Some(cause.clone());
            }
        }
    }

    fn try_write(
        &mut self,
        header: &FrameHeader,
        pixels: &[u8],
        create: impl FnOnce(usize) -> Result<Writer<[u8]>, WireError>,
    ) -> Result<(), WireError> {
        // Larger pictures than before come from another camera.
        self.writer = self
            .writer
            .take()
            .filter(|(largest, _)| pixels.len() <= *largest);
        let (_, writer) = match &self.writer {
            Some(writer) => writer,
            None => self.writer.insert((pixels.len(), create(pixels.len())?)),
        };
        let mut slot = writer.frame_slot(pixels.len())?;
        slot.copy_from_slice(pixels);
        *slot.header_mut() = *header;
        slot.send()?;
        Ok(())
    }
}

/// Splits a picture into its header and the rest; `None` if it is invalid.
fn begin(picture: &[u8]) -> Option<(FrameHeader, &[u8])> {
    let (length, rest) = picture.split_first_chunk()?;
    let (packed, body) = rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))?;
    let mut header = FrameHeader::default();
    unpack(&mut header, packed).ok()?;
    (!header.is_blank()).then_some((header, body))
}

/// Decodes a JPEG, and sets stride and pixel format of its header; `None` if they do not match.
fn decode(header: &mut FrameHeader, jpeg: &[u8]) -> Option<Vec<u8>> {
    let decoder = JpegDecoder::new(Cursor::new(jpeg)).ok()?;
    let is_meant = decoder.dimensions() == (header.width, header.height);
    let bytes = decoder.total_bytes();
    if !is_meant || decoder.color_type() != ColorType::Rgb8 || bytes > LARGEST {
        return None;
    }
    let mut pixels = vec![0; bytes as usize];
    decoder.read_image(&mut pixels).ok()?;
    (header.stride, header.pixel_format) = (3 * header.width, PixelFormat::Rgb8 as u32);
    Some(pixels)
}

/// Decompresses a mask; `None` if it does not match its header.
fn unpack_mask(header: &FrameHeader, packed: &[u8]) -> Option<Vec<u8>> {
    let bytes = header.image_bytes()?;
    let is_mask = *header == FrameHeader::of_mask(header);
    if !is_mask || bytes as u64 > LARGEST {
        return None;
    }
    let mask = zstd::bulk::decompress(packed, bytes).ok()?;
    (mask.len() == bytes).then_some(mask)
}
