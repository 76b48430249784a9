//! Loss accounting: determines where frames were lost, using only differences of the counters in
//! the trace.
//!
//! Each stage numbers its messages. Between two consecutive messages at the sink, the source's
//! number and the counters of capture, extract and fit increase by Δs, Δc, Δe, Δf. The source
//! skipped Δs − Δc frames. The link after capture lost Δc − Δe, the one after extract Δe − Δf, and
//! the one after fit Δf − 1. The sums telescope, so every published frame is received or lost on
//! exactly one link. At its end, extract reports how many of the Δc − Δe frames it skipped for lack
//! of a mask.
//!
//! A stage that its chain restarts continues its counter and reports the restart in the trace.
//! Frames lost on any link between the last message before the restart and the first one after it
//! were lost at that restart (`at_restart`). A stage of a chain that was restarted as a whole
//! counts from 1 again, so the difference is the counter itself. No stage sends more than it
//! receives, therefore Δs ≥ Δc ≥ Δe ≥ Δf ≥ 1. If the counters after such a restart violate this,
//! the later stage's step counts for both, because a stage cannot send what it did not receive.
//!
//! On another machine, the bridge is one more stage, which counts the messages that it writes
//! there, Δb. Then Δf − Δb were lost on the way to that machine, and Δb − 1 after it.
//!
//! A restarted sink continues where the last one stopped. It counts the Δf − 1 of its first message
//! as lost with the last sink: messages that were received but not yet saved, and messages that
//! arrived while no sink ran.
//!
//! Always, `frames.published` = `received` + `lost.capture` + `lost.mask` + `lost.extract` +
//! `lost.bridge` + `lost.fit` + `lost.sink`. If the stages run by hand, without a chain that passes
//! the counts on, frames skipped for lack of a mask are in `lost.capture`. Frames in progress when
//! the chain stopped are accounted for, too. Each stage reports at its end what it sent, and the
//! chain passes this to the sink on its standard input. Messages that the stages sent after the
//! last received one count as lost on their links. If a stage did not live to report, its share
//! counts as lost on the link before it, and the sum is still exact.

use crate::saved::{LARGEST_COUNT, RestoreError, Saved, Saving, sound};
use crate::{AtRestart, FinalCounts, Lost};
use lariat_message::Trace;

/// Number of restarts seen, for each stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Restarts {
    /// Capture, or its source.
    pub capture: u64,
    /// Extract.
    pub extract: u64,
    /// Fit.
    pub fit: u64,
    /// The sink itself.
    pub sink: u64,
}

/// The source's number and the counters of capture, extract and fit, in the order of the data.
type Counters = [u64; 4];

/// Classification of a message by the accounting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrival {
    /// The first message.
    First,
    /// A later message.
    Next,
    /// The first message after the sink continued where another stopped.
    Resumed,
    /// Not counted: seen before, older than one seen before, or with impossible counters or times.
    Stale,
}

/// The loss accounting: what was received, and what was lost on which link, according to the
/// counters in the traces.
#[derive(Debug, Clone)]
pub struct Ledger {
    from_start: bool,
    /// Counters of the first message.
    first: Option<Counters>,
    last: Option<(Counters, u64)>,
    /// Sums of the steps Δs, Δc, Δe, Δf.
    steps: Counters,
    received: u64,
    /// The bridge's counter; 0 if the last message came without a bridge.
    bridged: u64,
    /// Messages that fit sent but no bridge wrote on this machine.
    over_bridge: u64,
    /// Messages from fit that were lost with the last sink.
    with_sink: u64,
    /// True until the first message after the sink continued where another stopped.
    resumed: bool,
    stale: u64,
    /// Frames that extract reports as skipped for lack of a mask.
    masks_late: u64,
    /// Restarts according to the last message's trace.
    said: [u8; 3],
    /// Losses after capture, extract and fit that happened at a restart.
    at_restart: [u64; 3],
    restarts: Restarts,
}

impl Ledger {
    /// Starts empty. With `from_start`, the sink was running before the first frame, so everything
    /// missing before the first message was lost.
    pub fn new(from_start: bool) -> Self {
        Self {
            from_start,
            first: None,
            last: None,
            steps: [0; 4],
            received: 0,
            bridged: 0,
            over_bridge: 0,
            with_sink: 0,
            resumed: false,
            stale: 0,
            masks_late: 0,
            said: [0; 3],
            at_restart: [0; 3],
            restarts: Restarts::default(),
        }
    }

    /// Counts one descriptors message and its arrival time.
    pub fn received(&mut self, trace: &Trace, received_ns: u64) -> Arrival {
        let counts = [trace.captured, trace.extracted, trace.fitted, trace.bridged];
        if counts.iter().any(|&count| count > LARGEST_COUNT) || trace.fitted_ns > received_ns {
            // If this message were counted, it would be ahead of all later messages, and none of
            // those would count.
            self.stale += 1;
            return Arrival::Stale;
        }
        let now = [
            trace.sequence,
            trace.captured,
            trace.extracted,
            trace.fitted,
        ];
        let (before, arrival) = match self.last {
            // A restarted fit also counts from 1, but its clock does not go back.
            Some((last, fitted_ns)) if now[3] <= last[3] && trace.fitted_ns <= fitted_ns => {
                // A reader that joins late gets the newest earlier message, which the last sink has
                // counted.
                let is_repeated = self.resumed && now == last;
                self.stale += u64::from(!is_repeated);
                return Arrival::Stale;
            }
            Some((last, _)) => (last, Arrival::Next),
            None if self.from_start => ([0; 4], Arrival::First),
            None => (now.map(|count| count.saturating_sub(1)), Arrival::First),
        };
        let arrival = if self.resumed {
            Arrival::Resumed
        } else {
            arrival
        };
        let lost_before = self.lost();
        self.received += 1;
        self.first.get_or_insert(now);
        let written = self.follow_bridge(trace.bridged);
        let fitted = self.steps[3];
        self.advance(before, now.map(Some), written);
        if trace.bridged > 0 {
            self.over_bridge += self.steps[3] - fitted - written;
        }
        self.lose_with_sink(lost_before.fit);
        self.note_restarts(trace, arrival, &lost_before);
        self.last = Some((now, trace.fitted_ns));
        arrival
    }

    /// Returns how many messages a bridge has written here since the last one, including this one.
    /// Returns 1 without a bridge.
    fn follow_bridge(&mut self, bridged: u64) -> u64 {
        match std::mem::replace(&mut self.bridged, bridged) {
            last if last > 0 && last < bridged => bridged - last,
            // The bridge was restarted.
            last if bridged > 0 && last > bridged => bridged,
            _ => 1,
        }
    }

    /// Counts the frames that were in progress when the chain stopped.
    pub fn finish(&mut self, sent: FinalCounts) {
        self.masks_late = sent.masks_late.unwrap_or(0);
        if let Some([sequence, captured]) = sent.before_first {
            self.begin_after([sequence, captured, 0, 0]);
        }
        let (before, fitted_ns) = match self.last {
            Some(last) => last,
            None if self.from_start => ([0; 4], 0),
            // No message arrived, and what was sent before the sink started is unknown.
            None => return,
        };
        let now = [
            sent.last_sequence,
            sent.captured,
            sent.extracted,
            sent.fitted,
        ];
        let lost_before = self.lost().fit;
        let reached = self.advance(before, now, 0);
        self.lose_with_sink(lost_before);
        self.last = Some((reached, fitted_ns));
    }

    /// Counts the restarts that the trace reports since the last message, and the losses meanwhile.
    fn note_restarts(&mut self, trace: &Trace, arrival: Arrival, before: &Lost) {
        let said = trace.restarts();
        let last = std::mem::replace(&mut self.said, said);
        if said == last || arrival == Arrival::First && !self.from_start {
            return;
        }
        let times = [0, 1, 2].map(|stage| u64::from(said[stage].wrapping_sub(last[stage])));
        self.restarts.capture += times[0];
        self.restarts.extract += times[1];
        self.restarts.fit += times[2];
        let now = self.lost();
        let lost = [
            now.capture + now.mask - before.capture - before.mask,
            now.extract - before.extract,
            now.fit - before.fit,
        ];
        for (sum, lost) in self.at_restart.iter_mut().zip(lost) {
            *sum += lost;
        }
    }

    /// Returns the losses after capture, extract and fit between the last message before a stage's
    /// restart and the first one after it.
    pub fn at_restart(&self) -> AtRestart {
        let [capture, extract, fit] = self.at_restart;
        AtRestart {
            capture,
            extract,
            fit,
        }
    }

    /// Continues where another ledger stopped.
    pub(crate) fn resume(&mut self) {
        self.resumed = true;
        self.restarts.sink += 1;
    }

    /// Attributes new losses after fit to the last sink, if this sink has just continued from it.
    fn lose_with_sink(&mut self, before: u64) {
        if std::mem::take(&mut self.resumed) {
            self.with_sink += self.lost().fit - before;
        }
    }

    /// Counts the losses before the first message, now that the counters at the start of the chain
    /// are known.
    fn begin_after(&mut self, before: Counters) {
        let Some(first) = self.first else {
            self.last = Some((before, 0));
            return;
        };
        let mut least = 0;
        for i in (0..4).rev() {
            // A negative difference means a restart in between.
            let step = (first[i].saturating_sub(1)).saturating_sub(before[i]);
            least = step.max(least);
            self.steps[i] = self.steps[i].saturating_add(least);
        }
    }

    /// Adds the steps from `before` to `now`; the last step is at least `least`. An unknown counter
    /// moves as far as the later ones prove. Returns the resulting counters.
    fn advance(&mut self, before: Counters, now: [Option<u64>; 4], least: u64) -> Counters {
        let mut reached = before;
        let mut least = least;
        let mut again = [false; 4];
        for i in (0..4).rev() {
            let step = match now[i] {
                Some(count) if count < before[i] => {
                    again[i] = true;
                    count.max(least)
                }
                Some(count) => {
                    // The step is smaller than the next stage's: this stage was restarted, and its
                    // new count has passed the old one.
                    again[i] = count - before[i] < least;
                    (count - before[i]).max(least)
                }
                None => least,
            };
            reached[i] = now[i].unwrap_or(before[i].saturating_add(step));
            self.steps[i] = self.steps[i].saturating_add(step);
            least = step;
        }
        self.restarts.capture += u64::from(again[0] || again[1]);
        self.restarts.extract += u64::from(again[2]);
        self.restarts.fit += u64::from(again[3]);
        reached
    }

    /// Returns the number of frames that capture sent, as far as known.
    pub fn published(&self) -> u64 {
        self.steps[1]
    }

    /// Returns the number of messages received, each counted once.
    pub fn received_count(&self) -> u64 {
        self.received
    }

    /// Returns the number of messages that were not counted because they were repeated, late or
    /// damaged.
    pub fn stale(&self) -> u64 {
        self.stale
    }

    /// Returns the losses on each link. The subtractions cannot be negative, because no step is
    /// smaller than the next stage's.
    pub fn lost(&self) -> Lost {
        let [source, captured, extracted, fitted] = self.steps;
        // A sink that joined late has not counted all frames that extract skipped.
        let mask = self.masks_late.min(captured - extracted);
        Lost {
            source: source - captured,
            capture: captured - extracted - mask,
            mask,
            extract: extracted - fitted,
            bridge: self.over_bridge,
            fit: fitted - self.over_bridge - self.received - self.with_sink,
            sink: self.with_sink,
        }
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        to.optional(self.first);
        to.optional(self.last.map(|([s, c, e, f], at_ns)| [s, c, e, f, at_ns]));
        to.numbers(self.steps);
        to.numbers([
            self.received,
            self.bridged,
            self.over_bridge,
            self.with_sink,
        ]);
        to.numbers([self.stale, self.masks_late]);
        to.number(self.resumed.into());
        let Restarts {
            capture,
            extract,
            fit,
            sink,
        } = self.restarts;
        to.numbers([capture, extract, fit, sink]);
        to.numbers(self.at_restart);
        to.numbers(self.said.map(u64::from));
    }

    pub(crate) fn restore(from: &mut Saved, from_start: bool) -> Result<Self, RestoreError> {
        let first = from.optional()?;
        let last = from.optional()?;
        let steps = from.numbers()?;
        let [received, bridged, over_bridge, with_sink] =
            [from.count()?, from.count()?, from.count()?, from.count()?];
        let [stale, masks_late] = [from.count()?, from.number()?];
        let is_sound =
            steps.is_sorted_by(|a, b| a >= b) && received + over_bridge + with_sink <= steps[3];
        sound((), |()| is_sound)?;
        Ok(Self {
            from_start,
            first,
            last: last.map(|[s, c, e, f, at_ns]| ([s, c, e, f], at_ns)),
            steps,
            received,
            bridged,
            over_bridge,
            with_sink,
            resumed: from.flag()?,
            stale,
            masks_late,
            restarts: Restarts {
                capture: from.count()?,
                extract: from.count()?,
                fit: from.count()?,
                sink: from.count()?,
            },
            at_restart: from.numbers()?,
            said: from.numbers()?.map(|count| count as u8),
        })
    }

    /// Returns the number of restarts of each stage.
    pub fn restarts(&self) -> Restarts {
        self.restarts
    }
}
