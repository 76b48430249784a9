//! Messages as bytes for sockets, encoded number by number. Shared memory needs no encoding.

use std::io::{self, Read, Write};

use lariat_wire::{
    Centerlines, Descriptors, FrameHeader, MAX_CONTROL_POINTS, MAX_CURVES, MAX_POINTS, Trace,
};

/// Bytes of a trace: ten numbers.
const TRACE: usize = 80;
/// Bytes of a frame's header: the trace, and width, height, stride, format.
const HEADER: usize = TRACE + 16;

fn put_trace(bytes: &mut Vec<u8>, trace: &Trace) {
    for number in [
        trace.sequence,
        trace.captured,
        trace.extracted,
        trace.fitted,
        trace.exposed_ns,
        trace.captured_ns,
        trace.extract_started_ns,
        trace.extracted_ns,
        trace.fit_started_ns,
        trace.fitted_ns,
    ] {
        bytes.extend(number.to_ne_bytes());
    }
}

/// A reader of successive numbers. It returns zeros past the end.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        match self.0.split_first_chunk() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => [0; N],
        }
    }

    fn u32(&mut self) -> u32 {
        u32::from_ne_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_ne_bytes(self.take())
    }

    fn f32(&mut self) -> f32 {
        f32::from_ne_bytes(self.take())
    }

    fn f64(&mut self) -> f64 {
        f64::from_ne_bytes(self.take())
    }

    fn trace(&mut self) -> Trace {
        Trace {
            sequence: self.u64(),
            captured: self.u64(),
            extracted: self.u64(),
            fitted: self.u64(),
            exposed_ns: self.u64(),
            captured_ns: self.u64(),
            extract_started_ns: self.u64(),
            extracted_ns: self.u64(),
            fit_started_ns: self.u64(),
            fitted_ns: self.u64(),
            ..Trace::EMPTY
        }
    }
}

/// Writes a frame: header and pixels, without another copy of the pixels.
pub(super) fn write_frame(
    to: &mut impl Write,
    header: &FrameHeader,
    pixels: &[u8],
) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(HEADER);
    put_trace(&mut bytes, &header.trace);
    for number in [
        header.width,
        header.height,
        header.stride,
        header.pixel_format,
    ] {
        bytes.extend(number.to_ne_bytes());
    }
    to.write_all(&bytes)?;
    to.write_all(pixels)
}

/// Reads a frame whose size matches `pixels`. Returns `None` at the end.
pub(super) fn read_frame(
    from: &mut impl Read,
    pixels: &mut [u8],
) -> io::Result<Option<FrameHeader>> {
    let mut bytes = [0; HEADER];
    if !read_or_end(from, &mut bytes)? {
        return Ok(None);
    }
    from.read_exact(pixels)?;
    let mut numbers = Numbers(&bytes);
    Ok(Some(FrameHeader {
        trace: numbers.trace(),
        width: numbers.u32(),
        height: numbers.u32(),
        stride: numbers.u32(),
        pixel_format: numbers.u32(),
        ..FrameHeader::default()
    }))
}

/// Writes a message: its length, then its bytes, which `encode` appends.
pub(super) fn write(
    to: &mut impl Write,
    bytes: &mut Vec<u8>,
    encode: impl FnOnce(&mut Vec<u8>),
) -> io::Result<()> {
    bytes.clear();
    bytes.extend([0; 4]);
    encode(bytes);
    let length = (bytes.len() - 4) as u32;
    bytes[..4].copy_from_slice(&length.to_ne_bytes());
    to.write_all(bytes)
}

/// Reads a message's bytes. Returns `false` at the end.
pub(super) fn read(from: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<bool> {
    let mut length = [0; 4];
    if !read_or_end(from, &mut length)? {
        return Ok(false);
    }
    bytes.resize(u32::from_ne_bytes(length) as usize, 0);
    from.read_exact(bytes)?;
    Ok(true)
}

/// Returns `false` at the end of the input.
fn read_or_end(from: &mut impl Read, bytes: &mut [u8]) -> io::Result<bool> {
    match from.read_exact(bytes) {
        Ok(()) => Ok(true),
        Err(cause) if cause.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(cause) => Err(cause),
    }
}

pub(super) fn put_centerlines(bytes: &mut Vec<u8>, message: &Centerlines) {
    put_trace(bytes, &message.trace);
    for number in [message.width, message.height, message.count] {
        bytes.extend(number.to_ne_bytes());
    }
    for curve in message.curves() {
        let numbers = [curve.track, curve.status, curve.closed, curve.border];
        for number in numbers.into_iter().chain([curve.count]).chain(curve.hidden) {
            bytes.extend(number.to_ne_bytes());
        }
        bytes.extend(curve.age_ns.to_ne_bytes());
        let sizes = [curve.width_px, curve.length_px, curve.confidence];
        let points = curve.points().iter().flatten();
        for &number in sizes.iter().chain(points).chain(curve.widths_px()) {
            bytes.extend(number.to_ne_bytes());
        }
    }
}

pub(super) fn take_centerlines(bytes: &[u8], message: &mut Centerlines) {
    let mut numbers = Numbers(bytes);
    message.trace = numbers.trace();
    (message.width, message.height) = (numbers.u32(), numbers.u32());
    message.count = numbers.u32().min(MAX_CURVES as u32);
    for curve in &mut message.curves[..message.count as usize] {
        (curve.track, curve.status) = (numbers.u32(), numbers.u32());
        (curve.closed, curve.border) = (numbers.u32(), numbers.u32());
        curve.count = numbers.u32().min(MAX_POINTS as u32);
        let count = curve.count as usize;
        curve.hidden.fill_with(|| numbers.u32());
        curve.age_ns = numbers.u64();
        (curve.width_px, curve.length_px) = (numbers.f32(), numbers.f32());
        curve.confidence = numbers.f32();
        curve.points[..count].fill_with(|| [numbers.f32(), numbers.f32()]);
        curve.widths_px[..count].fill_with(|| numbers.f32());
    }
}

pub(super) fn put_descriptors(bytes: &mut Vec<u8>, message: &Descriptors) {
    put_trace(bytes, &message.trace);
    for number in [message.width, message.height, message.count] {
        bytes.extend(number.to_ne_bytes());
    }
    for curve in message.curves() {
        let numbers = [
            curve.track,
            curve.status,
            curve.basis,
            curve.degree,
            curve.count,
        ];
        for number in numbers {
            bytes.extend(number.to_ne_bytes());
        }
        for number in curve.control_points().iter().flatten() {
            bytes.extend(number.to_ne_bytes());
        }
    }
}

pub(super) fn take_descriptors(bytes: &[u8], message: &mut Descriptors) {
    let mut numbers = Numbers(bytes);
    message.trace = numbers.trace();
    (message.width, message.height) = (numbers.u32(), numbers.u32());
    message.count = numbers.u32().min(MAX_CURVES as u32);
    for curve in &mut message.curves[..message.count as usize] {
        (curve.track, curve.status) = (numbers.u32(), numbers.u32());
        (curve.basis, curve.degree) = (numbers.u32(), numbers.u32());
        curve.count = numbers.u32().min(MAX_CONTROL_POINTS as u32);
        let count = curve.count as usize;
        curve.control_points[..count].fill_with(|| [numbers.f64(), numbers.f64()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace() -> Trace {
        Trace {
            sequence: 1,
            captured: 2,
            extracted: 3,
            fitted: 4,
            exposed_ns: 5,
            captured_ns: 6,
            extract_started_ns: 7,
            extracted_ns: 8,
            fit_started_ns: 9,
            fitted_ns: 10,
            ..Trace::EMPTY
        }
    }

    #[test]
    fn a_message_comes_out_of_a_socket_as_it_went_in() {
        let mut sent = Box::new(Centerlines::EMPTY);
        (sent.trace, sent.width, sent.height, sent.count) = (trace(), 640, 480, 1);
        (sent.curves[0].track, sent.curves[0].count) = (7, 120);
        (sent.curves[0].age_ns, sent.curves[0].hidden[3]) = (11, 5);
        sent.curves[0].confidence = 0.9;
        sent.curves[0].points[..120].fill([1.5, -2.5]);
        sent.curves[0].widths_px[..120].fill(12.0);
        let (mut socket, mut bytes) = (Vec::new(), Vec::new());
        write(&mut socket, &mut bytes, |bytes| {
            put_centerlines(bytes, &sent)
        })
        .expect("room");
        let mut from = &socket[..];
        assert!(read(&mut from, &mut bytes).expect("readable"));
        let mut received = Box::new(Centerlines::EMPTY);
        take_centerlines(&bytes, &mut received);
        assert!(sent == received);
        assert!(!read(&mut from, &mut bytes).expect("the end"));
    }

    #[test]
    fn descriptors_and_frames_come_out_as_they_went_in() {
        let mut sent = Box::new(Descriptors::EMPTY);
        (sent.trace, sent.width, sent.count) = (trace(), 640, 2);
        (sent.curves[1].degree, sent.curves[1].count) = (8, 9);
        sent.curves[1].control_points[..9].fill([0.1, 0.2]);
        let mut bytes = Vec::new();
        put_descriptors(&mut bytes, &sent);
        let mut received = Box::new(Descriptors::EMPTY);
        take_descriptors(&bytes, &mut received);
        assert!(sent == received);
        let header = FrameHeader {
            trace: trace(),
            width: 2,
            height: 1,
            stride: 6,
            pixel_format: 2,
            ..FrameHeader::default()
        };
        let mut socket = Vec::new();
        write_frame(&mut socket, &header, &[1, 2, 3, 4, 5, 6]).expect("room");
        let mut pixels = [0; 6];
        let read = read_frame(&mut &socket[..], &mut pixels).expect("readable");
        assert_eq!((read, pixels), (Some(header), [1, 2, 3, 4, 5, 6]));
    }
}
