//! The sink itself: messages in, figures out.

use crate::live::Live;
use crate::losses::Arrival;
use crate::receipt::Receipt;
use crate::summary::Frames;
use crate::tally::Tally;
use crate::truth::Truth;
use crate::{FinalCounts, Machine, Options, Report};
use lariat_message::{Centerlines, Descriptors};

/// Counts, times and checks what comes out of a chain.
///
/// It knows neither clock nor service: whoever receives the messages says when. Once made, it allocates nothing for a
/// message.
#[derive(Debug)]
pub struct Sink {
    tally: Tally,
    truth: Truth,
    live: Live,
}

impl Sink {
    /// A sink that has seen nothing.
    pub fn new(options: Options) -> Self {
        Self::of(Tally::new(options))
    }

    /// A sink that continues a tally. Messages that waited for their truth are not compared, and the live line starts again.
    pub fn of(tally: Tally) -> Self {
        let live = Live::new(tally.compared.shown());
        Self {
            tally,
            truth: Truth::new(),
            live,
        }
    }

    /// One descriptors message, and when it was in the reader's hands. One that came before is not counted again.
    ///
    /// Returns what of it was [counted](Tally::count), for another tally.
    pub fn descriptors(&mut self, message: &Descriptors, received_ns: u64) -> Receipt {
        let receipt = Receipt::of(message, received_ns);
        let (arrival, total_ns) = self.tally.count(&receipt);
        if arrival != Arrival::Stale {
            self.live.received(receipt.seen, total_ns, received_ns);
            self.truth.descriptors(message, &mut self.tally.compared);
        }
        receipt
    }

    /// One centerlines message, for its error against the truth.
    pub fn centerlines(&mut self, message: &Centerlines) {
        self.truth.centerlines(message, &mut self.tally.compared);
    }

    /// The true centerlines of one frame, of a source that knows them; before or after what was measured in it.
    pub fn truth(&mut self, message: &Centerlines) {
        self.truth.truth(message, &mut self.tally.compared);
    }

    /// What the stages say they sent in all, known when the chain has stopped.
    pub fn finish(&mut self, sent: FinalCounts) {
        self.tally.finish(sent);
    }

    /// How it goes just now, in one line without its end. To be called about once a second for lines, or ten times a
    /// second for one line in place.
    pub fn live_line(&mut self, now_ns: u64) -> &str {
        let Tally {
            counts, compared, ..
        } = &self.tally;
        self.live.line(now_ns, &counts.ledger, compared.shown())
    }

    /// What was counted, timed and compared so far.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// How many frames so far, and where they went.
    pub fn frames(&self) -> Frames {
        self.tally.frames()
    }

    /// What has been seen so far, on this machine.
    pub fn report(&self) -> Report {
        self.report_on(Machine::this())
    }

    /// What has been seen so far, for the machine that is given.
    pub fn report_on(&self, machine: Machine) -> Report {
        self.tally.report_on(machine)
    }
}
