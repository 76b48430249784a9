//! What remains of a run: the table, the stable summary, the histograms.

use crate::error::Comparison;
use crate::latency::{Latency, Row};
use crate::timeline::Timeline;
use crate::{FinalCounts, Restarts, Summary, hgrm, table};
use std::fmt;
use std::fs::{File, create_dir_all, remove_file, rename};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Everything that a run has shown. `Display` is the final table.
#[derive(Debug, Clone)]
pub struct Report {
    pub(crate) summary: Summary,
    pub(crate) latency: Latency,
    pub(crate) timeline: Timeline,
    pub(crate) centerline: Comparison,
    pub(crate) curve: Comparison,
    pub(crate) facts: Facts,
}

/// What the table says and the summary does not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facts {
    pub(crate) period_ns: Option<u64>,
    pub(crate) from_start: bool,
    /// When the first and the last message came.
    pub(crate) span_ns: Option<(u64, u64)>,
    pub(crate) restarts: Restarts,
    pub(crate) stale: u64,
    pub(crate) blank: u64,
    pub(crate) unknown_basis: u64,
    /// What the stages said at the end, if it has come.
    pub(crate) finished: Option<FinalCounts>,
}

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The folder could not be made.
    #[error("The report's folder {} cannot be made ({source}): name one that can be written to.", dir.display())]
    Folder {
        /// The folder.
        dir: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A file could not be written.
    #[error("The report's file {} cannot be written ({source}): make room for it, or name another folder.", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl Report {
    /// The figures of `summary.json`.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Which stages were seen to begin anew.
    pub fn restarts(&self) -> Restarts {
        self.facts.restarts
    }

    /// Writes `report.txt`, `summary.json` and an `.hgrm` file for each row into `dir`, which is made if it is missing.
    ///
    /// Each file is written beside its place and then put there, so that no reader ever finds half of one. The summary
    /// comes last: where it is, the others are.
    pub fn write_to(&self, dir: &Path) -> Result<(), ReportError> {
        create_dir_all(dir).map_err(|source| ReportError::Folder {
            dir: dir.to_owned(),
            source,
        })?;
        for row in Row::ALL {
            let name = format!("{}.hgrm", row.name());
            put(dir, &name, |out| hgrm::write(self.latency.row(row), out))?;
        }
        put(dir, "report.txt", |out| write!(out, "{self}"))?;
        put(dir, "summary.json", |out| {
            serde_json::to_writer_pretty(&mut *out, &self.summary)?;
            writeln!(out)
        })
    }
}

impl Report {
    /// Writes when each stage worked on each of the last 1,000 frames, as a trace that Perfetto and Chrome show.
    ///
    /// # Errors
    /// The file cannot be written; one that was there is then as it was.
    pub fn write_timeline_to(&self, file: &Path) -> Result<(), ReportError> {
        let dir = file.parent().unwrap_or(Path::new(""));
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        put(dir, &name, |out| self.timeline.write(out))
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        table::write(self, f)
    }
}

/// Puts a file into the folder, whole or not at all.
fn put(
    dir: &Path,
    name: &str,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), ReportError> {
    let file = dir.join(name);
    // The process's number keeps two writers into one folder apart.
    let unfinished = dir.join(format!(".{name}.{}", std::process::id()));
    let written = File::create(&unfinished).and_then(|created| {
        let mut out = BufWriter::new(created);
        content(&mut out)?;
        // Its flush can fail, and says so; a drop would not.
        out.into_inner()?;
        rename(&unfinished, &file)
    });
    written.map_err(|source| {
        // If it was not even made, there is nothing to remove.
        let _ = remove_file(&unfinished);
        ReportError::File { file, source }
    })
}
