//! Small recordings, written by the mcap crate's own writer.

#![allow(dead_code)] // Each test uses a part.

use std::collections::BTreeMap;
use std::io::Cursor;

use lariat_message::{
    Centerlines, Curve, Descriptor, Descriptors, FrameHeader, PixelFormat, Trace,
};
use lariat_record::{
    COMPRESSED_IMAGE, ENCODING, IMAGE, Losses, Record, SCHEMA_ENCODING, Schema,
    encode_compressed_image, encode_image,
};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions, Writer};

/// Offset from a trace's times to log times.
pub(crate) const OFFSET_NS: u64 = 1_700_000_000_000_000_000;
/// Time from one frame to the next.
pub(crate) const PERIOD_NS: u64 = 10_000_000;
pub(crate) const WIDTH: u32 = 8;
pub(crate) const HEIGHT: u32 = 4;

/// A file being made.
pub(crate) struct Made {
    writer: Writer<Cursor<Vec<u8>>>,
    channels: BTreeMap<String, u16>,
    cdr: Vec<u8>,
}

impl Made {
    pub(crate) fn new(compression: Option<Compression>) -> Self {
        Self::with(WriteOptions::new().compression(compression))
    }

    pub(crate) fn with(options: WriteOptions) -> Self {
        let options = options.chunk_size(None).disable_seeking(true);
        let writer = options.create(Cursor::new(Vec::new())).unwrap();
        Self {
            writer,
            channels: BTreeMap::new(),
            cdr: Vec::new(),
        }
    }

    pub(crate) fn metadata(&mut self, entries: &[(&str, &str)]) {
        let entries = entries.iter();
        let metadata = Metadata {
            name: "lariat".to_owned(),
            metadata: entries
                .map(|(key, value)| (key.to_string(), value.to_string()))
                .collect(),
        };
        self.writer.write_metadata(&metadata).unwrap();
    }

    pub(crate) fn attachment(&mut self, name: &str, bytes: &[u8]) {
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: "text/plain".to_owned(),
            data: bytes.into(),
        };
        self.writer.attach(&attachment).unwrap();
    }

    pub(crate) fn message<R: Record>(&mut self, topic: &str, log_time_ns: u64, message: &R) {
        message.encode(&mut self.cdr);
        self.put(topic, &R::SCHEMA, log_time_ns);
    }

    pub(crate) fn image(
        &mut self,
        topic: &str,
        log_time_ns: u64,
        header: &FrameHeader,
        bytes: &[u8],
    ) {
        assert!(encode_image(header, bytes, log_time_ns, "r", &mut self.cdr));
        self.put(topic, &IMAGE, log_time_ns);
    }

    pub(crate) fn picture(&mut self, topic: &str, log_time_ns: u64, format: &str, file: &[u8]) {
        encode_compressed_image(file, format, log_time_ns, "r", &mut self.cdr);
        self.put(topic, &COMPRESSED_IMAGE, log_time_ns);
    }

    /// Adds a message of any kind.
    pub(crate) fn raw(&mut self, topic: &str, schema: &Schema, log_time_ns: u64, bytes: &[u8]) {
        self.cdr = bytes.to_vec();
        self.put(topic, schema, log_time_ns);
    }

    /// Adds a message in an encoding other than ROS 2's.
    pub(crate) fn encoded(
        &mut self,
        topic: &str,
        [encoding, schema, schema_encoding]: [&str; 3],
        log_time_ns: u64,
        bytes: &[u8],
    ) {
        let writer = &mut self.writer;
        let channel = *self.channels.entry(topic.to_owned()).or_insert_with(|| {
            let schema = writer.add_schema(schema, schema_encoding, b"").unwrap();
            let none = BTreeMap::new();
            writer.add_channel(schema, topic, encoding, &none).unwrap()
        });
        let header = MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: log_time_ns,
            publish_time: log_time_ns,
        };
        writer.write_to_known_channel(&header, bytes).unwrap();
    }

    /// Adds an image on its own channel, even if another channel has the same topic.
    pub(crate) fn image_apart(
        &mut self,
        topic: &str,
        log_time_ns: u64,
        header: &FrameHeader,
        bytes: &[u8],
    ) {
        let others = self.channels.remove(topic);
        self.image(topic, log_time_ns, header, bytes);
        self.channels
            .extend(others.map(|id| (topic.to_owned(), id)));
    }

    fn put(&mut self, topic: &str, schema: &Schema, log_time_ns: u64) {
        let writer = &mut self.writer;
        let channel = *self.channels.entry(topic.to_owned()).or_insert_with(|| {
            let text = schema.text.as_bytes();
            let schema = writer
                .add_schema(schema.name, SCHEMA_ENCODING, text)
                .unwrap();
            let none = BTreeMap::new();
            writer.add_channel(schema, topic, ENCODING, &none).unwrap()
        });
        let header = MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: log_time_ns,
            publish_time: log_time_ns,
        };
        writer.write_to_known_channel(&header, &self.cdr).unwrap();
    }

    /// Ends a chunk.
    pub(crate) fn end_chunk(&mut self) {
        self.writer.flush().unwrap();
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.writer.finish().unwrap();
        self.writer.into_inner().into_inner()
    }
}

pub(crate) fn trace(sequence: u64) -> Trace {
    let begin_ns = sequence * PERIOD_NS;
    Trace {
        sequence,
        captured: sequence,
        extracted: sequence,
        fitted: sequence,
        exposed_ns: begin_ns,
        captured_ns: begin_ns + 1_000,
        extract_started_ns: begin_ns + 2_000,
        extracted_ns: begin_ns + 3_000,
        fit_started_ns: begin_ns + 4_000,
        fitted_ns: begin_ns + 5_000,
        ..Trace::EMPTY
    }
}

pub(crate) fn header(sequence: u64) -> FrameHeader {
    FrameHeader {
        trace: Trace {
            extracted: 0,
            fitted: 0,
            extract_started_ns: 0,
            extracted_ns: 0,
            fit_started_ns: 0,
            fitted_ns: 0,
            ..trace(sequence)
        },
        width: WIDTH,
        height: HEIGHT,
        stride: WIDTH,
        pixel_format: PixelFormat::Gray8 as u32,
        source: 1,
        ..FrameHeader::default()
    }
}

pub(crate) fn pixels(sequence: u64) -> Vec<u8> {
    let all = 0..u64::from(WIDTH * HEIGHT);
    all.map(|i| (i * 7 + sequence * 13) as u8).collect()
}

pub(crate) fn centerlines(sequence: u64) -> Centerlines {
    let mut message = Centerlines {
        trace: trace(sequence),
        width: WIDTH,
        height: HEIGHT,
        count: 1,
        ..Centerlines::EMPTY
    };
    let curve = &mut message.curves[0];
    *curve = Curve {
        track: 1,
        count: 5,
        width_px: 3.5,
        length_px: sequence as f32,
        ..Curve::EMPTY
    };
    for (i, point) in curve.points[..5].iter_mut().enumerate() {
        *point = [i as f32, sequence as f32 / 3.0];
    }
    message
}

pub(crate) fn descriptors(sequence: u64) -> Descriptors {
    let mut message = Descriptors {
        trace: trace(sequence),
        width: WIDTH,
        height: HEIGHT,
        count: 1,
        unit: 1,
        ..Descriptors::EMPTY
    };
    message.curves[0] = Descriptor {
        track: 1,
        degree: 3,
        count: 4,
        rms: sequence as f64 / 7.0,
        ..Descriptor::EMPTY
    };
    message
}

/// A rig's recording: `per_chunk` frames in each of `chunks`, with all their results.
pub(crate) fn rig(compression: Option<Compression>, chunks: u64, per_chunk: u64) -> Vec<u8> {
    let mut made = Made::new(compression);
    made.metadata(&[
        ("version", "0.1.0"),
        ("monotonic_to_wall_ns", &OFFSET_NS.to_string()),
    ]);
    made.attachment("lariat.toml", b"[fit]\norder = 8\n");
    for chunk in 0..chunks {
        for sequence in chunk * per_chunk + 1..=(chunk + 1) * per_chunk {
            frame(&mut made, sequence);
        }
        made.end_chunk();
    }
    made.finish()
}

/// Adds a frame and all its results.
pub(crate) fn frame(made: &mut Made, sequence: u64) {
    let header = header(sequence);
    let trace = trace(sequence);
    let at = |ns| OFFSET_NS + ns;
    made.message("/r/frames", at(trace.captured_ns), &header);
    made.image(
        "/r/image",
        at(trace.captured_ns),
        &header,
        &pixels(sequence),
    );
    made.message("/r/truth", at(trace.captured_ns), &centerlines(sequence));
    made.message(
        "/r/centerlines",
        at(trace.extracted_ns),
        &centerlines(sequence),
    );
    made.message(
        "/r/descriptors",
        at(trace.fitted_ns),
        &descriptors(sequence),
    );
    let losses = Losses {
        at_ns: sequence,
        ..Losses::default()
    };
    made.message("/r/losses", at(trace.fitted_ns), &losses);
}
