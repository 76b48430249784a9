//! Reads and unpacks chunks into memory that is reused.

use std::io::Read;
use std::sync::Arc;

use super::error::RecordingError;
use super::layout::{ChunkHead, HEAD_BYTES, head, kind};
use super::storage::{Storage, check_size};

/// Maximum compression ratio of lz4: a byte of a match's length represents at most 255 bytes.
const LZ4_RATIO: u64 = 255;
/// Maximum compression ratio of zstd: a block of four bytes represents at most 128 KiB.
const ZSTD_RATIO: u64 = 32 * 1024;

/// A part of the file that contains records with messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Part {
    /// Position of a chunk's head, or of the first of some records.
    pub(super) offset: u64,
    /// Length in the file, including the head.
    pub(super) length: u64,
    /// True for a chunk, false for records outside of chunks.
    pub(super) is_chunk: bool,
}

/// Reads one part after the other.
pub(super) struct Unpacker {
    storage: Arc<dyn Storage>,
    /// The part as stored in the file.
    packed: Vec<u8>,
    unpacked: Vec<u8>,
    zstd: Option<zstd::bulk::Decompressor<'static>>,
    /// Buffer and range that contain the records.
    records: (Held, std::ops::Range<usize>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Held {
    Packed,
    Unpacked,
}

impl Unpacker {
    pub(super) fn new(storage: Arc<dyn Storage>) -> Self {
        Self {
            storage,
            packed: Vec::new(),
            unpacked: Vec::new(),
            zstd: None,
            records: (Held::Packed, 0..0),
        }
    }

    /// Records of the part that was loaded last.
    pub(super) fn records(&self) -> &[u8] {
        let (held, range) = &self.records;
        let bytes = match held {
            Held::Packed => &self.packed,
            Held::Unpacked => &self.unpacked,
        };
        &bytes[range.clone()]
    }

    /// Reads and unpacks a part, and verifies its checksum. After an error there are no records.
    pub(super) fn load(&mut self, part: Part) -> Result<(), RecordingError> {
        self.records = (Held::Packed, 0..0);
        let Part { offset, length, .. } = part;
        self.storage.read_into(offset, length, &mut self.packed)?;
        if !part.is_chunk {
            self.records.1 = 0..self.packed.len();
            return Ok(());
        }
        let damaged = |why| RecordingError::Damaged { offset, why };
        let chunk = match head(&self.packed) {
            Some((kind::CHUNK, bytes)) if bytes == length - HEAD_BYTES => {
                &self.packed[HEAD_BYTES as usize..]
            }
            _ => return Err(damaged("there should be a chunk")),
        };
        let about = ChunkHead::read(chunk).ok_or_else(|| damaged("a chunk's head is not valid"))?;
        let packed = usize::try_from(about.packed)
            .ok()
            .and_then(|packed| chunk[about.length..].get(..packed))
            .ok_or_else(|| damaged("a chunk is longer than its record"))?;
        check_size(offset, about.unpacked)?;
        let most = match about.compression {
            "" => 1,
            "lz4" => LZ4_RATIO,
            "zstd" => ZSTD_RATIO,
            other => return Err(RecordingError::Compression(other.to_owned())),
        };
        if about.unpacked > about.packed.saturating_mul(most) {
            return Err(damaged("a chunk says it holds more than it can"));
        }
        let size = about.unpacked as usize;
        self.unpacked.clear();
        let records = match about.compression {
            "" => {
                let begin = HEAD_BYTES as usize + about.length;
                self.records = (Held::Packed, begin..begin + packed.len());
                packed
            }
            compression => {
                let unpack = match compression {
                    "lz4" => unpack_lz4(packed, size, &mut self.unpacked),
                    _ => unpack_zstd(&mut self.zstd, packed, size, &mut self.unpacked),
                };
                unpack.map_err(|_| damaged("a chunk cannot be unpacked"))?;
                self.records = (Held::Unpacked, 0..self.unpacked.len());
                &self.unpacked[..]
            }
        };
        let whole = records.len() == size;
        if !whole || (about.crc != 0 && about.crc != crc32fast::hash(records)) {
            self.records = (Held::Packed, 0..0);
            return Err(damaged("a chunk's checksum is not that of its bytes"));
        }
        Ok(())
    }
}

fn unpack_lz4(packed: &[u8], size: usize, into: &mut Vec<u8>) -> std::io::Result<()> {
    into.reserve(size);
    let decoder = lz4::Decoder::new(packed)?;
    decoder.take(size as u64).read_to_end(into)?;
    Ok(())
}

fn unpack_zstd(
    kept: &mut Option<zstd::bulk::Decompressor<'static>>,
    packed: &[u8],
    size: usize,
    into: &mut Vec<u8>,
) -> std::io::Result<()> {
    let decoder = match kept {
        Some(decoder) => decoder,
        None => kept.insert(zstd::bulk::Decompressor::new()?),
    };
    // Writes only into the reserved capacity.
    into.reserve(size);
    decoder.decompress_to_buffer(packed, into)?;
    Ok(())
}
