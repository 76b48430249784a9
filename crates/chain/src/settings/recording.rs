//! `[record]`: content and format of recordings.

use crate::settings::meaning;
use lariat_record::{Compression, Images};
use std::time::Duration;
use toml::Value;

/// One million bytes.
const MB: usize = 1_000_000;

/// Content and format of recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Format of images.
    pub images: ImageKind,
    /// Quality of JPEGs, 1 to 100.
    pub quality: u8,
    /// Compression of chunks.
    pub compression: Compression,
    /// Memory for messages that wait for the disk.
    pub queue_bytes: usize,
    /// Duration of the past that is kept in memory until it is requested. Without it, everything is
    /// written immediately.
    pub ring: Option<Duration>,
    /// Maximum memory for the past.
    pub ring_bytes: usize,
    /// True if an existing recording, report or timeline is overwritten.
    pub replace: bool,
}

/// Format in which pixels are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageKind {
    Raw,
    Png,
    Jpeg,
    None,
}

impl Default for Recording {
    fn default() -> Self {
        Self {
            images: ImageKind::Raw,
            // At this quality, the centerlines of JPEGs agree with those of the image to a few
            // hundredths of a pixel.
            quality: 95,
            compression: Compression::None,
            // One second of 640 × 480 RGB at 60 frames/s, for a disk that pauses.
            queue_bytes: 64 * MB,
            ring: None,
            ring_bytes: 512 * MB,
            replace: false,
        }
    }
}

impl Recording {
    /// Returns the option for the recorder.
    pub fn images(&self) -> Images {
        match self.images {
            ImageKind::Raw => Images::Raw,
            ImageKind::Png => Images::Png,
            ImageKind::Jpeg => Images::Jpeg(self.quality),
            ImageKind::None => Images::None,
        }
    }
}

/// Names of the image formats.
pub const IMAGES: [(&str, ImageKind); 4] = [
    ("raw", ImageKind::Raw),
    ("png", ImageKind::Png),
    ("jpeg", ImageKind::Jpeg),
    ("none", ImageKind::None),
];

/// Names of the compressions.
pub const COMPRESSIONS: [(&str, Compression); 3] = [
    ("none", Compression::None),
    ("lz4", Compression::Lz4),
    ("zstd", Compression::Zstd),
];

/// Reads a size in MB, from 1 up to a limit for memory.
pub(super) fn megabytes(value: &Value) -> Result<usize, String> {
    const MOST_MB: i64 = 1 << 20;
    let whole = meaning::whole(value, 1, MOST_MB);
    whole
        .map(|mb| mb.unsigned_abs() as usize * MB)
        .map_err(|why| match value.as_str().map(size) {
            Some(Ok(bytes)) => format!(
                "it is a number of MB, without a unit: write {}",
                bytes.div_ceil(MB)
            ),
            _ => why,
        })
}

pub(super) fn megabytes_value(bytes: usize) -> Value {
    Value::Integer((bytes / MB) as i64)
}

/// Parses a size as people write it, `128MB`, `1GB` or `64MiB`, to bytes.
pub(super) fn size(text: &str) -> Result<usize, String> {
    const UNITS: [(&str, f64); 6] = [
        ("kb", 1e3),
        ("mb", 1e6),
        ("gb", 1e9),
        ("kib", 1024.0),
        ("mib", 1_048_576.0),
        ("gib", 1_073_741_824.0),
    ];
    let text = text.trim();
    let split = text
        .find(|c: char| !(c.is_ascii_digit() || c == '.'))
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let unit = unit.trim().to_lowercase();
    let factor = UNITS.iter().find(|(name, _)| *name == unit);
    match (number.parse::<f64>(), factor) {
        (Ok(number), Some((_, factor))) if (1e6..=1.1e12).contains(&(number * factor)) => {
            Ok((number * factor) as usize)
        }
        (Ok(_), Some(_)) => Err("a size is at least 1MB, and at most 1000GB".to_owned()),
        _ => Err("a size is a number with a unit, such as 128MB or 1GB".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_understood_as_people_write_them() {
        for (text, bytes) in [
            ("128MB", 128_000_000),
            ("1.5 GB", 1_500_000_000),
            ("64MiB", 67_108_864),
            ("1000kb", 1_000_000),
        ] {
            assert_eq!(size(text), Ok(bytes), "{text}");
        }
        for text in [
            "",
            "MB",
            "128",
            "5 parsecs",
            "10kB",
            "1e9MB",
            "-1MB",
            "5000000GB",
        ] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_size_with_its_unit_in_the_file_is_answered_with_the_number() {
        let said = megabytes(&Value::String("1GB".into())).unwrap_err();
        assert!(said.ends_with("write 1000"), "{said}");
        assert_eq!(megabytes(&Value::Integer(64)), Ok(64_000_000));
        assert!(megabytes(&Value::Integer(0)).is_err());
    }
}
