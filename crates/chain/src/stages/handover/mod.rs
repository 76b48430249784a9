//! Handover state of a stage: memory that the chain holds for the stage's successor, whatever
//! happens to the process.
//!
//! ```text
//! part        content                                      written
//! progress    progress of the stage                        before each message it sends
//! left        extract's centerlines, or the sink's counts  after the message
//! tally       times measured by the sink                   once a second
//! ```
//!
//! Each part is stored twice and written alternately (`double_buffer`), so a kill during a write
//! leaves the previous copy complete.
//!
//! No message is counted twice, and none is forgotten. A message that was counted but not sent is
//! lost, and the loss accounting includes it. Writing to mapped memory costs a stage a few stores;
//! system calls would delay every frame.

mod double_buffer;

use std::fs::File;
use std::sync::atomic::AtomicU64;

use anyhow::{Context, Result};
use rustix::fs::{MemfdFlags, ftruncate, memfd_create};

use super::status::Sent;
pub use double_buffer::DoubleBuffer;
use double_buffer::{Region, map};

/// Environment variable with the number of the memory's descriptor.
pub const HANDOVER_FD: &str = "LARIAT_HANDOVER_FD";

/// Progress of a stage, over all its processes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Progress {
    /// Number of restarts.
    pub restarts: u64,
    /// Messages that it sent.
    pub sent: Sent,
    /// The previous stage's counter in the last message that was processed.
    pub taken: u64,
    /// Number of times that the stage reported that it is alive without sending a message.
    pub beats: u64,
}

const PROGRESS: Region = Region::at_the_start(40);
/// Extract's largest state takes about 60 kB.
const STATE: Region = Region::after(PROGRESS, 1 << 20);
/// If every bucket of every histogram were used, the tally would take about 2 MB.
const TALLY: Region = Region::after(STATE, 16 << 20);
/// Size of the file, which is sparse.
const BYTES: usize = TALLY.end();

impl Progress {
    fn to_words(self) -> [u64; 5] {
        let Sent {
            count,
            last_sequence,
        } = self.sent;
        [self.restarts, count, last_sequence, self.taken, self.beats]
    }

    fn of_words([restarts, count, last_sequence, taken, beats]: [u64; 5]) -> Self {
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

/// Handover state of a stage. Without memory from the chain, nothing is written.
#[derive(Debug, Default)]
pub struct Handover {
    memory: Option<Memory>,
    progress: Progress,
}

#[derive(Debug)]
struct Memory {
    file: File,
    words: &'static [AtomicU64],
}

impl Memory {
    fn of(file: File) -> Result<Self> {
        let words = map(&file, BYTES).context("there is no memory for a stage's handover state")?;
        Ok(Self { file, words })
    }
}

impl Handover {
    /// Creates the state for the first process of a stage.
    ///
    /// # Errors
    /// Returns an error if memory is insufficient.
    pub fn make(stage: &str) -> Result<Self> {
        let made = memfd_create(format!("lariat-{stage}"), MemfdFlags::CLOEXEC);
        let file = made.and_then(|file| ftruncate(&file, BYTES as u64).map(|()| File::from(file)));
        let file = file.context("there is no memory for a stage's handover state")?;
        Ok(Self {
            memory: Some(Memory::of(file)?),
            progress: Progress::default(),
        })
    }

    /// Opens the state that the chain holds for this process.
    ///
    /// # Errors
    /// Returns an error if the descriptor is not a handover state.
    pub fn of_the_chain() -> Result<Self> {
        let Ok(number) = std::env::var(HANDOVER_FD) else {
            return Ok(Self::default());
        };
        let file = File::options()
            .read(true)
            .write(true)
            .open(format!("/proc/self/fd/{number}"));
        let is_one = |file: &File| file.metadata().is_ok_and(|it| it.len() == BYTES as u64);
        let file = file.ok().filter(is_one);
        let file = file.with_context(|| format!("{HANDOVER_FD} names no handover: unset it"))?;
        let mut handover = Self {
            memory: Some(Memory::of(file)?),
            progress: Progress::default(),
        };
        handover.progress = handover.read();
        Ok(handover)
    }

    /// Returns a second handle, for a stage that is a thread of this process.
    pub fn share(&self) -> Self {
        let share = |memory: &Memory| {
            Some(Memory {
                file: memory.file.try_clone().ok()?,
                words: memory.words,
            })
        };
        Self {
            memory: self.memory.as_ref().and_then(share),
            progress: self.progress,
        }
    }

    /// Returns the file for the process that inherits it.
    pub fn file(&self) -> Option<&File> {
        self.memory.as_ref().map(|memory| &memory.file)
    }

    /// Returns the progress of the stage as this process knows it: the progress at the start,
    /// updated with everything that this process noted.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Returns the progress that was noted last, by any process.
    pub fn read(&self) -> Progress {
        let noted = self.buffers(PROGRESS);
        let noted = noted.and_then(|buffers| buffers.newest_words());
        noted.map_or_else(Progress::default, Progress::of_words)
    }

    /// Notes progress before a message is sent. `sent` includes that message, and `taken` is the
    /// previous stage's counter in its input.
    pub fn note(&mut self, sent: Sent, taken: u64) {
        (self.progress.sent, self.progress.taken) = (sent, taken);
        self.write();
    }

    /// Notes that the stage is alive without having anything to send.
    pub fn beat(&mut self) {
        self.progress.beats += 1;
        self.write();
    }

    /// Notes a restart of the stage.
    pub fn count_restart(&mut self) {
        self.progress = self.read();
        self.progress.restarts += 1;
        self.write();
    }

    fn write(&self) {
        if let Some(buffers) = self.buffers(PROGRESS) {
            buffers.write_words(&self.progress.to_words());
        }
    }

    /// Returns true if the chain holds the state, so that it is worth writing.
    pub fn is_held(&self) -> bool {
        self.memory.is_some()
    }

    fn buffers(&self, region: Region) -> Option<DoubleBuffer> {
        let memory = self.memory.as_ref()?;
        Some(DoubleBuffer::new(memory.words, region))
    }

    /// Returns the memory for the state that a successor needs, if the chain holds it.
    pub fn state(&self) -> Option<DoubleBuffer> {
        self.buffers(STATE)
    }

    /// Returns the memory for the sink's times.
    pub fn tally(&self) -> Option<DoubleBuffer> {
        self.buffers(TALLY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the state as another process sees it.
    fn successor(of: &Handover) -> Handover {
        let file = of.file().unwrap().try_clone().unwrap();
        let mut next = Handover {
            memory: Some(Memory::of(file).unwrap()),
            progress: Progress::default(),
        };
        next.count_restart();
        next
    }

    #[test]
    fn a_successor_goes_on_where_the_last_message_was_noted() {
        let mut first = Handover::make("test").unwrap();
        assert_eq!(first.read(), Progress::default());
        for count in 1..=3 {
            let sent = Sent {
                count,
                last_sequence: 10 * count,
            };
            first.note(sent, 2 * count);
            let left = first.state().unwrap();
            left.write(format!("message {count}").as_bytes()).unwrap();
        }
        first.beat();
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
        let handed_on = next.state().unwrap().newest_first().next();
        assert_eq!(handed_on.as_deref(), Some(&b"message 3"[..]));
        assert_eq!(successor(&next).progress().restarts, 2);
    }

    #[test]
    fn of_nothing_handed_on_nothing_comes() {
        let mut held = Handover::make("test").unwrap();
        held.note(Sent::default(), 0);
        assert_eq!(held.state().unwrap().newest_first().next(), None);
    }

    #[test]
    fn what_nobody_holds_is_not_written() {
        let mut nobody = Handover::default();
        nobody.note(Sent::default(), 7);
        assert!(nobody.state().is_none());
        assert_eq!(nobody.read(), Progress::default());
        assert_eq!(nobody.progress().taken, 7);
    }
}
