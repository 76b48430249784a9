//! What a stage leaves to its successor: a file in memory that the chain holds for it, whatever becomes of the process.
//!
//! At its beginning stands a record of how far the stage is, written before each message it sends, so that no count is given twice
//! and none is forgotten: a message that was counted and not sent is lost, which is what the ledger then says. Behind it is what
//! the stage wants its successor to know, written after the message was sent, twice in turn, so that a kill in the middle of a write leaves
//! the one before whole. A write is one system call into memory.

use std::fs::File;
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileExt;

use anyhow::{Context, Result};
use rustix::fs::{MemfdFlags, memfd_create};

use super::status::Sent;

/// The variable that holds the file's number.
pub const HEIRLOOM_FD: &str = "LARIAT_HEIRLOOM_FD";

/// How far a stage is, over all its processes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Progress {
    /// How often it was started anew.
    pub restarts: u64,
    /// What it sent.
    pub sent: Sent,
    /// The count of the stage before in the message that was worked off last.
    pub taken: u64,
    /// How often it said that it lives without having sent anything.
    pub beats: u64,
}

const NUMBERS: usize = 5;
const HEAD: usize = 8 * NUMBERS;
/// Where what is handed on begins, how much there may be of it, and the message's number and its length before it.
const BODY: u64 = 64;
const LARGEST: u64 = 1 << 20;
const BODY_HEAD: u64 = 16;

impl Progress {
    fn to_bytes(self) -> [u8; HEAD] {
        let Sent {
            count,
            last_sequence,
        } = self.sent;
        let numbers = [self.restarts, count, last_sequence, self.taken, self.beats];
        let mut bytes = [0; HEAD];
        for (to, number) in bytes.chunks_exact_mut(8).zip(numbers) {
            to.copy_from_slice(&number.to_le_bytes());
        }
        bytes
    }

    fn of_bytes(bytes: [u8; HEAD]) -> Self {
        let mut numbers = [0; NUMBERS];
        for (number, from) in numbers.iter_mut().zip(bytes.as_chunks().0) {
            *number = u64::from_le_bytes(*from);
        }
        let [restarts, count, last_sequence, taken, beats] = numbers;
        Self {
            restarts,
            sent: Sent {
                count,
                last_sequence,
            },
            taken,
            beats,
        }
    }
}

/// A stage's heirloom. One that nobody holds is of no use, and is not written.
#[derive(Debug, Default)]
pub struct Heirloom {
    file: Option<File>,
    progress: Progress,
}

impl Heirloom {
    /// A new one, for the first process of a stage.
    ///
    /// # Errors
    /// No memory.
    pub fn make(stage: &str) -> Result<Self> {
        let file: OwnedFd = memfd_create(format!("lariat-{stage}"), MemfdFlags::CLOEXEC)
            .context("there is no memory for what a stage leaves to its successor")?;
        Ok(Self {
            file: Some(file.into()),
            progress: Progress::default(),
        })
    }

    /// The one that the chain holds for this process.
    ///
    /// # Errors
    /// It is none.
    pub fn of_the_chain() -> Result<Self> {
        let Ok(number) = std::env::var(HEIRLOOM_FD) else {
            return Ok(Self::default());
        };
        let file = File::options()
            .read(true)
            .write(true)
            .open(format!("/proc/self/fd/{number}"))
            .with_context(|| format!("{HEIRLOOM_FD} names no file: unset it"))?;
        let mut heirloom = Self {
            file: Some(file),
            progress: Progress::default(),
        };
        heirloom.progress = heirloom.read();
        Ok(heirloom)
    }

    /// The same, for a stage that is a thread of this process.
    pub fn share(&self) -> Self {
        Self {
            file: self.file.as_ref().and_then(|file| file.try_clone().ok()),
            progress: self.progress,
        }
    }

    /// The file, for the process that inherits it.
    pub(crate) fn file(&self) -> Option<&File> {
        self.file.as_ref()
    }

    /// How far the stage was when this process began, and is by what this process noted.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// How far the stage is by what any process noted.
    pub fn read(&self) -> Progress {
        let mut bytes = [0; HEAD];
        match &self.file {
            // One that has not noted anything yet is empty.
            Some(file) if file.read_exact_at(&mut bytes, 0).is_ok() => Progress::of_bytes(bytes),
            _ => Progress::default(),
        }
    }

    /// Before a message is sent: what will have been sent with it, and the count of the stage before in what it was made of.
    pub fn note(&mut self, sent: Sent, taken: u64) {
        (self.progress.sent, self.progress.taken) = (sent, taken);
        self.write_head();
    }

    /// There was nothing to send, and the stage lives.
    pub fn beat(&mut self) {
        self.progress.beats += 1;
        self.write_head();
    }

    /// The stage is started anew.
    pub fn begin_anew(&mut self) {
        self.progress = self.read();
        self.progress.restarts += 1;
        self.write_head();
    }

    fn write_head(&self) {
        if let Some(file) = &self.file {
            // In memory: it fails only where there is none, and then the successor begins by itself.
            let _ = file.write_all_at(&self.progress.to_bytes(), 0);
        }
    }

    /// Whether it is worth making something to hand on.
    pub fn is_held(&self) -> bool {
        self.file.is_some()
    }

    /// Hands something on, as of message number `count`.
    pub fn hand_on(&self, count: u64, bytes: &[u8]) {
        let (Some(file), true) = (&self.file, bytes.len() as u64 <= LARGEST - BODY_HEAD) else {
            return;
        };
        let at = BODY + LARGEST * (count % 2);
        let mut head = [0; BODY_HEAD as usize];
        head[..8].copy_from_slice(&count.to_le_bytes());
        head[8..].copy_from_slice(&(bytes.len() as u64).to_le_bytes());
        // The head last: what it tells of is whole.
        let _ = file.write_all_at(bytes, at + BODY_HEAD);
        let _ = file.write_all_at(&head, at);
    }

    /// What was handed on last.
    pub fn handed_on(&self) -> Option<Vec<u8>> {
        let file = self.file.as_ref()?;
        let newest = [0, 1].map(|turn| {
            let at = BODY + LARGEST * turn;
            let mut head = [0; BODY_HEAD as usize];
            file.read_exact_at(&mut head, at).ok()?;
            let [count, length] = head.as_chunks().0 else {
                return None;
            };
            Some((u64::from_le_bytes(*count), u64::from_le_bytes(*length), at))
        });
        let (count, length, at) = newest.into_iter().flatten().max()?;
        if count == 0 || length > LARGEST - BODY_HEAD {
            return None;
        }
        let mut bytes = vec![0; length as usize];
        file.read_exact_at(&mut bytes, at + BODY_HEAD).ok()?;
        Some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What another process sees.
    fn successor(of: &Heirloom) -> Heirloom {
        let mut next = Heirloom {
            progress: Progress::default(),
            ..of.share()
        };
        next.begin_anew();
        next
    }

    #[test]
    fn a_successor_goes_on_where_the_last_message_was_noted() {
        let mut first = Heirloom::make("test").unwrap();
        assert_eq!(first.read(), Progress::default());
        for count in 1..=3 {
            let sent = Sent {
                count,
                last_sequence: 10 * count,
            };
            first.note(sent, 2 * count);
            first.hand_on(count, format!("message {count}").as_bytes());
        }
        first.beat();
        // Killed while it wrote what would have been the next.
        let file = first.file().unwrap();
        file.write_all_at(b"half a mess", BODY + BODY_HEAD).unwrap();
        let next = successor(&first);
        let sent = Sent {
            count: 3,
            last_sequence: 30,
        };
        let left = Progress {
            restarts: 1,
            sent,
            taken: 6,
            beats: 1,
        };
        assert_eq!(next.progress(), left);
        assert_eq!(first.read(), left);
        assert_eq!(next.handed_on().as_deref(), Some(&b"message 3"[..]));
        assert_eq!(successor(&next).progress().restarts, 2);
    }

    #[test]
    fn of_nothing_handed_on_nothing_comes() {
        let mut held = Heirloom::make("test").unwrap();
        held.note(Sent::default(), 0);
        assert_eq!(held.handed_on(), None);
        let mut free = Heirloom::default();
        free.hand_on(1, b"to nobody");
        free.note(
            Sent {
                count: 1,
                last_sequence: 1,
            },
            1,
        );
        assert_eq!(free.handed_on(), None);
        assert!(!free.is_held());
    }
}
