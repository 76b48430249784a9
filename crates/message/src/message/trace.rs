//! The way of a frame through the chain.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

/// The way of one frame through the chain. Every message carries it; every stage adds its own lines.
///
/// The counters make every loss a difference: of two consecutive messages, what `sequence` advanced more than
/// `captured` was lost at the source, what `captured` advanced more than `extracted` between capture and extract, and
/// so on. All times are nanoseconds of `CLOCK_MONOTONIC`, 0 before they are known.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "transport",
    derive(ZeroCopySend),
    type_name("lariat.Trace.v1")
)]
pub struct Trace {
    /// The source's own frame number, from 1.
    pub sequence: u64,
    /// How many frames capture has sent, this one included.
    pub captured: u64,
    /// How many frames extract has sent, this one included.
    pub extracted: u64,
    /// How many frames fit has sent, this one included.
    pub fitted: u64,
    /// When the image was taken: the driver's timestamp, or the moment a file's frame was due.
    pub exposed_ns: u64,
    /// When capture had the frame ready to send.
    pub captured_ns: u64,
    /// When extract began.
    pub extract_started_ns: u64,
    /// When extract had its result ready to send.
    pub extracted_ns: u64,
    /// When fit began.
    pub fit_started_ns: u64,
    /// When fit had its result ready to send.
    pub fitted_ns: u64,
}

impl Trace {
    /// A way not begun.
    pub const EMPTY: Self = Self {
        sequence: 0,
        captured: 0,
        extracted: 0,
        fitted: 0,
        exposed_ns: 0,
        captured_ns: 0,
        extract_started_ns: 0,
        extracted_ns: 0,
        fit_started_ns: 0,
        fitted_ns: 0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_layout_is_what_readers_in_other_languages_were_told() {
        assert_eq!(size_of::<Trace>(), 80);
    }
}
