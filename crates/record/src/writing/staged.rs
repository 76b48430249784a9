//! A file that grows by whole chunks. Data is kept in memory until it is committed, and then
//! written at once.
//!
//! A recorder that is killed therefore leaves only whole chunks, except for one that was being
//! written. A failed write can be undone, because the end of the last whole chunk is known.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The end of a file without an index. It contains no checksum of the data and no summary, so
/// readers scan the whole file.
const PLAIN_END: [u8; 50] = {
    const DATA_END: u8 = 0x0f;
    const FOOTER: u8 = 0x02;
    let mut end = [0; 50];
    end[0] = DATA_END;
    end[1] = 4;
    end[13] = FOOTER;
    end[14] = 20;
    let magic = *b"\x89MCAP0\r\n";
    let mut i = 0;
    while i < magic.len() {
        end[42 + i] = magic[i];
        i += 1;
    }
    end
};

/// The file. Flushing commits.
#[derive(Debug)]
pub(crate) struct Staged {
    file: File,
    /// True if the file cannot be written at a position.
    is_stream: bool,
    /// Length of the committed part of the file.
    committed: Arc<AtomicU64>,
    /// Bytes after the committed part.
    bytes: Vec<u8>,
    /// Position in `bytes` of the next write.
    at: usize,
    /// True once a commit has failed. All later ones fail as well.
    failed: bool,
}

impl Staged {
    /// Wraps an empty file, or a pipe or device.
    pub(crate) fn new(file: File, is_stream: bool) -> Self {
        Self {
            file,
            is_stream,
            committed: Arc::default(),
            bytes: Vec::new(),
            at: 0,
            failed: false,
        }
    }

    /// Returns the committed length of the file, to be shared with other code.
    pub(crate) fn committed(&self) -> Arc<AtomicU64> {
        self.committed.clone()
    }

    /// Waits until all committed data is on the disk.
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }

    fn base(&self) -> u64 {
        self.committed.load(Ordering::Relaxed)
    }

    fn commit(&mut self) -> io::Result<()> {
        if self.failed {
            return Err(io::Error::other("an earlier write has failed"));
        }
        let base = self.base();
        let written = match self.is_stream {
            true => self.file.write_all(&self.bytes),
            false => self.file.write_all_at(&self.bytes, base),
        };
        if let Err(cause) = written {
            self.failed = true;
            if self.is_stream {
                return Err(cause);
            }
            // Truncates to the last whole chunk, and appends an end if there is room. If there is
            // no room, readers find the end themselves.
            let _ = self.file.set_len(base);
            if self.file.write_all_at(&PLAIN_END, base).is_err() {
                let _ = self.file.set_len(base);
            }
            return Err(cause);
        }
        self.committed
            .store(base + self.bytes.len() as u64, Ordering::Relaxed);
        self.bytes.clear();
        self.at = 0;
        Ok(())
    }
}

impl Write for Staged {
    fn write(&mut self, from: &[u8]) -> io::Result<usize> {
        let over = from.len().min(self.bytes.len() - self.at);
        self.bytes[self.at..self.at + over].copy_from_slice(&from[..over]);
        self.bytes.extend_from_slice(&from[over..]);
        self.at += from.len();
        Ok(from.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.commit()
    }
}

impl Seek for Staged {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let base = self.base();
        let end = self.bytes.len();
        let at = match to {
            SeekFrom::Start(position) => position.checked_sub(base).map(|at| at as usize),
            SeekFrom::Current(by) => self.at.checked_add_signed(by as isize),
            SeekFrom::End(by) => end.checked_add_signed(by as isize),
        };
        self.at = at.filter(|&at| at <= end).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                "what was committed stays as it is",
            )
        })?;
        Ok(base + self.at as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn text(file: &mut File) -> String {
        let mut text = String::new();
        file.rewind().unwrap();
        file.read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn nothing_is_in_the_file_before_it_is_committed() {
        let mut file = tempfile::tempfile().unwrap();
        let mut staged = Staged::new(file.try_clone().unwrap(), false);
        staged.write_all(b"......chunk").unwrap();
        staged.seek(SeekFrom::Start(0)).unwrap();
        staged.write_all(b"header").unwrap();
        assert_eq!(text(&mut file), "");
        staged.seek(SeekFrom::End(0)).unwrap();
        staged.flush().unwrap();
        assert_eq!(text(&mut file), "headerchunk");
        assert_eq!(staged.stream_position().unwrap(), 11);
        staged.write_all(b", and another").unwrap();
        assert!(staged.seek(SeekFrom::Start(10)).is_err());
        staged.flush().unwrap();
        assert_eq!(text(&mut file), "headerchunk, and another");
    }

    #[test]
    fn writing_may_go_over_what_stands_there_and_on() {
        let file = tempfile::tempfile().unwrap();
        let mut staged = Staged::new(file, false);
        staged.write_all(b"abcdef").unwrap();
        staged.seek(SeekFrom::Current(-2)).unwrap();
        staged.write_all(b"EFGH").unwrap();
        assert_eq!(staged.bytes, b"abcdEFGH");
        assert_eq!(staged.stream_position().unwrap(), 8);
    }

    #[test]
    fn after_a_write_that_failed_there_is_no_other() {
        // A read-only handle simulates a broken disk.
        let path = tempfile::NamedTempFile::new().unwrap();
        let mut staged = Staged::new(File::open(path.path()).unwrap(), false);
        staged.write_all(b"chunk").unwrap();
        assert!(staged.flush().is_err());
        assert!(staged.flush().is_err());
        assert_eq!(std::fs::metadata(path.path()).unwrap().len(), 0);
    }

    #[test]
    fn the_plain_end_is_one_that_readers_know() {
        let mut file = b"\x89MCAP0\r\n".to_vec();
        file.push(0x01);
        file.extend(8_u64.to_le_bytes());
        file.extend([0; 8]);
        file.extend(PLAIN_END);
        assert!(mcap::Summary::read(&file).unwrap().is_none());
        let records = mcap::read::LinearReader::new(&file).unwrap();
        assert_eq!(records.map(Result::unwrap).count(), 3);
    }
}
