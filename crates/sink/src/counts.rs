//! Counts of messages, without their times. They are small enough to be saved with every message.

use crate::losses::{Arrival, Ledger};
use crate::receipt::Receipt;
use crate::saved::{RestoreError, Saved, Saving};

/// The counts of a tally.
#[derive(Debug, Clone)]
pub(crate) struct Counts {
    pub(crate) ledger: Ledger,
    pub(crate) with_curve: u64,
    pub(crate) blank: u64,
    /// Arrival times of the first and the last message.
    pub(crate) span_ns: Option<[u64; 2]>,
}

impl Counts {
    pub(crate) fn new(from_start: bool) -> Self {
        Self {
            ledger: Ledger::new(from_start),
            with_curve: 0,
            blank: 0,
            span_ns: None,
        }
    }

    pub(crate) fn count(&mut self, receipt: &Receipt) -> Arrival {
        let received_ns = receipt.received_ns;
        let arrival = self.ledger.received(&receipt.trace, received_ns);
        if arrival != Arrival::Stale {
            self.with_curve += u64::from(receipt.seen > 0);
            self.blank += u64::from(receipt.is_blank);
            let [first_ns, _] = self.span_ns.unwrap_or([received_ns; 2]);
            self.span_ns = Some([first_ns, received_ns]);
        }
        arrival
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        self.ledger.save(to);
        to.numbers([self.with_curve, self.blank]);
        to.optional(self.span_ns);
    }

    pub(crate) fn restore(from: &mut Saved, from_start: bool) -> Result<Self, RestoreError> {
        Ok(Self {
            ledger: Ledger::restore(from, from_start)?,
            with_curve: from.count()?,
            blank: from.count()?,
            span_ns: from.optional()?,
        })
    }
}
