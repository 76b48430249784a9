//! Where the bytes of a recording are: in a file, or in memory. Read at places, so that several readers share one.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::error::RecordingError;

/// No part of a recording is larger: the largest image that extraction takes, 16384 pixels a side in RGB, fits.
const MOST_BYTES: u64 = 1 << 30;

/// Bytes at places.
pub(super) trait Storage: Send + Sync {
    fn size(&self) -> u64;

    /// Fills `into` with the bytes from `offset` on.
    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()>;
}

/// A file as large as it was when it was opened.
pub(super) struct FileStorage {
    file: File,
    size: u64,
}

impl FileStorage {
    /// Opens a file. One that is compressed by zstd as a whole is unpacked into a temporary file, as only the parts of a recording
    /// can be read at places.
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

/// The file that a file was packed from. If that is cut off or damaged, as much of it as there is.
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
    /// Reads a part into a buffer, which is emptied first. No more memory is taken than there are bytes.
    ///
    /// # Errors
    /// It does not lie within the file, it is too large, or it cannot be read.
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
        // What was read before needs not be zeroed again.
        buffer.resize(bytes as usize, 0);
        self.read_at(offset, buffer)?;
        Ok(())
    }

    /// As many bytes as there are, up to `into.len()`.
    pub(super) fn read_some<'a>(&self, offset: u64, into: &'a mut [u8]) -> io::Result<&'a [u8]> {
        let left = self.size().saturating_sub(offset);
        let count = into.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        self.read_at(offset, &mut into[..count])?;
        Ok(&into[..count])
    }
}

/// # Errors
/// A part of so many bytes is too large.
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
