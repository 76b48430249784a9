//! `diagnostic_msgs/DiagnosticArray`.

use lariat_record::{Cdr, Encoder};

use super::Header;

/// Level, as in `diagnostic_msgs/DiagnosticStatus`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Level {
    Ok = 0,
    Warn = 1,
    Stale = 3,
}

/// Status of one component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Status {
    pub(crate) level: Level,
    pub(crate) name: String,
    pub(crate) message: String,
    pub(crate) hardware_id: String,
    pub(crate) values: Vec<(String, String)>,
}

/// Writes the statuses.
pub(crate) fn diagnostics(statuses: &[Status], header: &Header, into: &mut Vec<u8>) {
    let to = &mut Encoder::new(into);
    header.put(to);
    to.byte_count(statuses.len());
    for status in statuses {
        (status.level as u8).put(to);
        to.string(&status.name);
        to.string(&status.message);
        to.string(&status.hardware_id);
        to.byte_count(status.values.len());
        for (key, value) in &status.values {
            to.string(key);
            to.string(value);
        }
    }
}
