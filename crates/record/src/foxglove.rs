//! Images in Foxglove's schemas, `foxglove.RawImage` and `foxglove.CompressedImage`, and in those
//! of ROS 1.
//!
//! Only two protocol buffer messages (<https://protobuf.dev/programming-guides/encoding>) are
//! needed. Both have only a handful of fields, with field numbers fixed by Foxglove's schemas, and
//! are read in place. JSON encodes bytes in base64.

use std::borrow::Cow;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;

use crate::cdr::{CdrError, Decoder};
use crate::images::{CompressedImageRecord, ImageRecord, stamp};

/// Encoding of an image message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// CDR, with the fields of `sensor_msgs`.
    Ros2,
    /// ROS 1's own encoding, with the fields of `sensor_msgs`.
    Ros1,
    /// CDR, with the fields of `foxglove_msgs`.
    FoxgloveCdr,
    /// A protocol buffer in Foxglove's schema.
    Protobuf,
    /// JSON in Foxglove's schema.
    Json,
}

impl Form {
    /// Reads an image. Pixels that have to be converted are stored in `room`.
    pub(crate) fn image<'a>(
        self,
        bytes: &'a [u8],
        room: &'a mut Room,
    ) -> Result<ImageRecord<'a>, CdrError> {
        match self {
            Self::Ros2 => ImageRecord::decode(bytes),
            Self::Ros1 => ros1_image(bytes),
            Self::FoxgloveCdr => cdr_image(bytes),
            Self::Protobuf => protobuf_image(bytes),
            Self::Json => json_image(bytes, room),
        }
    }

    /// Reads a picture file.
    pub(crate) fn picture<'a>(
        self,
        bytes: &'a [u8],
        room: &'a mut Room,
    ) -> Result<CompressedImageRecord<'a>, CdrError> {
        match self {
            Self::Ros2 => CompressedImageRecord::decode(bytes),
            Self::Ros1 => ros1_picture(bytes),
            Self::FoxgloveCdr => cdr_picture(bytes),
            Self::Protobuf => protobuf_picture(bytes),
            Self::Json => json_picture(bytes, room),
        }
    }
}

/// Memory that is reused from one message to the next.
#[derive(Debug, Default)]
pub(crate) struct Room {
    text: String,
    pub(crate) data: Vec<u8>,
}

/// Reads `foxglove_msgs/msg/RawImage`.
fn cdr_image(bytes: &[u8]) -> Result<ImageRecord<'_>, CdrError> {
    let mut from = Decoder::new(bytes)?;
    Ok(ImageRecord {
        stamp_ns: stamp(&mut from)?,
        frame_id: from.string()?,
        width: from.value()?,
        height: from.value()?,
        encoding: from.string()?,
        is_big_endian: false,
        step: from.value()?,
        data: from.bytes()?,
    })
}

/// Reads `foxglove_msgs/msg/CompressedImage`.
fn cdr_picture(bytes: &[u8]) -> Result<CompressedImageRecord<'_>, CdrError> {
    let mut from = Decoder::new(bytes)?;
    let (stamp_ns, frame_id, data) = (stamp(&mut from)?, from.string()?, from.bytes()?);
    Ok(CompressedImageRecord {
        stamp_ns,
        frame_id,
        format: from.string()?,
        data,
    })
}

/// Reads fields of ROS 1: little endian, unaligned, with lengths before texts and lists.
struct Ros1<'a>(&'a [u8]);

impl<'a> Ros1<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], CdrError> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CdrError::Short)?;
        self.0 = rest;
        Ok(taken)
    }

    fn u32(&mut self) -> Result<u32, CdrError> {
        let bytes = self.bytes(4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn list(&mut self) -> Result<&'a [u8], CdrError> {
        let count = self.u32()?;
        self.bytes(count as usize)
    }

    fn text(&mut self) -> Result<&'a str, CdrError> {
        std::str::from_utf8(self.list()?).map_err(|_| CdrError::Text)
    }

    /// Reads a header: a count, a stamp and a frame of reference.
    fn header(&mut self) -> Result<(u64, &'a str), CdrError> {
        let (_count, s, ns) = (self.u32()?, self.u32()?, self.u32()?);
        Ok((stamp_ns(i64::from(s), i64::from(ns)), self.text()?))
    }
}

fn ros1_image(bytes: &[u8]) -> Result<ImageRecord<'_>, CdrError> {
    let mut from = Ros1(bytes);
    let (stamp_ns, frame_id) = from.header()?;
    let (height, width, encoding) = (from.u32()?, from.u32()?, from.text()?);
    let is_big_endian = from.bytes(1)? != [0];
    Ok(ImageRecord {
        stamp_ns,
        frame_id,
        width,
        height,
        encoding,
        is_big_endian,
        step: from.u32()?,
        data: from.list()?,
    })
}

fn ros1_picture(bytes: &[u8]) -> Result<CompressedImageRecord<'_>, CdrError> {
    let mut from = Ros1(bytes);
    let (stamp_ns, frame_id) = from.header()?;
    Ok(CompressedImageRecord {
        stamp_ns,
        frame_id,
        format: from.text()?,
        data: from.list()?,
    })
}

fn stamp_ns(s: i64, ns: i64) -> u64 {
    let (s, ns) = (s.max(0) as u64, ns.max(0) as u64);
    s.saturating_mul(1_000_000_000).saturating_add(ns)
}

/// Reads the fields of a protocol buffer.
struct Protobuf<'a>(&'a [u8]);

/// Value of a field.
enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

impl<'a> Protobuf<'a> {
    fn varint(&mut self) -> Result<u64, CdrError> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let (byte, rest) = self.0.split_first().ok_or(CdrError::Short)?;
            self.0 = rest;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(CdrError::Protobuf)
    }

    fn bytes(&mut self, count: u64) -> Result<&'a [u8], CdrError> {
        let count = usize::try_from(count).map_err(|_| CdrError::Short)?;
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CdrError::Short)?;
        self.0 = rest;
        Ok(taken)
    }

    /// Returns the next field's number and value; `None` at the end.
    fn next(&mut self) -> Result<Option<(u64, Value<'a>)>, CdrError> {
        if self.0.is_empty() {
            return Ok(None);
        }
        let fixed = |bytes: &[u8]| {
            bytes
                .iter()
                .rev()
                .fold(0, |n, byte| n << 8 | u64::from(*byte))
        };
        let tag = self.varint()?;
        let value = match tag & 7 {
            0 => Value::Number(self.varint()?),
            1 => Value::Number(fixed(self.bytes(8)?)),
            2 => {
                let count = self.varint()?;
                Value::Bytes(self.bytes(count)?)
            }
            5 => Value::Number(fixed(self.bytes(4)?)),
            _ => return Err(CdrError::Protobuf),
        };
        Ok(Some((tag >> 3, value)))
    }
}

/// Reads `google.protobuf.Timestamp`.
fn timestamp(bytes: &[u8]) -> Result<u64, CdrError> {
    let (mut s, mut ns) = (0, 0);
    let mut fields = Protobuf(bytes);
    while let Some(field) = fields.next()? {
        match field {
            (1, Value::Number(number)) => s = number as i64,
            (2, Value::Number(number)) => ns = number as i64,
            _ => {}
        }
    }
    Ok(stamp_ns(s, ns))
}

fn utf8(bytes: &[u8]) -> Result<&str, CdrError> {
    std::str::from_utf8(bytes).map_err(|_| CdrError::Text)
}

/// Reads an image. Fields that are left out are 0, or empty.
fn protobuf_image(bytes: &[u8]) -> Result<ImageRecord<'_>, CdrError> {
    let mut image = ImageRecord {
        stamp_ns: 0,
        frame_id: "",
        width: 0,
        height: 0,
        encoding: "",
        is_big_endian: false,
        step: 0,
        data: &[],
    };
    let mut fields = Protobuf(bytes);
    while let Some(field) = fields.next()? {
        match field {
            (1, Value::Bytes(bytes)) => image.stamp_ns = timestamp(bytes)?,
            (2, Value::Number(number)) => image.width = number as u32,
            (3, Value::Number(number)) => image.height = number as u32,
            (4, Value::Bytes(bytes)) => image.encoding = utf8(bytes)?,
            (5, Value::Number(number)) => image.step = number as u32,
            (6, Value::Bytes(bytes)) => image.data = bytes,
            (7, Value::Bytes(bytes)) => image.frame_id = utf8(bytes)?,
            _ => {}
        }
    }
    Ok(image)
}

fn protobuf_picture(bytes: &[u8]) -> Result<CompressedImageRecord<'_>, CdrError> {
    let mut picture = CompressedImageRecord {
        stamp_ns: 0,
        frame_id: "",
        format: "",
        data: &[],
    };
    let mut fields = Protobuf(bytes);
    while let Some(field) = fields.next()? {
        match field {
            (1, Value::Bytes(bytes)) => picture.stamp_ns = timestamp(bytes)?,
            (2, Value::Bytes(bytes)) => picture.data = bytes,
            (3, Value::Bytes(bytes)) => picture.format = utf8(bytes)?,
            (4, Value::Bytes(bytes)) => picture.frame_id = utf8(bytes)?,
            _ => {}
        }
    }
    Ok(picture)
}

/// Fields of both messages. Each message has some of them.
#[derive(Deserialize)]
#[serde(default)]
struct Json<'a> {
    timestamp: JsonTime,
    width: u32,
    height: u32,
    step: u32,
    #[serde(borrow)]
    encoding: Cow<'a, str>,
    #[serde(borrow)]
    format: Cow<'a, str>,
    #[serde(borrow)]
    data: Cow<'a, str>,
}

impl Default for Json<'_> {
    fn default() -> Self {
        let none = || Cow::Borrowed("");
        Self {
            timestamp: JsonTime::default(),
            width: 0,
            height: 0,
            step: 0,
            encoding: none(),
            format: none(),
            data: none(),
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct JsonTime {
    sec: i64,
    nsec: i64,
}

fn json<'a>(bytes: &'a [u8], room: &mut Room) -> Result<Json<'a>, CdrError> {
    let message: Json = serde_json::from_slice(bytes).map_err(|_| CdrError::Json)?;
    room.data.clear();
    let decoded = STANDARD.decode_vec(message.data.as_bytes(), &mut room.data);
    decoded.map_err(|_| CdrError::Base64)?;
    Ok(message)
}

fn json_image<'a>(bytes: &[u8], room: &'a mut Room) -> Result<ImageRecord<'a>, CdrError> {
    let message = json(bytes, room)?;
    room.text = message.encoding.into_owned();
    Ok(ImageRecord {
        stamp_ns: stamp_ns(message.timestamp.sec, message.timestamp.nsec),
        frame_id: "",
        width: message.width,
        height: message.height,
        encoding: &room.text,
        is_big_endian: false,
        step: message.step,
        data: &room.data,
    })
}

fn json_picture<'a>(
    bytes: &[u8],
    room: &'a mut Room,
) -> Result<CompressedImageRecord<'a>, CdrError> {
    let message = json(bytes, room)?;
    room.text = message.format.into_owned();
    Ok(CompressedImageRecord {
        stamp_ns: stamp_ns(message.timestamp.sec, message.timestamp.nsec),
        frame_id: "",
        format: &room.text,
        data: &room.data,
    })
}
