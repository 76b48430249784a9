//! Sends frames as JPEG, at the requested rate, and masks as they come, compressed by zstd. They
//! have a socket of their own, are paced, and go last in queues, so that no descriptor waits behind
//! them. If several come while one is being sent, the newest is next.

use std::net::SocketAddr;
use std::os::fd::AsFd;

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use lariat_chain::pipeline::FrameView;
use lariat_chain::stages::arrangement;
use lariat_chain::stop::Stop;
use lariat_wire::{Domain, FRAMES, FrameHeader, MASKS, Message, Rig, now_ns};
use zstd::bulk::Compressor;

use super::{CHECK, LARGEST_DATAGRAM, Near, Peers, Rank, Socket, ask, sleep};
use crate::args::{Also, Place};
use crate::channel::{Read, Woken};
use crate::chunks::chunks;
use crate::datagram::{Incoming, Kind, Refused};
use crate::pack::pack;
use crate::peers::Wants;
use crate::say;

/// JPEG quality, the same as in `lariat view`.
const QUALITY: u8 = 82;
/// Time between two datagrams: 1.2 kB every 0.3 ms are a third of 100 Mbit/s.
const PACE_NS: u64 = 300_000;
const CHECK_NS: u64 = CHECK.as_nanos() as u64;

/// Compression level: the fastest, because any level finds the long runs of a mask.
const LEVEL: i32 = 1;
const MASKS_WANTED: Wants = Wants::Also(Also::Masks);

/// Sends requested frames and masks until told to stop. Returns the number of each.
pub(super) fn run(
    rig: &Rig,
    place: &Place,
    near: &Near,
    mut incoming: Incoming,
    stop: &Stop,
) -> [u64; 2] {
    arrangement::give_way();
    let mut sent = [0; 2];
    let mut said = None;
    while !stop.asked() {
        if near.want_pictures() {
            let done = Pictures::open(place, near, &mut incoming)
                .and_then(|mut pictures| pictures.send(rig, stop, &mut sent));
            if let Err(cause) = done {
                let cause = format!("no frames and masks are sent: {cause:#}");
                if said.as_ref() != Some(&cause) {
                    say(&cause);
                }
                said = Some(cause);
            }
        }
        stop.sleep_until(now_ns() + CHECK_NS);
    }
    sent
}

impl Near {
    /// Returns whether anybody wants frames or masks.
    fn want_pictures(&self) -> bool {
        let (peers, now_ns) = (self.peers(), now_ns());
        peers.want(Wants::Frames, now_ns) || peers.want(MASKS_WANTED, now_ns)
    }
}

/// The socket of frames and masks, and the far sides that receive them.
struct Pictures<'n> {
    near: &'n Near,
    incoming: &'n mut Incoming,
    socket: Socket,
    peers: Peers,
    buffer: Vec<u8>,
    datagram: Vec<u8>,
}

impl<'n> Pictures<'n> {
    fn open(place: &Place, near: &'n Near, incoming: &'n mut Incoming) -> Result<Self> {
        let place = place
            .of_frames()
            .context("its port is the last: choose another one")?;
        let socket = Socket::listen(&place, Rank::Last)
            .with_context(|| format!("it cannot be listened on {place}"))?;
        Ok(Self {
            near,
            incoming,
            socket,
            peers: Peers::new()?,
            buffer: vec![0; LARGEST_DATAGRAM],
            datagram: Vec::new(),
        })
    }

    /// Sends frames and masks for as long as anybody wants any.
    fn send(&mut self, rig: &Rig, stop: &Stop, sent: &mut [u64; 2]) -> Result<()> {
        let domain = Domain::open()?;
        let mut frames = Read::new(&FRAMES, Woken::No);
        let mut masks = Read::new(&MASKS, Woken::Yes);
        let mut packer = Compressor::new(LEVEL).context("zstd has no memory")?;
        let (mut picture, mut check_ns, mut due_ns) = (Vec::new(), 0, now_ns());
        while !stop.asked() {
            self.hear();
            let now = now_ns();
            if now >= check_ns {
                if !self.near.want_pictures() {
                    break;
                }
                frames.follow(&domain, rig, self.peers.want(Wants::Frames, now));
                masks.follow(&domain, rig, self.peers.want(MASKS_WANTED, now));
                check_ns = now + CHECK_NS;
            }
            if let Some(mask) = newest(&mut masks)
                && pack_mask(&mask, &mut packer, &mut picture).is_some()
            {
                sent[1] += 1;
                self.put(Kind::Mask, sent[1] as u32, &picture, MASKS_WANTED, stop);
            }
            let period_ns = self.peers.frames_ns(now);
            if let Some(period_ns) = period_ns
                && now >= due_ns
            {
                due_ns = (due_ns + period_ns).max(now);
                let frame = newest(&mut frames);
                if frame.is_some_and(|frame| encode(&frame, &mut picture).is_some()) {
                    sent[0] += 1;
                    self.put(Kind::Picture, sent[0] as u32, &picture, Wants::Frames, stop);
                }
            }
            let due_ns = if period_ns.is_some() {
                due_ns
            } else {
                check_ns
            };
            self.sleep(&masks, due_ns.min(check_ns), stop);
        }
        Ok(())
    }

    /// Sleeps until a question or a mask may have come, until `due_ns`, or until a signal.
    fn sleep(&self, masks: &Read<[u8]>, due_ns: u64, stop: &Stop) {
        let both = [self.socket.as_fd(), stop.as_fd()];
        let reader = masks.receiver();
        // A reader that fails is closed when it is read next.
        let longest = reader.and_then(|reader| reader.before_poll().ok());
        match (reader.and_then(|reader| reader.descriptor()), longest) {
            (Some(bell), Some(longest)) => {
                let longest_ns = longest.map_or(u64::MAX, |longest| longest.as_nanos() as u64);
                let due_ns = due_ns.min(now_ns().saturating_add(longest_ns));
                sleep([both[0], both[1], bell], due_ns);
            }
            _ => sleep(both, due_ns),
        }
    }

    /// Answers all waiting questions.
    fn hear(&mut self) {
        while let Some((bytes, from)) = self.socket.next(&mut self.buffer) {
            let at_ns = now_ns();
            match self.incoming.read(bytes) {
                Ok(datagram) if datagram.kind == Kind::Ask => {
                    if let Some((question, told)) = ask(&mut self.peers, &datagram, from, at_ns) {
                        self.near.answer(&question, told, at_ns, &mut self.datagram);
                        self.socket.send(&self.datagram, from);
                    }
                }
                Ok(_) => self.near.refuse(Refused::Foreign),
                Err(cause) => self.near.refuse(cause),
            }
        }
    }

    fn put(&mut self, kind: Kind, number: u32, picture: &[u8], wants: Wants, stop: &Stop) {
        let to: Vec<SocketAddr> = self.peers.addresses(wants, now_ns()).collect();
        for (head, chunk) in chunks(number, picture) {
            let outgoing = &self.near.outgoing;
            outgoing.write(kind, &mut self.datagram, |into| {
                into.extend(head);
                into.extend(chunk);
            });
            for to in &to {
                self.socket.send(&self.datagram, *to);
                stop.sleep_until(now_ns() + PACE_NS);
            }
        }
    }
}

/// Returns the newest waiting message.
fn newest(reader: &mut Read<[u8]>) -> Option<Message<[u8]>> {
    let mut newest = None;
    while let Some(message) = reader.next() {
        newest = Some(message);
    }
    newest
}

/// Begins a picture: the length of its header, then the header.
fn begin(header: &FrameHeader, into: &mut Vec<u8>) {
    into.clear();
    into.extend([0; 2]);
    pack(header, into);
    let length = (into.len() - 2) as u16;
    into[..2].copy_from_slice(&length.to_le_bytes());
}

/// Writes a frame as its header and a JPEG; `None` if it is blank or cannot be encoded.
fn encode(frame: &Message<[u8]>, into: &mut Vec<u8>) -> Option<()> {
    let header = frame.header();
    if header.is_blank() {
        return None;
    }
    let pixels = FrameView::new(header, frame).image().ok()?.to_rgb();
    begin(header, into);
    let encoder = JpegEncoder::new_with_quality(into, QUALITY);
    encoder
        .write_image(
            &pixels,
            header.width,
            header.height,
            ExtendedColorType::Rgb8,
        )
        .ok()
}

/// Writes a mask as its header and compressed bytes; `None` if it is blank or cannot be compressed.
fn pack_mask(mask: &Message<[u8]>, packer: &mut Compressor, into: &mut Vec<u8>) -> Option<()> {
    let header = mask.header();
    if header.is_blank() {
        return None;
    }
    begin(header, into);
    into.extend(packer.compress(mask).ok()?);
    Some(())
}
