//! Metadata of a recording.

use std::collections::BTreeMap;

use super::error::RecordingError;
use super::index::Index;
use super::layout::{HEAD_BYTES, kind};
use super::storage::Storage;
use mcap::records::Record;

/// Name of lariat's metadata record.
pub const METADATA: &str = "lariat";

/// The metadata of a recording. Empty if lariat did not make it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct About(BTreeMap<String, String>);

impl About {
    pub(super) fn read(storage: &dyn Storage, index: &Index) -> Result<Self, RecordingError> {
        let mut about = Self::default();
        let mut buffer = Vec::new();
        for placed in &index.metadata {
            let Some(bytes) = placed.length.checked_sub(HEAD_BYTES) else {
                continue;
            };
            let Some(at) = placed.offset.checked_add(HEAD_BYTES) else {
                continue;
            };
            storage.read_into(at, bytes, &mut buffer)?;
            if let Ok(Record::Metadata(metadata)) = mcap::parse_record(kind::METADATA, &buffer)
                && metadata.name == METADATA
            {
                // Later records override earlier ones.
                about.0.extend(metadata.metadata);
            }
        }
        Ok(about)
    }

    /// Returns the value of a key.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }

    /// All entries, sorted by key.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(key, value)| (&key[..], &value[..]))
    }

    /// The release of lariat that made the recording.
    pub fn version(&self) -> Option<&str> {
        self.get("version")
    }

    /// Offset from a `CLOCK_MONOTONIC` time to a log time.
    pub fn monotonic_to_wall_ns(&self) -> Option<i64> {
        self.get("monotonic_to_wall_ns")?.parse().ok()
    }
}
