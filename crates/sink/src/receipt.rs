//! Receipts of descriptors messages. A receipt is small enough to be kept until it is counted.

use crate::truth::is_seen;
use lariat_message::{Descriptors, Trace};

/// The properties of a received descriptors message that are counted and timed.
#[derive(Debug, Clone, Copy)]
pub struct Receipt {
    pub(crate) trace: Trace,
    pub(crate) received_ns: u64,
    /// Number of visible curves.
    pub(crate) seen: usize,
    /// True for a message without an image, and therefore without an exposure.
    pub(crate) is_blank: bool,
}

impl Receipt {
    /// Returns the number of messages that fit had sent, including this one.
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
