//! The sink's handover state: the counts, saved with each round of messages, and the times, saved
//! every second. `lariat_sink` encodes both, including checksums.

use std::io;

use lariat_sink::{Options, RestoreError, Tally};

use crate::stages::handover::{DoubleBuffer, Handover};

/// Part of the state that is written repeatedly, through a buffer.
pub(super) struct HandoverWriter {
    buffers: DoubleBuffer,
    buffer: Vec<u8>,
}

impl HandoverWriter {
    /// `room` is the capacity in bytes that is needed to write without allocation.
    pub(super) fn new(buffers: DoubleBuffer, room: usize) -> Self {
        let buffer = Vec::with_capacity(room);
        Self { buffers, buffer }
    }

    /// Writes the output of `save`. Allocates only if it is longer than before.
    pub(super) fn write(&mut self, save: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        self.buffer.clear();
        save(&mut self.buffer);
        self.buffers.write(&self.buffer)
    }
}

/// Returns true if a previous sink has counted messages.
pub(super) fn is_inherited(handover: &Handover) -> bool {
    handover
        .state()
        .is_some_and(|left| left.newest_first().next().is_some())
}

/// Returns the tally that a sink continues: that of the previous sink, or an empty one. If the
/// previous tally is unreadable, warns and counts only messages that arrive from now on.
pub(super) fn tally(handover: &Handover, options: Options) -> Tally {
    if !is_inherited(handover) {
        return Tally::new(options);
    }
    inherited(handover, options).unwrap_or_else(|cause| {
        tracing::warn!(
            "sink counts from now on, as it cannot continue where the last one stopped: {cause}"
        );
        Tally::new(Options {
            from_start: false,
            ..options
        })
    })
}

fn inherited(handover: &Handover, options: Options) -> Result<Tally, RestoreError> {
    // The times are at most a second old. If they are unreadable, the counts are still valid.
    let tally = newest(handover.tally(), |bytes| Tally::restore(options, bytes));
    let mut tally = tally.unwrap_or_else(|_| Tally::new(options));
    newest(handover.state(), |bytes| tally.restore_counts(bytes))?;
    Ok(tally.resumed())
}

/// Returns the newest copy that `restore` accepts, or the reason why it accepts none.
fn newest<T>(
    buffers: Option<DoubleBuffer>,
    mut restore: impl FnMut(&[u8]) -> Result<T, RestoreError>,
) -> Result<T, RestoreError> {
    let mut found = Err(RestoreError::Damaged);
    for bytes in buffers.iter().flat_map(DoubleBuffer::newest_first) {
        found = restore(&bytes);
        if found.is_ok() {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_sink::{Sink, Times};
    use lariat_wire::{Descriptors, Trace};

    const OPTIONS: Options = Options {
        period_ns: None,
        deadline_ns: None,
        from_start: true,
    };

    fn receive(sink: &mut Sink, number: u64) {
        let mut message = Box::new(Descriptors::EMPTY);
        message.trace = Trace {
            sequence: number,
            captured: number,
            extracted: number,
            fitted: number,
            exposed_ns: number,
            fitted_ns: number,
            ..Trace::EMPTY
        };
        message.width = 1;
        sink.descriptors(&message, number + 1);
    }

    /// Creates a sink that receives `count` messages and saves everything after each.
    fn leave(handover: &Handover, count: u64) {
        let mut counts = HandoverWriter::new(handover.state().expect("held"), 0);
        let mut timed = HandoverWriter::new(handover.tally().expect("held"), 0);
        let mut sink = Sink::of(tally(handover, OPTIONS));
        let before = sink.frames().received;
        for number in before + 1..=before + count {
            receive(&mut sink, number);
            let tally = sink.tally();
            counts
                .write(|into| tally.save_counts(into))
                .expect("written");
            timed.write(|into| tally.save(into)).expect("written");
        }
    }

    fn inherit(handover: &Handover) -> (u64, u64, u64) {
        let tally = tally(handover, OPTIONS);
        let report = tally.report_on(lariat_sink::Machine::this());
        let files = report.files().expect("memory takes it");
        let total = files.iter().find(|(name, _)| name == "total.hgrm");
        let (_, total) = total.expect("there is one");
        let timed = Times::from_hgrm(&String::from_utf8_lossy(total));
        (
            tally.frames().received,
            timed.expect("a histogram").count(),
            report.restarts().sink,
        )
    }

    #[test]
    fn one_sink_goes_on_where_the_other_stopped() {
        let handover = Handover::make("sink").expect("memory");
        assert!(!is_inherited(&handover));
        leave(&handover, 5);
        assert!(is_inherited(&handover));
        assert_eq!(inherit(&handover), (5, 5, 1));
        leave(&handover, 1);
        // The first message waited for the sink to restart, so it is not timed.
        assert_eq!(inherit(&handover), (6, 5, 2));
    }

    #[test]
    fn what_is_damaged_leaves_the_older_one() {
        let handover = Handover::make("sink").expect("memory");
        leave(&handover, 6);
        let damage =
            |buffers: Option<DoubleBuffer>| buffers.expect("held").write(b"damaged").expect("room");
        damage(handover.tally());
        assert_eq!(inherit(&handover), (6, 6, 1));
        damage(handover.state());
        assert_eq!(inherit(&handover), (6, 6, 1));
        // The next state overwrites the older copy.
        leave(&handover, 1);
        assert_eq!(inherit(&handover), (7, 6, 2));
    }

    #[test]
    fn without_a_whole_one_the_counting_begins_again() {
        let handover = Handover::make("sink").expect("memory");
        leave(&handover, 6);
        for _ in 0..2 {
            let left = handover.state().expect("held");
            left.write(b"damaged").expect("room");
        }
        let mut sink = Sink::of(tally(&handover, OPTIONS));
        receive(&mut sink, 20);
        let frames = sink.frames();
        assert_eq!((frames.published, frames.received), (1, 1));
    }
}
