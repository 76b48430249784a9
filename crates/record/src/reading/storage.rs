//! Storage of a recording's bytes: a file, or memory. It is read at given positions, so that
//! several readers can share it.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::error::RecordingError;

/// Maximum size of a part. The largest image that extraction accepts, 16384 pixels per side in RGB,
/// fits.
const MOST_BYTES: u64 = 1 << 30;

/// Bytes that are read at given positions.
pub(super) trait Storage: Send + Sync {
    fn size(&self) -> u64;

    /// Fills `into` with the bytes from `offset`.
    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()>;
}

/// A file, with its size when it was opened.
pub(super) struct FileStorage {
    file: File,
    size: u64,
}

impl FileStorage {
    /// Opens a file. A file compressed by zstd as a whole is unpacked into a temporary file,
    /// because it cannot be read at a position.
    pub(super) fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = File::open(path)?;
        let mut magic = [0; ZSTD.len()];
        let is_packed = file.read_exact_at(&mut magic, 0).is_ok() && magic == ZSTD;
        let file = match is_packed {
            true => unpacked(&file)?,
            false => file,
        };
        let size = file.metadata()?.len();
        Ok(Self { file, size })
    }
}

/// The first bytes of a zstd frame (RFC 8878, section 3.1.1).
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// Unpacks a file into a temporary one. From a damaged or cut off file, it unpacks as much as
/// possible.
fn unpacked(packed: &File) -> Result<File, RecordingError> {
    let unpackable = |error| RecordingError::Unpack {
        folder: std::env::temp_dir(),
        error,
    };
    let mut file = tempfile::tempfile().map_err(unpackable)?;
    let mut decoder = zstd::stream::read::Decoder::new(packed).map_err(unpackable)?;
    let mut buffer = vec![0; 1 << 20];
    let mut is_empty = true;
    loop {
        match decoder.read(&mut buffer) {
            Ok(0) => return Ok(file),
            Ok(count) => file.write_all(&buffer[..count]).map_err(unpackable)?,
            Err(error) if is_empty => return Err(unpackable(error)),
            Err(_) => return Ok(file),
        }
        is_empty = false;
    }
}

impl Storage for FileStorage {
    fn size(&self) -> u64 {
        self.size
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        self.file.read_exact_at(into, offset)
    }
}

impl Storage for Vec<u8> {
    fn size(&self) -> u64 {
        self.len() as u64
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        let from = usize::try_from(offset).ok();
        let bytes = from.and_then(|from| self.get(from..)?.get(..into.len()));
        into.copy_from_slice(bytes.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }
}

impl dyn Storage + '_ {
    /// Reads a part into a buffer, replacing its contents. Memory is allocated only for bytes that
    /// exist.
    ///
    /// # Errors
    /// Fails if the part exceeds the file, is too large, or cannot be read.
    pub(super) fn read_into(
        &self,
        offset: u64,
        bytes: u64,
        buffer: &mut Vec<u8>,
    ) -> Result<(), RecordingError> {
        let end = offset.checked_add(bytes);
        if end.is_none_or(|end| end > self.size()) {
            let why = "it ends before this part does";
            return Err(RecordingError::Damaged { offset, why });
        }
        check_size(offset, bytes)?;
        // Keeps old contents, which need not be zeroed.
        buffer.resize(bytes as usize, 0);
        self.read_at(offset, buffer)?;
        Ok(())
    }

    /// Reads up to `into.len()` bytes, fewer at the end.
    pub(super) fn read_some<'a>(&self, offset: u64, into: &'a mut [u8]) -> io::Result<&'a [u8]> {
        let left = self.size().saturating_sub(offset);
        let count = into.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        self.read_at(offset, &mut into[..count])?;
        Ok(&into[..count])
    }
}

/// Checks that a part of this size is not too large.
///
/// # Errors
/// Fails if the part is too large.
pub(super) fn check_size(offset: u64, bytes: u64) -> Result<(), RecordingError> {
    if bytes > MOST_BYTES {
        let most = MOST_BYTES;
        return Err(RecordingError::TooLarge {
            offset,
            bytes,
            most,
        });
    }
    Ok(())
}
