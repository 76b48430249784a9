//! Reads the index at the end of a closed recording.

use super::error::RecordingError;
use super::fields::Fields;
use super::index::Index;
use super::layout::{END_BYTES, HEAD_BYTES, MAGIC, Records, kind};
use super::storage::Storage;

/// Reads the index; `None` if it is missing or not trustworthy.
///
/// # Errors
/// Fails if the file cannot be read.
pub(super) fn read(storage: &dyn Storage) -> Result<Option<Index>, RecordingError> {
    let Some(footer_at) = storage.size().checked_sub(END_BYTES) else {
        return Ok(None);
    };
    let mut end = Vec::new();
    storage.read_into(footer_at, END_BYTES, &mut end)?;
    let Some((start, crc)) = footer(&end) else {
        return Ok(None);
    };
    // The checksum covers everything up to itself.
    let checked = (footer_at + HEAD_BYTES + 16).checked_sub(start);
    let Some(bytes) = checked.filter(|_| start > 0 && start <= footer_at) else {
        return Ok(None);
    };
    let mut summary = Vec::new();
    storage.read_into(start, bytes, &mut summary)?;
    if crc != 0 && crc != crc32fast::hash(&summary) {
        return Ok(None);
    }
    let mut index = Index::default();
    let mut has_messages = false;
    let records = &summary[..(footer_at - start) as usize];
    let mut walk = Records::new(records);
    for (kind, record) in &mut walk {
        if !index.take(kind, record) {
            return Ok(None);
        }
        has_messages |= kind == kind::CHUNK_INDEX;
    }
    // Without chunks, or without their index, a scan has to find the messages.
    let whole = walk.0.0.is_empty() && has_messages && !index.channels.is_empty();
    index.parts.sort_by_key(|indexed| indexed.part.offset);
    Ok(Some(index).filter(|_| whole))
}

/// Returns the start of the summary, and its checksum.
fn footer(end: &[u8]) -> Option<(u64, u32)> {
    let mut fields = Fields(end.strip_suffix(&MAGIC)?);
    if (fields.u8()?, fields.u64()?) != (kind::FOOTER, 20) {
        return None;
    }
    let start = fields.u64()?;
    let _offsets_start = fields.u64()?;
    Some((start, fields.u32()?))
}
