//! Messages between a stage and the chain that started it, one per line, with one type for each
//! direction.
//!
//! A stage writes [`Word`]s to a pipe, whose descriptor number is in `LARIAT_STATUS_FD`. The end of
//! the pipe means that the process is gone, for whatever reason. The chain writes its [`LastWord`]
//! to the standard input of the sink and the recorder. A stage without the variable was started by
//! hand and otherwise behaves the same.
//!
//! * Each stage writes `ready` once. Before that it writes `lacks` with those of `priority`,
//!   `memory` and `core` that it does not get (see `arrangement`).
//! * Capture writes `done` when its source has ended.
//! * The sink writes `ending` when a signal has ended its work, so that the chain tells it the
//!   counts even if another process sent the signal. It writes `unread` when nobody reads standard
//!   output any more, which ends the chain like Ctrl-C.
//! * The other three stages write `sent COUNT LAST_SEQUENCE` at the end. Before that, extract
//!   writes `late COUNT` if it waits for masks, and fit `depthless COUNT` if it waits for depth
//!   images. Capture writes `depths IMAGES LOST UNPAIRED` if it has a depth camera.

use std::fmt;
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::str::FromStr;

use super::arrangement::Lacks;
use anyhow::Context;
use lariat_sink::{DepthCounts, FinalCounts};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};

/// Environment variable with the number of the pipe's descriptor.
pub const STATUS_FD: &str = "LARIAT_STATUS_FD";
/// Environment variable with the process id of the chain.
pub const CHAIN_PID: &str = "LARIAT_CHAIN_PID";

/// Number of frames that a stage sent, and the source's number of the last one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sent {
    /// Number of frames.
    pub count: u64,
    /// The source's number of the last frame.
    pub last_sequence: u64,
}

/// Extract's record of frames from an external source.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Taken {
    /// The source's number and the writer's count before the first frame.
    pub before_first: [u64; 2],
    /// The writer's totals in the last frame.
    pub last: Sent,
}

/// A message from a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
    /// The stage runs without these requested resources.
    Lacks(Lacks),
    /// The stage can receive: whatever is sent to it from now on arrives.
    Ready,
    /// The source has ended, or the requested number of frames was sent.
    Done,
    /// A signal has ended the stage's work, and it waits for the last word.
    Ending,
    /// Nobody reads the stage's output any more.
    Unread,
    /// Number of frames that were skipped because their masks were late.
    Late(u64),
    /// Number of frames without a depth image.
    Depthless(u64),
    /// Counts of the depth camera's images.
    Depths(DepthCounts),
    /// The external writer's counters before the first frame and in the last one.
    Taken(Taken),
    /// The last message: totals of sent messages.
    Sent(Sent),
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Self::Lacks(lacks) => write!(f, "lacks {}", lacks.words()),
            Self::Ready => write!(f, "ready"),
            Self::Done => write!(f, "done"),
            Self::Ending => write!(f, "ending"),
            Self::Unread => write!(f, "unread"),
            Self::Late(count) => write!(f, "late {count}"),
            Self::Depthless(count) => write!(f, "depthless {count}"),
            Self::Depths(counts) => write!(f, "depths {}", words(&counts)),
            Self::Taken(Taken { before_first, last }) => {
                let [sequence, captured] = before_first;
                let (count, last_sequence) = (last.count, last.last_sequence);
                write!(f, "taken {sequence} {captured} {count} {last_sequence}")
            }
            Self::Sent(sent) => write!(f, "sent {} {}", sent.count, sent.last_sequence),
        }
    }
}

fn words(counts: &DepthCounts) -> String {
    let DepthCounts {
        images,
        lost,
        unpaired,
    } = counts;
    format!("{images} {lost} {unpaired}")
}

fn depths([images, lost, unpaired]: [u64; 3]) -> DepthCounts {
    DepthCounts {
        images,
        lost,
        unpaired,
    }
}

/// Error for a message that is unknown, possibly from another release.
fn unknown(line: &str) -> anyhow::Error {
    anyhow::anyhow!(
        "`{line}` is not a message between a stage and its chain: use the same release for all stages"
    )
}

/// Splits a line into its name and the whole numbers that follow.
fn parts(line: &str) -> anyhow::Result<(&str, Vec<u64>)> {
    let (name, rest) = line.split_once(' ').unwrap_or((line, ""));
    let numbers = rest.split_ascii_whitespace().map(str::parse);
    let numbers = numbers.collect::<Result<_, _>>();
    Ok((name, numbers.map_err(|_| unknown(line))?))
}

impl FromStr for Word {
    type Err = anyhow::Error;

    fn from_str(line: &str) -> anyhow::Result<Self> {
        if let Some(words) = line.strip_prefix("lacks ") {
            let lacks = Lacks::of_words(words).map(Self::Lacks);
            return lacks.ok_or_else(|| unknown(line));
        }
        let (name, numbers) = parts(line)?;
        let sent = |count, last_sequence| Sent {
            count,
            last_sequence,
        };
        Ok(match (name, &numbers[..]) {
            ("ready", []) => Self::Ready,
            ("done", []) => Self::Done,
            ("ending", []) => Self::Ending,
            ("unread", []) => Self::Unread,
            ("late", &[count]) => Self::Late(count),
            ("depthless", &[count]) => Self::Depthless(count),
            ("depths", &[images, lost, unpaired]) => Self::Depths(depths([images, lost, unpaired])),
            ("taken", &[sequence, captured, count, last]) => Self::Taken(Taken {
                before_first: [sequence, captured],
                last: sent(count, last),
            }),
            ("sent", &[count, last]) => Self::Sent(sent(count, last)),
            _ => return Err(unknown(line)),
        })
    }
}

/// The chain's message at its end: the totals of each stage, with one line for each known number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LastWord {
    /// The chain was never complete.
    Never,
    /// The totals.
    Counts(FinalCounts),
}

impl LastWord {
    /// Reads the message of the chain that started this process from standard input. If the chain
    /// was killed, the totals are unknown.
    pub fn of_the_chain() -> Self {
        let mut text = String::new();
        let _ = std::io::stdin().lock().read_to_string(&mut text);
        text.parse()
            .unwrap_or_else(|_| Self::Counts(FinalCounts::default()))
    }
}

impl fmt::Display for LastWord {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self::Counts(counts) = self else {
            return writeln!(f, "never");
        };
        if let Some([sequence, captured]) = counts.before_first {
            writeln!(f, "before {sequence} {captured}")?;
        }
        for (name, number) in [
            ("sequence", counts.last_sequence),
            ("captured", counts.captured),
            ("extracted", counts.extracted),
            ("fitted", counts.fitted),
            ("late", counts.masks_late),
            ("depthless", counts.depthless),
        ] {
            if let Some(number) = number {
                writeln!(f, "{name} {number}")?;
            }
        }
        if let Some(depths) = &counts.depths {
            writeln!(f, "depths {}", words(depths))?;
        }
        Ok(())
    }
}

impl FromStr for LastWord {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let mut counts = FinalCounts::default();
        for line in text.lines() {
            let (name, numbers) = parts(line)?;
            match (name, &numbers[..]) {
                ("never", []) => return Ok(Self::Never),
                ("before", &[sequence, count]) => counts.before_first = Some([sequence, count]),
                ("sequence", &[number]) => counts.last_sequence = Some(number),
                ("captured", &[count]) => counts.captured = Some(count),
                ("extracted", &[count]) => counts.extracted = Some(count),
                ("fitted", &[count]) => counts.fitted = Some(count),
                ("late", &[count]) => counts.masks_late = Some(count),
                ("depthless", &[count]) => counts.depthless = Some(count),
                ("depths", &[images, lost, unpaired]) => {
                    counts.depths = Some(depths([images, lost, unpaired]));
                }
                _ => return Err(unknown(line)),
            }
        }
        Ok(Self::Counts(counts))
    }
}

/// The stage's end of the status line. Writes nothing if the stage was started by hand.
pub struct Status(Option<File>);

impl Status {
    /// Creates the status of a stage that is a thread of the chain's own process.
    pub fn on(line: OwnedFd) -> Self {
        Self(Some(line.into()))
    }

    /// Opens the status line, and asks the kernel to end this process together with the chain.
    pub fn of_the_chain() -> anyhow::Result<Self> {
        let Ok(number) = std::env::var(STATUS_FD) else {
            return Ok(Self(None));
        };
        set_parent_process_death_signal(Some(Signal::TERM))
            .context("the kernel was asked to end this stage with its chain, and refused")?;
        let chain = std::env::var(CHAIN_PID).unwrap_or_default();
        // The chain may have died before this request.
        let parent = getppid().map(|pid| pid.as_raw_nonzero().to_string());
        anyhow::ensure!(
            parent.as_deref() == Some(chain.as_str()),
            "the chain that started this stage is gone"
        );
        let pipe = File::options()
            .write(true)
            .open(format!("/proc/self/fd/{number}"))
            .with_context(|| format!("{STATUS_FD} names no pipe: unset it"))?;
        Ok(Self(Some(pipe)))
    }

    /// Returns true if a chain started this stage.
    pub fn is_supervised(&self) -> bool {
        self.0.is_some()
    }

    /// Sends a message. A stage that was started by hand tells the user itself which resources it
    /// lacks. Otherwise the chain does this for all stages.
    pub fn say(&mut self, word: Word) {
        match (&mut self.0, word) {
            // If the chain is gone, its death signal is on the way.
            (Some(pipe), _) => drop(pipe.write_all(format!("{word}\n").as_bytes())),
            (None, Word::Lacks(lacks)) => tracing::warn!("{lacks}"),
            (None, _) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_comes_back() {
        let lacks = Lacks {
            priority: true,
            core: true,
            ..Lacks::default()
        };
        let last = Sent {
            count: 3,
            last_sequence: u64::MAX,
        };
        let taken = Taken {
            before_first: [1, 2],
            last,
        };
        for (word, line) in [
            (Word::Lacks(lacks), "lacks priority core"),
            (Word::Ready, "ready"),
            (Word::Done, "done"),
            (Word::Ending, "ending"),
            (Word::Unread, "unread"),
            (Word::Late(7), "late 7"),
            (Word::Depthless(8), "depthless 8"),
            (Word::Depths(depths([9, 1, 2])), "depths 9 1 2"),
            (Word::Taken(taken), "taken 1 2 3 18446744073709551615"),
            (Word::Sent(last), "sent 3 18446744073709551615"),
        ] {
            assert_eq!(word.to_string(), line);
            assert_eq!(line.parse::<Word>().unwrap(), word);
        }
    }

    #[test]
    fn the_last_word_comes_back() {
        let counts = FinalCounts {
            before_first: Some([4, 5]),
            last_sequence: Some(9),
            captured: Some(8),
            fitted: Some(0),
            depthless: Some(7),
            depths: Some(depths([6, 5, 4])),
            ..FinalCounts::default()
        };
        for word in [
            LastWord::Never,
            LastWord::Counts(counts),
            LastWord::Counts(FinalCounts::default()),
        ] {
            assert_eq!(word.to_string().parse::<LastWord>().unwrap(), word);
        }
    }

    #[test]
    fn half_a_word_is_none() {
        for line in [
            "",
            "sent",
            "sent 3",
            "sent 3 x",
            "sent 1 2 3",
            "late",
            "lacks all",
            "Ready",
            "taken 1 2",
        ] {
            assert!(line.parse::<Word>().is_err(), "{line}");
        }
        assert!("captured many".parse::<LastWord>().is_err());
    }
}
