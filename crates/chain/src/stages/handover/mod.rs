//! What a stage leaves to its successor: memory that the chain holds for it, whatever becomes of the process.
//!
//! ```text
//! progress    how far the stage is                         before each message it sends
//! left        what its successor goes on with              after the message (extract: its centerlines; sink: its counts)
//! tally       what sink has timed                          once a second
//!
//! each twice, in turn (`buffers`): a kill in the middle of a write leaves the one before whole
//! ```
//!
//! No count is given twice and none is forgotten: a message that was counted and not sent is lost, which is what the ledger then says.
//! Memory that is mapped costs a stage some stores for it; a system call each, as it was first, cost a frame 19 µs on its whole way.

mod double_buffer;

use std::fs::File;
use std::sync::atomic::AtomicU64;

use anyhow::{Context, Result};
use rustix::fs::{MemfdFlags, ftruncate, memfd_create};

use super::status::Sent;
pub use double_buffer::DoubleBuffer;
use double_buffer::{Region, map};

/// The variable that holds the memory's file number.
pub const HANDOVER_FD: &str = "LARIAT_HANDOVER_FD";

/// How far a stage is, over all its processes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Progress {
    /// Number of restarts.
    pub restarts: u64,
    /// What it sent.
    pub sent: Sent,
    /// The count of the stage before in the message that was worked off last.
    pub taken: u64,
    /// How often it said that it lives without having sent anything.
    pub beats: u64,
}

const PROGRESS: Region = Region::at_the_start(40);
/// The largest that extract leaves has some 60 kB.
const STATE: Region = Region::after(PROGRESS, 1 << 20);
/// Every bucket of every histogram in use would take some 2 MB.
const TALLY: Region = Region::after(STATE, 16 << 20);
/// Of the file, of which nearly all is a hole.
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

/// A stage's handover. One that nobody holds is of no use, and is not written.
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
    /// A new one, for the first process of a stage.
    ///
    /// # Errors
    /// No memory.
    pub fn make(stage: &str) -> Result<Self> {
        let made = memfd_create(format!("lariat-{stage}"), MemfdFlags::CLOEXEC);
        let file = made.and_then(|file| ftruncate(&file, BYTES as u64).map(|()| File::from(file)));
        let file = file.context("there is no memory for a stage's handover state")?;
        Ok(Self {
            memory: Some(Memory::of(file)?),
            progress: Progress::default(),
        })
    }

    /// The one that the chain holds for this process.
    ///
    /// # Errors
    /// It is none.
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

    /// The same, for a stage that is a thread of this process.
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

    /// The file, for the process that inherits it.
    pub fn file(&self) -> Option<&File> {
        self.memory.as_ref().map(|memory| &memory.file)
    }

    /// How far the stage was when this process began, and is by what this process noted.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// How far the stage is by what any process noted.
    pub fn read(&self) -> Progress {
        let noted = self.buffers(PROGRESS);
        let noted = noted.and_then(|buffers| buffers.newest_words());
        noted.map_or_else(Progress::default, Progress::of_words)
    }

    /// Before a message is sent: what will have been sent with it, and the count of the stage before in what it was made of.
    pub fn note(&mut self, sent: Sent, taken: u64) {
        (self.progress.sent, self.progress.taken) = (sent, taken);
        self.write();
    }

    /// There was nothing to send, and the stage lives.
    pub fn beat(&mut self) {
        self.progress.beats += 1;
        self.write();
    }

    /// The stage is restarted.
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

    /// Whether it is worth making something to hand on.
    pub fn is_held(&self) -> bool {
        self.memory.is_some()
    }

    fn buffers(&self, region: Region) -> Option<DoubleBuffer> {
        let memory = self.memory.as_ref()?;
        Some(DoubleBuffer::new(memory.words, region))
    }

    /// Where stands what a successor goes on with, if anybody holds it.
    pub fn state(&self) -> Option<DoubleBuffer> {
        self.buffers(STATE)
    }

    /// Where stands what sink has timed.
    pub fn tally(&self) -> Option<DoubleBuffer> {
        self.buffers(TALLY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What another process sees.
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
