//! Frames as JPEG, now and then, on a session of their own: paced, and of the lowest priority, so that no descriptor waits behind them.

use std::time::Duration;

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use lariat_chain::pipeline::FrameView;
use lariat_chain::stop::Stop;
use lariat_wire::{Domain, FRAMES, Message, Rig, now_ns};
use zenoh::qos::Priority;

use super::Heard;
use crate::args::Place;
use crate::channel::{Read, Woken};
use crate::chunks::chunks;
use crate::datagram::Kind;
use crate::pack::pack;
use crate::say;
use crate::session::{Open, Way, Wire};

/// As `lariat view` has it.
const QUALITY: u8 = 82;
/// Between two datagrams: 1.2 kB each 0.3 ms are a third of 100 Mbit/s.
const PACE_NS: u64 = 300_000;
/// How often it is looked whether frames are wanted, and written.
const CHECK: Duration = Duration::from_millis(250);

/// Sends frames while they are asked for, until it is told to stop; how many.
pub(super) fn run(rig: &Rig, place: &Place, heard: &Heard, stop: &Stop) -> u64 {
    crate::give_way();
    let mut sent = 0;
    let mut said = None;
    while !stop.asked() {
        if heard.frames_ns(now_ns()).is_some() {
            match send(rig, place, heard, stop) {
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
        stop.sleep_until(now_ns() + CHECK.as_nanos() as u64);
    }
    sent
}

/// The same for as long as they are asked for.
fn send(rig: &Rig, place: &Place, heard: &Heard, stop: &Stop) -> Result<u64> {
    let domain = Domain::open()?;
    let place = place
        .of_frames()
        .context("its port is the last: choose another one")?;
    let wire = Wire::open(Open::Listen, &place.to_string(), Way::Pictures, rig)
        .with_context(|| format!("it cannot be listened on {place}"))?;
    let mut frames = Read::new(&FRAMES, Woken::No);
    let (mut picture, mut datagram) = (Vec::new(), Vec::new());
    let (mut sent, mut check_due_ns, mut due_ns) = (0_u64, 0, now_ns());
    while let Some(period_ns) = heard.frames_ns(now_ns()).filter(|_| !stop.asked()) {
        if now_ns() >= check_due_ns {
            frames.follow(&domain, rig, true);
            check_due_ns = now_ns() + CHECK.as_nanos() as u64;
        }
        let mut newest = None;
        while let Some(frame) = frames.next() {
            newest = Some(frame);
        }
        if newest.is_some_and(|frame| encode(&frame, &mut picture).is_some()) {
            sent += 1;
            for (head, chunk) in chunks(sent as u32, &picture) {
                heard.outgoing.write(Kind::Picture, &mut datagram, |to| {
                    to.extend(head);
                    to.extend(chunk);
                });
                wire.put(&datagram, Priority::Background);
                stop.sleep_until(now_ns() + PACE_NS);
            }
        }
        due_ns = (due_ns + period_ns).max(now_ns());
        stop.sleep_until(due_ns.min(check_due_ns));
    }
    wire.close();
    Ok(sent)
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
