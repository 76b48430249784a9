//! Files that a run writes: the report, the timeline and the recording. The chain checks that they
//! can be written before the first frame.
//!
//! The report and the timeline are written at the end, and during the run whenever the sink
//! requests it. Each file is always complete, in its last state.

use crate::exit::wrong_use;
use anyhow::{Context, Result};
use lariat_sink::Report;
use std::path::{Path, PathBuf};

use crate::output::{Existing, Output, OutputFolder};
use crate::settings::Settings;

/// The report's folder and the timeline.
pub struct RunFiles {
    folder: Option<OutputFolder>,
    trace: Option<Output>,
    /// True if the recording goes to standard output.
    record_takes_stdout: bool,
}

impl RunFiles {
    /// Opens the report's folder and the timeline.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written, exists already, or is also an input.
    pub fn open(settings: &Settings) -> Result<Self> {
        Self::open_over(settings, existing(settings))
    }

    /// Opens the files of a run whose last sink is gone. They belong to the run and may be
    /// overwritten.
    ///
    /// # Errors
    /// Fails like [`open`](Self::open).
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

    /// Opens the files and checks the recording, before anything starts that would find the error
    /// later.
    ///
    /// # Errors
    /// Fails like [`open`](Self::open), also for the recording.
    pub fn open_all(settings: &Settings) -> Result<Self> {
        let files = Self::open(settings)?;
        if let Some(file) = &settings.run.record {
            check_recording(settings, file)?;
        }
        Ok(files)
    }

    /// Returns true if standard output is one of the files, so that nothing else may be printed
    /// there.
    pub fn take_stdout(&self) -> bool {
        self.record_takes_stdout || self.trace.as_ref().is_some_and(Output::is_stdout)
    }

    /// Returns true if any of the files can be written before the end.
    pub fn can_be_renewed(&self) -> bool {
        self.folder.is_some() || self.trace.as_ref().is_some_and(Output::is_file)
    }

    /// Writes the current state of all files that can be rewritten.
    ///
    /// # Errors
    /// Fails like [`write`](Self::write).
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

    /// Writes the files.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written. The files before it are written.
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
/// Returns an error if a file cannot be written.
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

/// Checks that a recording can be written to this file. The file names of a ring recording are
/// chosen when it writes.
///
/// # Errors
/// Returns an error if the file cannot be written, exists already, or is also an input.
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
