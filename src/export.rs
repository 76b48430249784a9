//! `lariat export`: converts a recording to files for other programs.

mod csv;
mod jsonl;
mod pictures;
mod shapes;
mod y4m;

use crate::recording::{RecordingArgs, shown, span};
use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use lariat_capture::Position;
use lariat_chain::exit::wrong_use;
use lariat_chain::output::{Existing, Output, print};
use lariat_chain::recorded::Gather;
use lariat_chain::settings::range::position_of_flag;
use lariat_record::{Messages, Recording};
use std::io::BufWriter;
use std::num::NonZeroU64;
use std::path::PathBuf;
use std::process::ExitCode;

/// Export a recording to files for other programs
///
/// csv: a row for each rope in each frame, with its control points. jsonl: an object for each
/// frame, with all fields of its descriptors. y4m: a video, which `lariat run --source` can play.
/// png: a folder of numbered, lossless pictures.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    recording: RecordingArgs,
    /// Format of the files
    #[arg(long, value_enum)]
    format: Format,
    /// File to write, - for standard output; for png the folder, which must be new or empty
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// First frame: its position in the recording, from 1, or a time from the start, such as 2.5s
    #[arg(long, value_name = "PLACE", value_parser = position_of_flag)]
    from: Option<Position>,
    /// Last frame, or the time before which to end
    #[arg(long, value_name = "PLACE", value_parser = position_of_flag)]
    to: Option<Position>,
    /// Only every Nth of these frames
    #[arg(long, value_name = "N", default_value = "1")]
    every: NonZeroU64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Csv,
    Jsonl,
    Y4m,
    Png,
}

/// Part of a recording to export.
struct Part<'a> {
    recording: &'a Recording,
    args: &'a ExportArgs,
}

impl Part<'_> {
    /// Gathers the messages of each frame.
    fn gathered(&self) -> Result<Gather> {
        Gather::new(self.recording, span(self.args.from, self.args.to))
    }

    /// Messages of the frames.
    fn frames(&self) -> Result<Messages> {
        Ok(self
            .recording
            .messages(span(self.args.from, self.args.to))?)
    }

    /// Number of frames, and the capture times of the first and the last.
    fn frame_times_ns(&self) -> Result<(u64, Option<[u64; 2]>)> {
        let span = span(self.args.from, self.args.to);
        Ok(self.recording.frame_times_ns(span)?)
    }

    /// Error message for a file that cannot be written.
    fn failure(&self) -> String {
        format!("cannot write {}", self.args.out.display())
    }

    /// Returns whether to export the frame at this place in the part, counted from 0.
    fn is_wanted(&self, place: u64) -> bool {
        place.is_multiple_of(self.args.every.get())
    }
}

/// Summary of what was written, for the last line.
struct Written {
    what: String,
    /// Remarks for the user.
    notes: Vec<String>,
}

/// Runs `lariat export`.
///
/// # Errors
/// Returns an error if the recording cannot be read, has nothing of the requested kind, or the
/// files cannot be written. No incomplete file is left behind.
pub(crate) fn run(args: ExportArgs) -> Result<ExitCode> {
    let recording = args.recording.open()?;
    let about = || shown(&args.recording.file);
    if let (Some(Position::Frame(from)), Some(Position::Frame(to))) = (args.from, args.to)
        && to < from
    {
        wrong_use!(
            "there is no frame from {from} to {to}: --to is the last frame, and at least --from"
        );
    }
    let part = Part {
        recording: &recording,
        args: &args,
    };
    let written = if args.format == Format::Png {
        let written = pictures::write(&part, &args.out).with_context(about)?;
        print(&format!("wrote {}: {}\n", args.out.display(), written.what))?;
        written
    } else {
        let existing = Existing::forced(args.force);
        let output = Output::new(&args.out, existing, [args.recording.file.as_path()])?;
        let written = write(&part, &output).with_context(about)?;
        output.print(&format!("wrote {output}: {}\n", written.what))?;
        written
    };
    for note in written.notes {
        eprintln!("lariat: {note}");
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes an export that is a single file.
fn write(part: &Part, output: &Output) -> Result<Written> {
    let mut file = BufWriter::new(output.begin()?);
    let written = match part.args.format {
        Format::Csv => csv::write(part, &mut file)?,
        Format::Jsonl => jsonl::write(part, &mut file)?,
        Format::Y4m | Format::Png => y4m::write(part, &mut file)?,
    };
    let file = file.into_inner().map_err(|error| error.into_error());
    file.with_context(|| part.failure())?.place()?;
    Ok(written)
}
