//! A recording from a fuzzer's bytes, and the invariants that must hold for the result. Its
//! messages are lariat's own kinds with some bytes changed, in chunks that are complete, damaged or
//! cut off; or all bytes are arbitrary.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::num::NonZeroU64;
use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use lariat_capture::{FileOptions, Position, Range, RenderOptions, Source};
use lariat_record::{
    COMPRESSED_IMAGE, ENCODING, Entry, Frame, IMAGE, Losses, Pixels, Place, Record, Recording,
    SCHEMA_ENCODING, Schema, Span, encode_compressed_image, encode_image,
};
use lariat_message::{Centerlines, Descriptors, FrameHeader, PixelFormat, Trace};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions, Writer};

use crate::shown::{ScratchFile, show};

/// First bytes of a real recording.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Offset added to the times of a trace.
const OFFSET_NS: u64 = 1_700_000_000_000_000_000;
/// Maximum number of messages that are read, because a few bytes may claim millions.
const MOST: usize = 2000;

/// A file with messages in its chunks.
#[derive(Arbitrary, Debug)]
struct Made {
    compression: Packing,
    /// True if the chunks have checksums. Without them, changes in a chunk are not detected.
    checked: bool,
    about: bool,
    parts: Vec<Part>,
    closed: bool,
    changes: Vec<(u16, u8)>,
    length: Option<u16>,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Packing {
    None,
    Lz4,
    Zstd,
}

#[derive(Arbitrary, Debug)]
enum Part {
    Image(Image),
    Message(Message),
    Metadata(Vec<(String, String)>),
    Attachment(String, Vec<u8>),
    ChunkEnd,
}

#[derive(Arbitrary, Debug)]
struct Image {
    at: At,
    width: u8,
    height: u8,
    padding: u8,
    format: u8,
    is_mask: bool,
    picture: Option<(bool, Vec<u8>)>,
    changes: Vec<(u16, u8)>,
    without_header: bool,
}

/// Number and time of a frame.
#[derive(Arbitrary, Clone, Copy, Debug)]
struct At {
    sequence: u8,
    exposed: u16,
}

#[derive(Arbitrary, Debug)]
struct Message {
    at: At,
    kind: Kind,
    count: u8,
    changes: Vec<(u16, u8)>,
    length: Option<u16>,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Kind {
    Truth,
    Centerlines,
    Descriptors,
    Losses,
    Header,
}

/// Part of the recording to read.
#[derive(Arbitrary, Debug)]
struct Asked {
    from: Option<u8>,
    to: Option<u16>,
    every: u8,
    looped: bool,
}

/// Makes small recordings with a message of each kind, in chunks of each kind.
pub fn seeds() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for compression in [Packing::None, Packing::Lz4, Packing::Zstd] {
        for (checked, closed) in [(true, true), (false, true), (false, false)] {
            let made = Made {
                compression,
                checked,
                about: true,
                parts: (1..=4).flat_map(of_frame).collect(),
                closed,
                changes: Vec::new(),
                length: None,
            };
            seeds.push(made.bytes());
        }
    }
    seeds
}

/// All messages that are recorded for a frame.
fn of_frame(sequence: u8) -> Vec<Part> {
    let at = At {
        sequence,
        exposed: 100 * u16::from(sequence),
    };
    let image = |is_mask, picture| {
        Part::Image(Image {
            at,
            width: 5,
            height: 4,
            padding: 0,
            format: sequence,
            is_mask,
            picture,
            changes: Vec::new(),
            without_header: false,
        })
    };
    let message = |kind| {
        Part::Message(Message {
            at,
            kind,
            count: sequence,
            changes: Vec::new(),
            length: None,
        })
    };
    let kinds = [
        Kind::Truth,
        Kind::Centerlines,
        Kind::Descriptors,
        Kind::Losses,
    ];
    let mut parts = vec![image(false, None), image(true, None)];
    parts.extend(kinds.map(message));
    parts.push(Part::Attachment(
        "lariat.toml".to_owned(),
        b"[run]".to_vec(),
    ));
    parts.push(Part::ChunkEnd);
    parts
}

/// Reads a recording made from any bytes; a real file is read as it is.
pub fn run(data: &[u8]) {
    let (file, part, is_as_written) = if data.starts_with(MAGIC) {
        let part = Asked {
            from: Some(2),
            to: None,
            every: 2,
            looped: false,
        };
        (data.to_vec(), part, false)
    } else {
        let mut any = Unstructured::new(data);
        let Ok((made, part)) = <(Made, Asked)>::arbitrary(&mut any) else {
            return;
        };
        let is_as_written = made.changes.is_empty() && made.length.is_none();
        (made.bytes(), part, is_as_written)
    };
    let scratch = ScratchFile::new("mcap", &file);
    let Ok(recording) = Recording::from_bytes(file) else {
        return;
    };
    look_into(&recording, &part, is_as_written);
    let range = Range {
        from: part.from.map(|from| Position::Frame(from.max(1).into())),
        to: part
            .to
            .map(|to| Position::Time(Duration::from_micros(to.into()))),
        every: NonZeroU64::new(part.every.max(1).into()).expect("at least 1"),
    };
    let looped = part.looped;
    for range in [Range::default(), range] {
        let options = FileOptions {
            range,
            looped,
            ..FileOptions::default()
        };
        show(
            &Source::named(&[scratch.path()], options, RenderOptions::default()),
            200,
        );
    }
}

fn look_into(recording: &Recording, part: &Asked, is_as_written: bool) {
    let names: Vec<_> = recording.attachments().map(str::to_owned).collect();
    for name in names {
        let _ = recording.attachment(&name);
    }
    let _ = recording.topics();
    let frames = recording.frames();
    let whole = count(recording, Span::default());
    // A frame with a broken image is counted but not read, and a damaged index may say anything.
    if let (true, Some(whole), Ok(frames)) = (is_as_written, whole, frames) {
        assert!(
            whole <= frames,
            "{whole} frames are read, and {frames} are there"
        );
    }
    let span = Span {
        from: part.from.map(|from| Place::Frame(from.into())),
        to: part
            .to
            .map(|to| Place::After(Duration::from_micros(to.into()))),
    };
    if let (Some(part), Some(whole)) = (count(recording, span), whole) {
        assert!(part <= whole, "a part of {whole} frames has {part}");
    }
}

/// Counts the frames in a part; `None` if the part is too large.
fn count(recording: &Recording, span: Span) -> Option<u64> {
    let mut messages = recording.messages(span).ok()?;
    let mut frames = 0;
    for _ in 0..MOST {
        match messages.next() {
            Ok(None) => return Some(frames),
            Ok(Some(Entry::Frame(frame))) => {
                assert_makes_sense(&frame);
                frames += 1;
            }
            Ok(Some(Entry::Mask(frame))) => assert_makes_sense(&frame),
            // A message that was read can be written.
            Ok(Some(Entry::Centerlines(message) | Entry::Truth(message))) => again(message),
            Ok(Some(Entry::Descriptors(message))) => again(message),
            Ok(Some(Entry::Losses(message))) => again(message),
            Err(_) => {}
        }
    }
    None
}

fn again<R: Record>(message: &R) {
    let mut cdr = Vec::new();
    message.encode(&mut cdr);
}

fn assert_makes_sense(frame: &Frame) {
    if let Pixels::Raw(bytes) = frame.pixels {
        assert_eq!(frame.header.image_bytes(), Some(bytes.len()));
    }
}

/// A file under construction.
struct Making {
    writer: Writer<Cursor<Vec<u8>>>,
    channels: BTreeMap<&'static str, u16>,
}

impl Making {
    fn put(&mut self, topic: &'static str, schema: &Schema, at: At, cdr: &[u8]) {
        let writer = &mut self.writer;
        let channel = *self.channels.entry(topic).or_insert_with(|| {
            let text = schema.text.as_bytes();
            let schema = writer
                .add_schema(schema.name, SCHEMA_ENCODING, text)
                .expect("few");
            let none = BTreeMap::new();
            writer
                .add_channel(schema, topic, ENCODING, &none)
                .expect("few")
        });
        let log_time = OFFSET_NS + at.captured_ns();
        let header = MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        writer
            .write_to_known_channel(&header, cdr)
            .expect("in memory");
    }
}

impl At {
    fn captured_ns(self) -> u64 {
        u64::from(self.exposed) * 1000 + 500
    }

    fn trace(self) -> Trace {
        Trace {
            sequence: self.sequence.into(),
            captured: self.sequence.into(),
            exposed_ns: u64::from(self.exposed) * 1000,
            captured_ns: self.captured_ns(),
            ..Trace::EMPTY
        }
    }
}

impl Made {
    fn bytes(&self) -> Vec<u8> {
        let options = WriteOptions::new()
            .chunk_size(None)
            .disable_seeking(true)
            .calculate_chunk_crcs(self.checked)
            .compression(match self.compression {
                Packing::None => None,
                Packing::Lz4 => Some(Compression::Lz4),
                Packing::Zstd => Some(Compression::Zstd),
            });
        let mut making = Making {
            writer: options.create(Cursor::new(Vec::new())).expect("in memory"),
            channels: BTreeMap::new(),
        };
        if self.about {
            let about = [
                ("version", "0.1.0".to_owned()),
                ("monotonic_to_wall_ns", OFFSET_NS.to_string()),
            ];
            metadata(
                &mut making,
                about.map(|(key, value)| (key.to_owned(), value)).into(),
            );
        }
        for part in self.parts.iter().take(40) {
            part.put(&mut making);
        }
        if self.closed {
            making.writer.finish().expect("in memory");
        } else {
            let _ = making.writer.flush();
        }
        let mut file = making.writer.into_inner().into_inner();
        let length = file.len();
        for &(at, byte) in &self.changes {
            file[usize::from(at) % length] = byte;
        }
        if let Some(most) = self.length {
            file.truncate(most.into());
        }
        file
    }
}

fn metadata(making: &mut Making, entries: BTreeMap<String, String>) {
    let metadata = Metadata {
        name: "lariat".to_owned(),
        metadata: entries,
    };
    making.writer.write_metadata(&metadata).expect("in memory");
}

impl Part {
    fn put(&self, making: &mut Making) {
        match self {
            Self::Image(image) => image.put(making),
            Self::Message(message) => message.put(making),
            Self::Metadata(entries) => metadata(making, entries.iter().cloned().collect()),
            Self::Attachment(name, data) => {
                let attachment = Attachment {
                    log_time: 0,
                    create_time: 0,
                    name: name.clone(),
                    media_type: String::new(),
                    data: data.into(),
                };
                making.writer.attach(&attachment).expect("in memory");
            }
            Self::ChunkEnd => making.writer.flush().expect("in memory"),
        }
    }
}

impl Image {
    fn put(&self, making: &mut Making) {
        let all = PixelFormat::ALL;
        let format = all[usize::from(self.format) % all.len()];
        let (width, height) = (u32::from(self.width) % 17, u32::from(self.height) % 17);
        let stride = format.row_bytes(width) as u32 + u32::from(self.padding % 4);
        let header = FrameHeader {
            trace: self.at.trace(),
            width,
            height,
            stride,
            pixel_format: format as u32,
            source: 4,
            reserved: [0; 3],
        };
        let [headers, raw, files] = match self.is_mask {
            false => ["/r/frames", "/r/image", "/r/picture/image"],
            true => ["/r/masks", "/r/mask_image", "/r/picture/mask_image"],
        };
        let mut cdr = Vec::new();
        if !self.without_header {
            header.encode(&mut cdr);
            making.put(headers, &FrameHeader::SCHEMA, self.at, &cdr);
        }
        let log_ns = OFFSET_NS + self.at.captured_ns();
        match &self.picture {
            Some((png, file)) => {
                let name = if *png { "png" } else { "jpeg" };
                encode_compressed_image(file, name, log_ns, "r", &mut cdr);
                change(&mut cdr, &self.changes);
                making.put(files, &COMPRESSED_IMAGE, self.at, &cdr);
            }
            None => {
                let bytes = vec![self.width; format.image_bytes(stride, height)];
                if encode_image(&header, &bytes, log_ns, "r", &mut cdr) {
                    change(&mut cdr, &self.changes);
                    making.put(raw, &IMAGE, self.at, &cdr);
                }
            }
        }
    }
}

impl Message {
    fn put(&self, making: &mut Making) {
        let mut cdr = Vec::new();
        let trace = self.at.trace();
        let (topic, schema) = match self.kind {
            Kind::Truth | Kind::Centerlines => {
                let mut message = Box::new(Centerlines::EMPTY);
                message.trace = trace;
                message.count = u32::from(self.count) % 9;
                message
                    .curves
                    .iter_mut()
                    .for_each(|curve| curve.count = u32::from(self.count));
                message.encode(&mut cdr);
                match self.kind {
                    Kind::Truth => ("/r/truth", &Centerlines::SCHEMA),
                    _ => ("/r/centerlines", &Centerlines::SCHEMA),
                }
            }
            Kind::Descriptors => {
                let mut message = Box::new(Descriptors::EMPTY);
                message.trace = trace;
                message.count = u32::from(self.count) % 9;
                message
                    .curves
                    .iter_mut()
                    .for_each(|curve| curve.count = u32::from(self.count) % 33);
                message.encode(&mut cdr);
                ("/r/descriptors", &Descriptors::SCHEMA)
            }
            Kind::Losses => {
                Losses::default().encode(&mut cdr);
                ("/r/losses", &Losses::SCHEMA)
            }
            Kind::Header => {
                let header = FrameHeader {
                    trace,
                    ..FrameHeader::default()
                };
                header.encode(&mut cdr);
                ("/r/frames", &FrameHeader::SCHEMA)
            }
        };
        change(&mut cdr, &self.changes);
        if let Some(most) = self.length {
            cdr.truncate(most.into());
        }
        making.put(topic, schema, self.at, &cdr);
    }
}

fn change(bytes: &mut [u8], changes: &[(u16, u8)]) {
    let length = bytes.len();
    for &(at, byte) in changes {
        if length > 0 {
            bytes[usize::from(at) % length] = byte;
        }
    }
}
