//! Stops a chain in order.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use lariat_sink::FinalCounts;
use lariat_wire::Domain;
use rustix::param::clock_ticks_per_second;

use super::child::{Child, Ending};
use super::{Chain, Part};
use crate::stages::status::{LastWord, Sent};

/// Time without work after which a stopping stage is killed. A stage first processes the messages
/// that wait for it.
const STOP_PATIENCE: Duration = Duration::from_secs(3);
/// Counterpart of [`STOP_PATIENCE`] for a lossless stage, which itself waits for a reader that
/// makes no progress.
const LOSSLESS_PATIENCE: Duration = Duration::from_secs(6);
/// CPU time that a stage may use to end.
const STOP_TIMEOUT: Duration = Duration::from_secs(20);
/// Factor by which the elapsed time may exceed [`STOP_TIMEOUT`], for a stage that shares its core.
const STARVED: u32 = 10;
/// Time limit for the recorder, which must write all waiting messages, possibly to a slow disk.
const RECORDER_STOP_TIMEOUT: Duration = Duration::from_secs(60);
/// Time limit for a killed process to disappear. The kernel may delay its end for a disk or a
/// camera.
const KILL_TIMEOUT: Duration = Duration::from_secs(2);

impl Chain {
    /// Stops the stages from first to last, each after all stages before it have ended. So
    /// everything that was sent is processed. `never` is true if the chain was never complete, so
    /// that it cannot report.
    pub(super) fn stop_in_order(&mut self, never: bool) {
        self.status_notifier.stopping();
        self.control = None;
        if !never {
            self.start_those_that_report();
        }
        self.is_stopping = true;
        for part in Part::ALL {
            let word = match part.is_told_the_last_word() {
                true if never => LastWord::Never.to_string(),
                true => LastWord::Counts(self.counts()).to_string(),
                false => String::new(),
            };
            if let Some(child) = &mut self.children[part as usize] {
                child.tell(&word);
                child.tell_to_stop();
            }
            self.await_end(part);
        }
    }

    /// Restarts fallen parts that must report at the end. Other fallen parts stay ended.
    fn start_those_that_report(&mut self) {
        for part in Part::ALL {
            if self.due[part as usize].is_none() || !part.is_told_the_last_word() {
                continue;
            }
            let end = Instant::now() + self.settings.run.start_limit;
            let is_on_its_way = |chain: &Self| {
                let child = chain.child(part);
                child.is_some_and(|child| !child.is_ready() && child.ending().is_none())
            };
            let mut started = self.restart(part);
            while started.is_ok() && is_on_its_way(self) && Instant::now() < end {
                started = self.listen(Some(end), None);
            }
            if let Err(cause) = started {
                tracing::warn!("{} is not restarted: {cause:#}", part.name());
            }
        }
    }

    /// Waits for the end of a stopping part. Kills it if it does no work or takes too long.
    pub(super) fn await_end(&mut self, part: Part) {
        let (patience, most) = match part {
            Part::Recorder => (RECORDER_STOP_TIMEOUT, RECORDER_STOP_TIMEOUT),
            _ if self.settings.run.lossless => (LOSSLESS_PATIENCE, STOP_TIMEOUT),
            Part::Capture | Part::Extract | Part::Fit | Part::Sink => (STOP_PATIENCE, STOP_TIMEOUT),
        };
        let begin = Instant::now();
        if self.ends_within(part, patience, most) {
            return;
        }
        eprintln!(
            "lariat: {} did not end within {} s of being told to, and was killed",
            part.name(),
            begin.elapsed().as_secs()
        );
        self.fallen.get_or_insert(part);
        if let Some(child) = &mut self.children[part as usize] {
            child.kill();
        }
        if !self.ends_within(part, KILL_TIMEOUT, KILL_TIMEOUT) {
            eprintln!("lariat: {} could not be killed", part.name());
        }
    }

    /// Returns true once a part has ended or is missing. Returns false after `most` of CPU time, or
    /// after `patience` without work.
    pub(super) fn ends_within(&mut self, part: Part, patience: Duration, most: Duration) -> bool {
        let begin = Instant::now();
        let (mut ticks, mut busy) = (None, begin);
        let ticks_before = self.child(part).and_then(Child::ticks);
        loop {
            let Some(child) = self.child(part).filter(|child| child.ending().is_none()) else {
                return true;
            };
            let now = Instant::now();
            let used = child.ticks();
            if used != ticks {
                (ticks, busy) = (used, now);
            }
            let has_had = used.zip(ticks_before).map(|(used, before)| {
                Duration::from_secs(used.saturating_sub(before)) / clock_ticks_per_second() as u32
            });
            // The CPU time of a thread is unknown, so the elapsed time counts.
            let by_clock = match has_had {
                Some(has_had) if has_had < most => most * STARVED,
                _ => most,
            };
            let end = (begin + by_clock).min(busy + patience);
            if now >= end {
                return false;
            }
            let look = now + patience / 8;
            if self.listen(Some(look.min(end)), None).is_err() {
                return false;
            }
        }
    }

    /// Returns the totals that each stage reported. For frames from an external source, extract
    /// reports what capture otherwise would.
    pub(super) fn counts(&self) -> FinalCounts {
        let sent = |part| -> Option<Sent> {
            let child = self.child(part)?;
            // A stage notes what it is about to send, so the count of a killed stage is known, too.
            let noted = || self.handovers[part as usize].read().sent;
            Some(child.sent().unwrap_or_else(noted))
        };
        let extract = self.child(Part::Extract);
        let taken = extract.and_then(Child::taken);
        let of_source = taken.map(|taken| taken.last).or(sent(Part::Capture));
        FinalCounts {
            before_first: taken.map(|taken| taken.before_first),
            last_sequence: of_source.map(|sent| sent.last_sequence),
            captured: of_source.map(|sent| sent.count),
            extracted: sent(Part::Extract).map(|sent| sent.count),
            fitted: sent(Part::Fit).map(|sent| sent.count),
            masks_late: extract.and_then(Child::masks_late),
            depthless: self.child(Part::Fit).and_then(Child::depthless),
            depths: self.child(Part::Capture).and_then(Child::depths),
        }
    }

    /// Returns the chain's exit code. Cleans up shared memory after a stage that was killed.
    pub(super) fn verdict(&self) -> ExitCode {
        let is_good = self.fallen.is_none() && !self.recording_lost;
        let is_killed = |child: &Child| matches!(child.ending(), Some(Ending::Killed(_)));
        if is_good && !self.stages().any(is_killed) {
            return ExitCode::SUCCESS;
        }
        if let Ok(domain) = Domain::open() {
            domain.sweep();
        }
        if is_good {
            return ExitCode::SUCCESS;
        }
        let fallen = self.fallen.and_then(|part| self.child(part));
        if let Some(fallen) = fallen
            && let Some(ending) = fallen.ending()
            // A stage that failed during the stop did not cause it. A stage that did not end has
            // been reported.
            && !(fallen.was_told_to_stop() && matches!(ending, Ending::Failed(_)))
            && !fallen.was_given_up()
        {
            eprintln!(
                "lariat: {} {ending}; the chain was stopped",
                fallen.part.name()
            );
        }
        ExitCode::FAILURE
    }
}
