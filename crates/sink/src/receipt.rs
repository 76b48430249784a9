//! What is counted of a descriptors message: little enough to be kept until somebody has time to count it.

use crate::truth::is_seen;
use lariat_message::{Descriptors, Trace};

/// A descriptors message that came, as far as it is counted and timed.
#[derive(Debug, Clone, Copy)]
pub struct Receipt {
    pub(crate) trace: Trace,
    pub(crate) received_ns: u64,
    /// Curves that were seen.
    pub(crate) seen: usize,
    /// Without an image there is nothing that was exposed.
    pub(crate) is_blank: bool,
}

impl Receipt {
    /// How many messages fit had sent with it.
    pub fn fitted(&self) -> u64 {
        self.trace.fitted
    }

    pub(crate) fn of(message: &Descriptors, received_ns: u64) -> Self {
        let curves = message.curves().iter();
        Self {
            trace: message.trace,
            received_ns,
            seen: curves.filter(|curve| is_seen(curve.status())).count(),
            is_blank: message.width == 0,
        }
    }
}
