//! The sink: turns messages into figures.

use crate::live::Live;
use crate::losses::Arrival;
use crate::receipt::Receipt;
use crate::summary::Frames;
use crate::tally::Tally;
use crate::truth::Truth;
use crate::{FinalCounts, Machine, Options, Report};
use lariat_message::{Centerlines, Descriptors};

/// Counts, times and checks the output of a chain.
///
/// It is independent of clocks and services: the caller passes messages and their arrival times.
/// After its creation it allocates nothing for a message.
#[derive(Debug)]
pub struct Sink {
    tally: Tally,
    truth: Truth,
    live: Live,
}

impl Sink {
    /// Creates an empty sink.
    pub fn new(options: Options) -> Self {
        Self::of(Tally::new(options))
    }

    /// Creates a sink that continues a tally. Messages that waited for their truth are not
    /// compared, and the live line starts again.
    pub fn of(tally: Tally) -> Self {
        let live = Live::new(tally.compared.shown());
        Self {
            tally,
            truth: Truth::new(),
            live,
        }
    }

    /// Takes a descriptors message and the time of its reception. A repeated message is not counted
    /// again.
    ///
    /// Returns the receipt that was [counted](Tally::count), for another tally.
    pub fn descriptors(&mut self, message: &Descriptors, received_ns: u64) -> Receipt {
        let receipt = Receipt::of(message, received_ns);
        let (arrival, total_ns) = self.tally.count(&receipt);
        if arrival != Arrival::Stale {
            self.live.received(receipt.seen, total_ns, received_ns);
            self.truth.descriptors(message, &mut self.tally.compared);
        }
        receipt
    }

    /// Takes a centerlines message, to compute its error relative to the truth.
    pub fn centerlines(&mut self, message: &Centerlines) {
        self.truth.centerlines(message, &mut self.tally.compared);
    }

    /// Takes the true centerlines of a frame, if the source knows them. They may come before or
    /// after the measurements.
    pub fn truth(&mut self, message: &Centerlines) {
        self.truth.truth(message, &mut self.tally.compared);
    }

    /// Takes the totals that the stages report when the chain has stopped.
    pub fn finish(&mut self, sent: FinalCounts) {
        self.tally.finish(sent);
    }

    /// Returns the live line without a line end. Call this about once a second for separate lines,
    /// or ten times a second for a line in place.
    pub fn live_line(&mut self, now_ns: u64) -> &str {
        let Tally {
            counts, compared, ..
        } = &self.tally;
        self.live.line(now_ns, &counts.ledger, compared.shown())
    }

    /// Returns everything that was counted, timed and compared until now.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Returns the number of frames until now, and the losses.
    pub fn frames(&self) -> Frames {
        self.tally.frames()
    }

    /// Returns the report of this run until now, on this machine.
    pub fn report(&self) -> Report {
        self.report_on(Machine::this())
    }

    /// Returns the report of this run until now, for the given machine.
    pub fn report_on(&self, machine: Machine) -> Report {
        self.tally.report_on(machine)
    }
}
