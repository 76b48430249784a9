//! The line from a stage to the chain that started it: when it is ready, and what it sent in all.
//!
//! A pipe, whose number stands in `LARIAT_STATUS_FD`. It says `lacks WORD…` if the stage may not have all that was wanted
//! of the machine, `ready` once, `done` if the source has ended,
//! `ending` if a signal came, `unread` if nobody reads any more what it prints, and `sent COUNT LAST_SEQUENCE` last (extract before it `late COUNT`, if it
//! waited for masks, and `taken`, with what capture would say, if frames come from elsewhere); its own end says that the process is gone, however it went.

use std::fs::File;
use std::io::Write;
use std::os::fd::OwnedFd;

use super::arrangement::Lacks;
use anyhow::Context;
use rustix::process::{Signal, getppid, set_parent_process_death_signal};

/// The variable that holds the pipe's number.
pub(crate) const STATUS_FD: &str = "LARIAT_STATUS_FD";
/// The variable that holds the process id of the chain.
pub(crate) const CHAIN_PID: &str = "LARIAT_CHAIN_PID";

/// How many frames a stage sent, and the number the source gave to the last of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Sent {
    pub(crate) count: u64,
    pub(crate) last_sequence: u64,
}

/// What extract knows of frames that come from elsewhere.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Taken {
    /// The source's number and the writer's count before the first frame.
    pub(crate) before_first: [u64; 2],
    /// What its writer had sent in all when the last one came.
    pub(crate) last: Sent,
}

/// The stage's end of the line. Says nothing if the stage was started by hand.
pub(crate) struct Status(Option<File>);

impl Status {
    /// The line of a stage that is a thread of the chain's own process.
    pub(crate) fn on(line: OwnedFd) -> Self {
        Self(Some(line.into()))
    }

    /// Takes up the line, and asks the kernel to end this process with the chain's.
    pub(crate) fn of_the_chain() -> anyhow::Result<Self> {
        let Ok(number) = std::env::var(STATUS_FD) else {
            return Ok(Self(None));
        };
        set_parent_process_death_signal(Some(Signal::TERM))
            .context("the kernel was asked to end this stage with its chain, and refused")?;
        let chain = std::env::var(CHAIN_PID).unwrap_or_default();
        // The chain may have died before the kernel was asked.
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

    /// Whether a chain started this stage.
    pub(crate) fn is_supervised(&self) -> bool {
        self.0.is_some()
    }

    /// The stage can receive: what is sent to it from now on arrives.
    pub(crate) fn ready(&mut self) {
        self.say("ready\n");
    }

    /// The stage does without this. Started by hand, it tells the user; else the chain does, for all of them.
    pub(crate) fn lacks(&mut self, lacks: Lacks) {
        if self.is_supervised() {
            self.say(&format!("lacks {}\n", lacks.words()));
        } else {
            tracing::warn!("{lacks}");
        }
    }

    /// The source has ended, or as much of it was sent as was asked.
    pub(crate) fn done(&mut self) {
        self.say("done\n");
    }

    /// A signal has ended the stage's work, and its last word is to come.
    pub(crate) fn ending(&mut self) {
        self.say("ending\n");
    }

    /// Nobody reads any more what the stage prints.
    pub(crate) fn unread(&mut self) {
        self.say("unread\n");
    }

    /// So many frames were skipped, as their masks came too late.
    pub(crate) fn late(&mut self, count: u64) {
        self.say(&format!("late {count}\n"));
    }

    /// Frames came from elsewhere: where its writer's numbers stood before the first and at the last.
    pub(crate) fn taken(&mut self, taken: Taken) {
        let ([sequence, captured], last) = (taken.before_first, taken.last);
        self.say(&format!(
            "taken {sequence} {captured} {} {}\n",
            last.count, last.last_sequence
        ));
    }

    /// The stage's last word.
    pub(crate) fn sent(&mut self, sent: Sent) {
        self.say(&format!("sent {} {}\n", sent.count, sent.last_sequence));
    }

    fn say(&mut self, line: &str) {
        if let Some(pipe) = &mut self.0 {
            // A chain that is gone cannot be told; its death signal is on the way.
            let _ = pipe.write_all(line.as_bytes());
        }
    }
}
