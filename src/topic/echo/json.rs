//! A message as a JSON object on one line: its channel and all its fields. A curve contains its
//! points; the pixels of a frame are left out.

use anyhow::Result;
use lariat_wire::{CenterlinePoints, Descriptor};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::message_json::{Object, write_fields};
use crate::topic::probe::Any;
use crate::versioned::Versioned;

/// Formats the message as one line.
pub(super) fn line(channel: &str, message: Any) -> Result<String> {
    Ok(serde_json::to_string(&Versioned::first(Line { channel, message }))? + "\n")
}

struct Line<'a> {
    channel: &'a str,
    message: Any<'a>,
}

impl Serialize for Line<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("channel", self.channel)?;
        match self.message {
            Any::Image(header, pixels) => {
                write_fields(header, &[], &mut map)?;
                map.serialize_entry("bytes", &pixels.len())?;
            }
            Any::Centerlines(message) => write_fields(message, &[], &mut map)?,
            Any::Descriptors3(message) => write_fields(message, &[], &mut map)?,
            Any::Descriptors(message) => {
                write_fields(message, &["curves", "centerlines"], &mut map)?;
                let points = message.centerlines();
                let curves = message.curves().iter().zip(points);
                let curves: Vec<_> = curves.map(|(curve, points)| Rope(curve, points)).collect();
                map.serialize_entry("curves", &curves)?;
            }
        }
        map.end()
    }
}

/// A curve with the points that it was fitted to.
struct Rope<'a>(&'a Descriptor, &'a CenterlinePoints);

impl Serialize for Rope<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        write_fields(self.0, &[], &mut map)?;
        // The curve itself says whether it is closed.
        map.serialize_entry("centerline", &Object(self.1, &["closed"]))?;
        map.end()
    }
}
