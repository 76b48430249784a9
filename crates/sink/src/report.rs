//! What remains of a run: the table, the stable summary, the histograms.

use crate::error::Compared;
use crate::latency::{Latency, Row};
use crate::slowest::Slowest;
use crate::timeline::Timeline;
use crate::{FinalCounts, Restarts, Summary, hgrm, table};
use std::fmt;
use std::io::{self, Write};

/// Everything that a run has shown. `Display` is the final table.
#[derive(Debug, Clone)]
pub struct Report {
    pub(crate) summary: Summary,
    pub(crate) latency: Latency,
    pub(crate) timeline: Timeline,
    pub(crate) slowest: Slowest,
    pub(crate) compared: Compared,
    pub(crate) facts: Facts,
}

/// What the table says and the summary does not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facts {
    pub(crate) period_ns: Option<u64>,
    pub(crate) from_start: bool,
    /// When the first and the last message came.
    pub(crate) span_ns: Option<[u64; 2]>,
    pub(crate) restarts: Restarts,
    pub(crate) stale: u64,
    pub(crate) blank: u64,
    /// What the stages said at the end, if it has come.
    pub(crate) finished: Option<FinalCounts>,
}

impl Report {
    /// The figures of `summary.json`.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Which stages were seen to begin again.
    pub fn restarts(&self) -> Restarts {
        self.facts.restarts
    }

    /// The files of a report, names and contents: `report.txt`, `slowest.txt`, an `.hgrm` for each row, `summary.json`. The table comes first and
    /// the summary last: where there is any of them there is that, and where this is, the others are.
    ///
    /// # Errors
    /// None but those of writing to memory.
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

    /// Writes when each stage worked on each of the last 1,000 frames, as a trace that Perfetto and Chrome show.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_timeline(&self, out: &mut impl Write) -> io::Result<()> {
        self.timeline.write(out)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        table::write(self, f)
    }
}
