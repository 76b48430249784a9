//! What the chain did: latency histograms, losses, errors against the truth, reports.
//!
//! A library without clock or shared memory: whoever receives the messages hands them over and says when they came.
//! Every figure comes from the messages alone, because every stage stamps and counts its own work in the trace that they
//! carry.

mod error;
mod figure;
mod hgrm;
mod latency;
mod live;
mod losses;
mod machine;
mod options;
mod polyline;
mod report;
mod sink;
mod summary;
mod table;
mod times;
mod truth;

pub use losses::Restarts;
pub use machine::Machine;
pub use options::{FinalCounts, Options};
pub use report::{Report, ReportError};
pub use sink::Sink;
pub use summary::{Deadline, Distances, Errors, Frames, Latencies, Lost, Spread, Summary};
