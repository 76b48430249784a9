//! What a run writes: the report, the timeline and the recording. Whether they can be written is asked before the first frame.
//!
//! The report and the timeline are written at the end, and while the run goes on each time that the sink says so: each file is
//! there whole, as it was last.

use crate::exit::wrong_use;
use anyhow::{Context, Result};
use lariat_sink::Report;
use std::path::{Path, PathBuf};

use crate::output::{Existing, Output, OutputFolder};
use crate::settings::Settings;

/// The report's folder, and the timeline.
pub struct RunFiles {
    folder: Option<OutputFolder>,
    trace: Option<Output>,
    /// Whether the recording goes to standard output.
    record_takes_stdout: bool,
}

impl RunFiles {
    /// # Errors
    /// One of them cannot be written, is there already, or is one that is read.
    pub fn open(settings: &Settings) -> Result<Self> {
        Self::open_over(settings, existing(settings))
    }

    /// Those of a run whose last sink is gone: what that one has written is the run's own.
    ///
    /// # Errors
    /// As of [`open`](Self::open).
    pub fn reopen(settings: &Settings) -> Result<Self> {
        Self::open_over(settings, Existing::Replace)
    }

    fn open_over(settings: &Settings, existing: Existing) -> Result<Self> {
        let folder =
            |path: &PathBuf| OutputFolder::new(path, existing, ["report.txt", "summary.json"]);
        let trace = |path: &PathBuf| Output::new(path, existing, settings.inputs());
        let files = Self {
            folder: settings.run.out.as_ref().map(folder).transpose()?,
            trace: settings.run.trace.as_ref().map(trace).transpose()?,
            record_takes_stdout: settings.run.record.as_deref() == Some(Path::new("-")),
        };
        if files.record_takes_stdout && files.trace.as_ref().is_some_and(Output::is_stdout) {
            wrong_use!(
                "the recording and the timeline cannot both go to standard output: give one of them a file"
            );
        }
        Ok(files)
    }

    /// The same, and the recording: before anything is started that would find it out later.
    ///
    /// # Errors
    /// As above.
    pub fn open_all(settings: &Settings) -> Result<Self> {
        let files = Self::open(settings)?;
        if let Some(file) = &settings.run.record {
            check_recording(settings, file)?;
        }
        Ok(files)
    }

    /// Whether standard output is one of the files, so that nothing else may be said there.
    pub fn take_stdout(&self) -> bool {
        self.record_takes_stdout || self.trace.as_ref().is_some_and(Output::is_stdout)
    }

    /// Whether any of them can be written before the end.
    pub fn can_be_renewed(&self) -> bool {
        self.folder.is_some() || self.trace.as_ref().is_some_and(Output::is_file)
    }

    /// Writes those that can be written again, as they are now.
    ///
    /// # Errors
    /// As of [`write`](Self::write).
    pub fn renew(&mut self, report: &Report) -> Result<()> {
        if let Some(folder) = &mut self.folder {
            write_report(folder, report)?;
            folder.replace_from_now_on();
        }
        if let Some(output) = self.trace.as_mut().filter(|output| output.is_file()) {
            write_timeline(output, report)?;
            output.replace_from_now_on();
        }
        Ok(())
    }

    /// Writes them.
    ///
    /// # Errors
    /// One of them could not be written; those before it are.
    pub fn write(&self, report: &Report) -> Result<()> {
        if let Some(folder) = &self.folder {
            write_report(folder, report)?;
        }
        match &self.trace {
            Some(output) => write_timeline(output, report),
            None => Ok(()),
        }
    }
}

/// Writes a report into its folder.
///
/// # Errors
/// A file could not be written.
pub fn write_report(folder: &OutputFolder, report: &Report) -> Result<()> {
    let files = report.files().context("the report cannot be made")?;
    files
        .iter()
        .try_for_each(|(name, bytes)| folder.write(name, bytes))
}

fn write_timeline(output: &Output, report: &Report) -> Result<()> {
    let mut json = Vec::new();
    report.write_timeline(&mut json)?;
    output.write(&json)
}

/// Whether a recording can be begun in this file. Of one that keeps the last seconds the names are made when it writes.
///
/// # Errors
/// It cannot, there is one already, or it is what is shown.
pub fn check_recording(settings: &Settings, file: &Path) -> Result<()> {
    match settings.record.ring {
        None => output(settings, file).map(|_| ()),
        Some(_) if file == Path::new("-") => {
            wrong_use!("--ring writes a file on each request: name one, not -")
        }
        Some(_) => Ok(()),
    }
}

fn output(settings: &Settings, path: &Path) -> Result<Output> {
    Output::new(path, existing(settings), settings.inputs())
}

fn existing(settings: &Settings) -> Existing {
    Existing::forced(settings.record.replace)
}
