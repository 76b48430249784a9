//! Saves the sink's state: the files of the run every 10 s, and the handover state every second.
//!
//! A thread alongside the sink has its own tally, which receives the same data: one receipt per
//! message, handed over once a second. So the sink neither waits for the thread nor copies its
//! histograms. Both sleep while no messages arrive.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::Context;
use lariat_sink::{Machine, Receipt, Sink, Tally};

use super::handover::HandoverWriter;
use crate::run_files::RunFiles;

/// Interval at which receipts are handed to the thread.
const ROUND: Duration = Duration::from_secs(1);
/// Interval at which files are written.
const FILES: Duration = Duration::from_secs(10);
/// Time after which the sink tries again if the thread is using its tally.
const AGAIN: Duration = Duration::from_millis(10);
/// Maximum number of receipts that wait for the thread. They cover 16 s at 1000 frames/s, in case a
/// disk delays it. If there are more, the thread gets a copy of the sink's tally.
const MOST_RECEIPTS: usize = 1 << 14;

/// The thread's tally, and the receipts that are not in it yet.
struct Kept {
    tally: Tally,
    receipts: Vec<Receipt>,
    has_news: bool,
    ended: bool,
}

struct Shared {
    kept: Mutex<Kept>,
    bell: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Kept> {
        // The tally is consistent after a panic, too, because it is only counted up and never
        // partly updated.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The sink's side.
pub(super) struct Keeper {
    shared: Arc<Shared>,
    thread: JoinHandle<RunFiles>,
    receipts: Vec<Receipt>,
    /// True if there were more receipts than fit.
    overflowed: bool,
    /// When to hand over the receipts, if there are any.
    due: Option<Instant>,
}

impl Keeper {
    /// Starts to save the state of a sink.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be started.
    pub(super) fn start(
        sink: &Sink,
        files: RunFiles,
        handover: Option<HandoverWriter>,
        machine: Machine,
    ) -> anyhow::Result<Self> {
        let shared = Arc::new(Shared {
            kept: Mutex::new(Kept {
                tally: sink.tally().clone(),
                receipts: Vec::with_capacity(MOST_RECEIPTS),
                has_news: false,
                ended: false,
            }),
            bell: Condvar::new(),
        });
        let work = Work {
            shared: shared.clone(),
            files_due: files.can_be_renewed().then(|| Instant::now() + FILES),
            files,
            handover,
            machine,
            failed: false,
        };
        let thread = std::thread::Builder::new()
            .name("keeper".to_owned())
            .spawn(move || work.run());
        Ok(Self {
            shared,
            thread: thread.context("sink has no thread to write its report by")?,
            receipts: Vec::with_capacity(MOST_RECEIPTS),
            overflowed: false,
            due: None,
        })
    }

    /// Takes the receipt of a message.
    pub(super) fn take(&mut self, receipt: Receipt) {
        if self.receipts.len() < MOST_RECEIPTS {
            self.receipts.push(receipt);
        } else {
            self.overflowed = true;
        }
    }

    /// Returns when the next call is due, if there are receipts.
    pub(super) fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Hands over the receipts if it is time. Never waits for the thread.
    pub(super) fn hand_over_if_due(&mut self, sink: &Sink) {
        if self.receipts.is_empty() {
            return;
        }
        let now = Instant::now();
        if now < *self.due.get_or_insert(now + ROUND) {
            return;
        }
        let Ok(mut kept) = self.shared.kept.try_lock() else {
            self.due = Some(now + AGAIN);
            return;
        };
        if self.overflowed || kept.receipts.len() + self.receipts.len() > MOST_RECEIPTS {
            kept.tally = sink.tally().clone();
            kept.receipts.clear();
            self.overflowed = false;
        } else {
            kept.receipts.extend_from_slice(&self.receipts);
            kept.tally.take_comparisons(sink.tally());
        }
        kept.has_news = true;
        drop(kept);
        self.shared.bell.notify_one();
        self.receipts.clear();
        self.due = None;
    }

    /// Ends the thread, and returns the files for the final report.
    ///
    /// # Errors
    /// Returns an error if the thread panicked.
    pub(super) fn end(self) -> anyhow::Result<RunFiles> {
        self.shared.lock().ended = true;
        self.shared.bell.notify_one();
        let files = self.thread.join();
        files.map_err(|_| anyhow::anyhow!("the thread that writes the report has a fault, as said above: the report is not written"))
    }
}

/// The thread's side.
struct Work {
    shared: Arc<Shared>,
    files: RunFiles,
    /// When to write the files, if they may be written before the end.
    files_due: Option<Instant>,
    handover: Option<HandoverWriter>,
    machine: Machine,
    /// True if a failure was reported.
    failed: bool,
}

impl Work {
    fn run(mut self) -> RunFiles {
        let shared = self.shared.clone();
        // True if the files lack something that has arrived.
        let mut files_lack = false;
        loop {
            let mut kept = shared.lock();
            let is_due = loop {
                let left = self
                    .files_due
                    .filter(|_| files_lack)
                    .map(|due| due.saturating_duration_since(Instant::now()));
                let is_due = left == Some(Duration::ZERO);
                if kept.ended {
                    return self.files;
                }
                if kept.has_news || is_due {
                    break is_due;
                }
                kept = match left {
                    None => shared
                        .bell
                        .wait(kept)
                        .unwrap_or_else(PoisonError::into_inner),
                    Some(left) => {
                        let woken = shared.bell.wait_timeout(kept, left);
                        woken.unwrap_or_else(PoisonError::into_inner).0
                    }
                };
            };
            files_lack |= std::mem::take(&mut kept.has_news);
            let Kept {
                tally, receipts, ..
            } = &mut *kept;
            for receipt in receipts.drain(..) {
                tally.count(&receipt);
            }
            self.leave(tally);
            if is_due {
                let report = tally.report_on(self.machine.clone());
                drop(kept);
                self.renew(&report);
                self.files_due = Some(Instant::now() + FILES);
                files_lack = false;
            }
        }
    }

    /// Writes the handover state. It goes to memory, so this is fast.
    fn leave(&mut self, tally: &Tally) {
        if let Some(left) = &mut self.handover
            && let Err(cause) = left.write(|into| tally.save(into))
        {
            self.handover = None;
            tracing::warn!(
                "what sink has timed would not survive it, as it cannot be kept: {cause}"
            );
        }
    }

    /// Writes the files. A failure does not stop a robot's chain, and the next attempt may succeed.
    fn renew(&mut self, report: &lariat_sink::Report) {
        match self.files.renew(report) {
            Ok(()) => self.failed = false,
            Err(cause) if !std::mem::replace(&mut self.failed, true) => {
                tracing::warn!("the report is not up to date: {cause:#}");
            }
            Err(_) => {}
        }
    }
}
