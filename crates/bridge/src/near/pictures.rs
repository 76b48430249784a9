//! Frames as JPEG, now and then, from a socket of their own: paced, and behind all else in a queue, so that no descriptor waits behind them.

use std::net::SocketAddr;
use std::os::fd::AsFd;

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use lariat_chain::pipeline::FrameView;
use lariat_chain::stop::Stop;
use lariat_wire::{Domain, FRAMES, Message, Rig, now_ns};

use super::{CHECK, LARGEST_DATAGRAM, Near, Peers, Rank, Socket, ask};
use crate::args::Place;
use crate::channel::{Read, Woken};
use crate::chunks::chunks;
use crate::datagram::{Incoming, Kind, Refused};
use crate::pack::pack;
use crate::say;

/// As `lariat view` has it.
const QUALITY: u8 = 82;
/// Between two datagrams: 1.2 kB each 0.3 ms are a third of 100 Mbit/s.
const PACE_NS: u64 = 300_000;
const CHECK_NS: u64 = CHECK.as_nanos() as u64;

/// Sends frames while they are asked for, until it is told to stop; how many.
pub(super) fn run(
    rig: &Rig,
    place: &Place,
    near: &Near,
    mut incoming: Incoming,
    stop: &Stop,
) -> u64 {
    crate::give_way();
    let mut sent = 0;
    let mut said = None;
    while !stop.asked() {
        if near.peers().frames_ns(now_ns()).is_some() {
            let done = Pictures::open(place, near, &mut incoming)
                .and_then(|mut pictures| pictures.send(rig, stop));
            match done {
                Ok(pictures) => sent += pictures,
                Err(cause) => {
                    let cause = format!("no frames are sent: {cause:#}");
                    if said.as_ref() != Some(&cause) {
                        say(&cause);
                    }
                    said = Some(cause);
                }
            }
        }
        stop.sleep_until(now_ns() + CHECK_NS);
    }
    sent
}

/// The socket of frames, and those that they are sent to.
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

    /// Sends frames for as long as anybody wants some.
    fn send(&mut self, rig: &Rig, stop: &Stop) -> Result<u64> {
        let domain = Domain::open()?;
        let mut frames = Read::new(&FRAMES, Woken::No);
        let (mut picture, mut sent, mut check_ns, mut due_ns) = (Vec::new(), 0_u64, 0, now_ns());
        while !stop.asked() {
            self.hear();
            if now_ns() >= check_ns {
                if self.near.peers().frames_ns(now_ns()).is_none() {
                    break;
                }
                frames.follow(&domain, rig, true);
                check_ns = now_ns() + CHECK_NS;
            }
            let period_ns = self.peers.frames_ns(now_ns());
            if let Some(period_ns) = period_ns
                && now_ns() >= due_ns
            {
                due_ns = (due_ns + period_ns).max(now_ns());
                let mut newest = None;
                while let Some(frame) = frames.next() {
                    newest = Some(frame);
                }
                if newest.is_some_and(|frame| encode(&frame, &mut picture).is_some()) {
                    sent += 1;
                    self.put(sent as u32, &picture, stop);
                }
            }
            let due_ns = if period_ns.is_some() {
                due_ns
            } else {
                check_ns
            };
            self.socket.sleep(due_ns.min(check_ns), stop.as_fd());
        }
        Ok(sent)
    }

    /// Answers what is asked.
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

    fn put(&mut self, number: u32, picture: &[u8], stop: &Stop) {
        let to: Vec<SocketAddr> = self.peers.addresses(None, now_ns()).collect();
        for (head, chunk) in chunks(number, picture) {
            let outgoing = &self.near.outgoing;
            outgoing.write(Kind::Picture, &mut self.datagram, |into| {
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

/// A frame's header, its length before it, and the frame as a JPEG; `None` if there is no picture in it.
fn encode(frame: &Message<[u8]>, into: &mut Vec<u8>) -> Option<()> {
    let header = frame.header();
    if header.is_blank() {
        return None;
    }
    let pixels = FrameView::new(header, frame).image().ok()?.to_rgb();
    into.clear();
    into.extend([0; 2]);
    pack(header, into);
    let length = (into.len() - 2) as u16;
    into[..2].copy_from_slice(&length.to_le_bytes());
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
