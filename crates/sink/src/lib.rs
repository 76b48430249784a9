//! The accounts of a chain: latency histograms, losses, errors relative to the truth, and reports.
//!
//! This library uses neither a clock nor shared memory: the caller receives the messages and passes
//! them on together with their arrival times. Every figure comes from the messages alone, because
//! every stage records its own times and counts in the trace that they carry.
//!
//! ```
//! use lariat_sink::{FinalCounts, Options, Sink};
//! use lariat_message::{Descriptors, now_ns};
//!
//! let mut sink = Sink::new(Options { from_start: true, ..Options::default() });
//! let mut message = Box::new(Descriptors::EMPTY); // from a reader
//! (message.trace.sequence, message.trace.captured) = (3, 3);
//! (message.trace.extracted, message.trace.fitted) = (2, 1);
//! sink.descriptors(&message, now_ns());
//! sink.finish(FinalCounts::default());
//! let lost = sink.frames().lost;
//! assert_eq!((lost.source, lost.capture, lost.extract, lost.fit), (0, 1, 1, 0));
//! println!("{}", sink.report());
//! ```

mod counts;
mod drawn;
mod error;
mod figure;
mod hgrm;
mod latency;
mod live;
mod losses;
mod machine;
mod options;
mod passage;
mod polyline;
mod receipt;
mod report;
mod saved;
mod sink;
mod slowest;
mod step;
mod summary;
mod table;
mod tally;
mod timeline;
mod times;
mod truth;

pub use drawn::points_along;
pub use figure::{Figure, Micros};
pub use losses::{Arrival, Ledger, Restarts};
pub use machine::Machine;
pub use options::{DepthCounts, FinalCounts, Options};
pub use receipt::Receipt;
pub use report::Report;
pub use saved::RestoreError;
pub use sink::Sink;
pub use step::Step;
pub use summary::{
    AtRestart, Deadline, Depth, Distances, Errors, Frames, Latencies, Lost, Spread, Summary,
};
pub use tally::Tally;
pub use times::Times;
