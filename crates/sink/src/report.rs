//! The report of a run: the table, the stable summary, and the histograms.

use crate::error::Compared;
use crate::latency::{Latency, Row};
use crate::slowest::Slowest;
use crate::timeline::Timeline;
use crate::{FinalCounts, Restarts, Summary, hgrm, table};
use std::fmt;
use std::io::{self, Write};

/// All results of a run. `Display` writes the final table.
#[derive(Debug, Clone)]
pub struct Report {
    pub(crate) summary: Summary,
    pub(crate) latency: Latency,
    pub(crate) timeline: Timeline,
    pub(crate) slowest: Slowest,
    pub(crate) compared: Compared,
    pub(crate) facts: Facts,
}

/// Facts in the table that are not in the summary.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facts {
    pub(crate) period_ns: Option<u64>,
    pub(crate) from_start: bool,
    /// Arrival times of the first and the last message.
    pub(crate) span_ns: Option<[u64; 2]>,
    pub(crate) restarts: Restarts,
    pub(crate) stale: u64,
    pub(crate) blank: u64,
    /// Final totals of the stages, once they are known.
    pub(crate) finished: Option<FinalCounts>,
}

impl Report {
    /// Returns the figures of `summary.json`.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Returns the number of restarts seen, for each stage.
    pub fn restarts(&self) -> Restarts {
        self.facts.restarts
    }

    /// Returns the names and contents of the report's files: `report.txt`, `slowest.txt`, an
    /// `.hgrm` file for each row, and `summary.json`. The table is first and the summary last. If
    /// any file exists, the table does; if the summary exists, all others do.
    ///
    /// # Errors
    /// Returns only errors of writing to memory.
    pub fn files(&self) -> io::Result<Vec<(String, Vec<u8>)>> {
        let mut files = vec![("report.txt".to_owned(), self.to_string().into_bytes())];
        let [start_ns, _] = self.facts.span_ns.unwrap_or_default();
        let slowest = self.slowest.table(&self.latency, start_ns);
        let slowest = slowest.map_err(io::Error::other)?;
        files.push(("slowest.txt".to_owned(), slowest.into_bytes()));
        for row in Row::all() {
            let mut text = Vec::new();
            hgrm::write(self.latency.row(row), &mut text)?;
            files.push((format!("{}.hgrm", row.name()), text));
        }
        let mut json = serde_json::to_vec_pretty(&self.summary)?;
        json.push(b'\n');
        files.push(("summary.json".to_owned(), json));
        Ok(files)
    }

    /// Writes the times at which each stage worked on each of the last 1,000 frames, as a trace for
    /// Perfetto and Chrome.
    ///
    /// # Errors
    /// Returns an error if writing fails.
    pub fn write_timeline(&self, out: &mut impl Write) -> io::Result<()> {
        self.timeline.write(out)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        table::write(self, f)
    }
}
