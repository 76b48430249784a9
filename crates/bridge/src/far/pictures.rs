//! Frames that come as JPEG, as the rig's own: RGB, with their stamps on this machine's clock.

use std::io::Cursor;
use std::os::fd::AsFd;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};
use lariat_chain::stop::Stop;
use lariat_wire::{Delivery, Domain, FrameHeader, PixelFormat, Rig, Writer, now_ns};

use super::Upward;
use crate::args::Place;
use crate::chunks::Assembly;
use crate::clock::Offset;
use crate::datagram::{Incoming, Kind};
use crate::inbox::{Arrived, Inbox};
use crate::pack::unpack;
use crate::say;
use crate::session::{Open, Way, Wire, parts};
use crate::stamps::Stamps;
use crate::tally::Tally;

/// No larger picture is made: 8192 by 8192.
const LARGEST: u64 = 3 << 26;
/// Between two tries to connect.
const RETRY_NS: u64 = 500_000_000;
/// Without a picture for so long, the session is made anew.
const SILENCE_NS: u64 = 3_000_000_000;

/// Takes frames until it is told to stop; how many.
pub(super) fn run(
    rig: &Rig,
    place: &Place,
    incoming: Incoming,
    upward: &Mutex<Upward>,
    stop: &Stop,
) -> u64 {
    crate::give_way();
    match Pictures::new(rig, incoming).and_then(|mut pictures| pictures.carry(place, upward, stop))
    {
        Ok(taken) => taken,
        Err(cause) => {
            say(&format!("no frames are taken: {cause:#}"));
            0
        }
    }
}

/// The rig's frames, written here.
struct Pictures<'a> {
    rig: &'a Rig,
    incoming: Incoming,
    inbox: Arc<Inbox>,
    assembly: Assembly,
    /// Whose, and what came of them.
    from: (u64, Tally),
    stamps: Stamps,
    // Before the domain that it lives in.
    writer: Option<(usize, Writer<[u8]>)>,
    domain: Domain,
    said: Option<String>,
    taken: u64,
}

impl<'a> Pictures<'a> {
    fn new(rig: &'a Rig, incoming: Incoming) -> Result<Self> {
        Ok(Self {
            rig,
            incoming,
            inbox: Arc::new(Inbox::new().context("the system has no descriptor left")?),
            assembly: Assembly::default(),
            from: (0, Tally::default()),
            stamps: Stamps::default(),
            writer: None,
            domain: Domain::open()?,
            said: None,
            taken: 0,
        })
    }

    fn carry(&mut self, place: &Place, upward: &Mutex<Upward>, stop: &Stop) -> Result<u64> {
        let place = place
            .of_frames()
            .context("its port is the last: choose another one")?;
        let mut arrived = Arrived::default();
        while !stop.asked() {
            let Ok(wire) = Wire::open(Open::Connect, &place.to_string(), Way::Up, self.rig) else {
                // Frames are listened for once they were asked for.
                stop.sleep_until(now_ns() + RETRY_NS);
                continue;
            };
            let heard = self.inbox.clone();
            wire.hear(Way::Pictures, self.rig, move |at_ns, sample| {
                heard.put(at_ns, parts(sample))
            })?;
            let mut silent_ns = now_ns() + SILENCE_NS;
            while !stop.asked() && now_ns() < silent_ns {
                self.inbox.clone().sleep(silent_ns, stop.as_fd());
                while self.inbox.clone().next(&mut arrived) {
                    let near = upward.lock().unwrap_or_else(PoisonError::into_inner).near;
                    if let Some(near) = near
                        && self.take(&mut arrived, near).is_some()
                    {
                        silent_ns = now_ns() + SILENCE_NS;
                    }
                }
            }
            wire.close();
        }
        Ok(self.taken)
    }

    /// Takes a datagram of the process that answers; `None`: it is none of its, or makes no sense.
    fn take(&mut self, arrived: &mut Arrived, (process, offset): (u64, Offset)) -> Option<()> {
        let datagram = self.incoming.read(&mut arrived.bytes).ok()?;
        if datagram.kind != Kind::Picture || datagram.process != process {
            return None;
        }
        if self.from.0 != process {
            self.from = (process, Tally::default());
        }
        self.from.1.receive(datagram.count).then_some(())?;
        if let Some(picture) = self.assembly.take(datagram.says) {
            let (mut header, pixels) = decode(picture)?;
            self.stamps.set(&mut header.trace, &offset, arrived.at_ns);
            self.write(&header, &pixels);
        }
        Some(())
    }

    fn write(&mut self, header: &FrameHeader, pixels: &[u8]) {
        let cause = self
            .try_write(header, pixels)
            .err()
            .map(|cause| cause.to_string());
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

    fn try_write(&mut self, header: &FrameHeader, pixels: &[u8]) -> Result<()> {
        // A camera of larger pictures than before is another one.
        self.writer = self
            .writer
            .take()
            .filter(|(largest, _)| pixels.len() <= *largest);
        let (_, writer) = match &self.writer {
            Some(writer) => writer,
            None => {
                let writer = Writer::<[u8]>::frames(
                    &self.domain,
                    self.rig,
                    &Delivery::NewestWins,
                    pixels.len(),
                )?;
                self.writer.insert((pixels.len(), writer))
            }
        };
        let mut slot = writer.frame_slot(pixels.len())?;
        slot.copy_from_slice(pixels);
        *slot.header_mut() = *header;
        slot.send()?;
        Ok(())
    }
}

/// A picture, and what stands beside its pixels here; `None` if that is not what it says.
fn decode(picture: &[u8]) -> Option<(FrameHeader, Vec<u8>)> {
    let (length, rest) = picture.split_first_chunk()?;
    let (packed, jpeg) = rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))?;
    let mut header = FrameHeader::default();
    unpack(&mut header, packed).ok()?;
    let decoder = JpegDecoder::new(Cursor::new(jpeg)).ok()?;
    let is_meant = decoder.dimensions() == (header.width, header.height) && !header.is_blank();
    let bytes = decoder.total_bytes();
    if !is_meant || decoder.color_type() != ColorType::Rgb8 || bytes > LARGEST {
        return None;
    }
    let mut pixels = vec![0; bytes as usize];
    decoder.read_image(&mut pixels).ok()?;
    (header.stride, header.pixel_format) = (3 * header.width, PixelFormat::Rgb8 as u32);
    Some((header, pixels))
}
