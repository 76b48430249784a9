//! `lariat fit FILE`: reads centerlines and writes descriptors in the same order, both with one
//! JSON object per line.

use crate::descriptor_json::{Descriptor, Quality};
use crate::versioned::Versioned;
use anyhow::{Context, Result};
use clap::Args;
use lariat_chain::bounded::LONGEST_TEXT;
use lariat_chain::exit::wrong_use;
use lariat_chain::settings::{Family, Flags, Settings};
use lariat_fit::{Fitter, Line, MAX_POINTS, Weights};
use serde::Deserialize;
use std::collections::HashMap;
use std::fs::{File, FileType};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Fit curves to centerlines: as the chain's third stage, or as a filter of JSON lines
///
/// With FILE (or `-`), or with a pipe or a file as standard input, it reads lines
/// `{"points":[[x,y],…]}` and writes one descriptor object per line. A line may also have
/// `"closed":true`, `"weights":[…]` for its points, and the width of the rope (`"width":12`),
/// against which the curve is judged. Otherwise it is the chain's third stage.
#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    /// File of JSON lines, each `{"points":[[x,y],…]}`; `-` is standard input
    file: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) flags: Flags,
}

/// Returns true if `lariat fit` is the filter of JSON lines: a file is named, or standard input is
/// a pipe or a file. With a terminal or `/dev/null`, it is the chain's stage.
pub(crate) fn is_line_filter(args: &FitArgs) -> bool {
    args.file.is_some()
        || std::fs::metadata("/dev/stdin").is_ok_and(|input| brings_lines(input.file_type()))
}

fn brings_lines(input: FileType) -> bool {
    // Some programs use sockets as their children's pipes.
    input.is_fifo() || input.is_file() || input.is_socket()
}

/// One line of the input. Other keys are ignored.
#[derive(Deserialize)]
struct Centerline {
    points: Vec<[f64; 2]>,
    closed: Option<bool>,
    weights: Option<Vec<f64>>,
    width: Option<f64>,
}

/// Runs the filter of JSON lines.
///
/// # Errors
/// Returns an error if the input cannot be read, the output cannot be written, or settings are
/// invalid. An invalid line is reported and skipped; the exit code reflects it.
pub(crate) fn run(args: FitArgs) -> Result<ExitCode> {
    let of_the_chain = ["--calibration", "--plane", "--unit"];
    if of_the_chain.iter().any(|flag| args.flags.has(flag)) {
        wrong_use!(
            "lines of points are fitted as they are: --calibration, --plane and --unit are for the chain and for `lariat trace`"
        );
    }
    let settings = Settings::resolve(&args.flags)?;
    let (name, input) = open(args.file.as_deref())?;
    let mut input = BufReader::new(input);
    let mut output = io::BufWriter::new(io::stdout().lock());
    let mut fitters = Fitters::new(settings);
    let mut exit = ExitCode::SUCCESS;
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let read = input
            .by_ref()
            .take(LONGEST_TEXT + 1)
            .read_until(b'\n', &mut line);
        let read = read.with_context(|| format!("cannot read {name}"))?;
        if read == 0 {
            break;
        }
        if read as u64 > LONGEST_TEXT {
            output.flush().context("cannot write the output")?;
            anyhow::bail!(
                "{name}, line {number}: it is longer than {} MB, and what comes behind it is not read: give each centerline a \
                 line of its own",
                LONGEST_TEXT >> 20
            );
        }
        if line.trim_ascii().is_empty() {
            continue;
        }
        let written = match fitters.answer(&line) {
            Ok(descriptor) => write_line(&mut output, &descriptor),
            Err(why) => {
                exit = ExitCode::FAILURE;
                // Results of earlier lines are written before the bad line is reported.
                let flushed = output.flush();
                eprintln!("lariat: {name}, line {number}: {why}");
                flushed
            }
        };
        // A client may wait for this answer before it sends the next line, so the answer is
        // flushed.
        let flushed = written.and_then(|()| match input.buffer() {
            [] => output.flush(),
            _ => Ok(()),
        });
        if is_closed(flushed)? {
            return Ok(ExitCode::FAILURE);
        }
    }
    match is_closed(output.flush())? {
        true => Ok(ExitCode::FAILURE),
        false => Ok(exit),
    }
}

/// Opens the input and returns its name for messages.
fn open(file: Option<&Path>) -> Result<(String, Box<dyn Read>)> {
    match file {
        Some(path) if path != Path::new("-") => {
            let name = path.display().to_string();
            let file = File::open(path).with_context(|| format!("cannot open {name}"))?;
            Ok((name, Box::new(file)))
        }
        _ => Ok(("standard input".to_owned(), Box::new(io::stdin()))),
    }
}

fn write_line(output: &mut impl Write, descriptor: &Descriptor) -> io::Result<()> {
    serde_json::to_writer(&mut *output, &Versioned::first(descriptor))?;
    output.write_all(b"\n")
}

/// Returns true if the reader of the output is gone. This ends the work as a failure without a
/// message.
pub(crate) fn is_closed(written: io::Result<()>) -> Result<bool> {
    match written {
        Ok(()) => Ok(false),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(true),
        Err(error) => Err(error).context("cannot write the output"),
    }
}

/// Fitters made so far, keyed by number of points, open or closed, with or without weights.
struct Fitters {
    settings: Settings,
    made: HashMap<(usize, bool, bool), Fitter>,
}

impl Fitters {
    fn new(settings: Settings) -> Self {
        Self {
            settings,
            made: HashMap::new(),
        }
    }

    /// Returns the descriptor of one line, or what is wrong with the line.
    fn answer(&mut self, line: &[u8]) -> Result<Descriptor, String> {
        let line: Centerline = serde_json::from_slice(line).map_err(|error| {
            format!(
                "this is not a line {{\"points\":[[x,y],…]}} of finite numbers: {}",
                without_place(&error)
            )
        })?;
        let count = line.points.len();
        if count > MAX_POINTS {
            return Err(format!(
                "{count} points are too many: give at most {MAX_POINTS}, evenly spaced"
            ));
        }
        let closed = line
            .closed
            .unwrap_or(self.settings.fit.basis == Family::Named(lariat_wire::Basis::Fourier));
        if let Some(first) = repeated(&line.points) {
            let [x, y] = line.points[first];
            return Err(format!(
                "points {first} and {} are the same, ({x}, {y}): each stands for an arc length of its own, so \
                 leave one out",
                first + 1
            ));
        }
        let weighted = line.weights.is_some();
        let fitter = match self.made.entry((count, closed, weighted)) {
            std::collections::hash_map::Entry::Occupied(entry) => entry.into_mut(),
            std::collections::hash_map::Entry::Vacant(entry) => {
                let mut options = self.settings.fit.options(count, closed);
                if weighted && options.weights == Weights::Even {
                    options.weights = Weights::Given;
                }
                entry.insert(Fitter::new(options).map_err(|error| error.to_string())?)
            }
        };
        // Without a width, only the limit in pixels applies.
        let width = line.width.unwrap_or(f64::NAN);
        let tolerance = self.settings.fit.tolerance(width, 1.0);
        let points = Line {
            weights: line.weights.as_deref(),
            ..Line::of(&line.points)
        };
        let fitted = fitter
            .least_size(&points, tolerance)
            .and_then(|(size, _)| fitter.fit_at(size, &points).map(Descriptor::of));
        let mut descriptor = fitted.map_err(|error| error.to_string())?;
        if line.width.is_some() {
            let is_good = fitter.lies_on(&points, tolerance);
            descriptor.quality = Some(Quality::of(fitter.last(), is_good, width));
        }
        Ok(descriptor)
    }
}

/// Returns the index of the first point that equals the next one.
fn repeated(points: &[[f64; 2]]) -> Option<usize> {
    points.windows(2).position(|pair| pair[0] == pair[1])
}

/// Message of serde_json with the column but without the line number, since each line is parsed by
/// itself.
fn without_place(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(place) => format!("{} (column {})", &text[..place], error.column()),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_brings_lines_and_the_null_device_does_not() {
        let kind = |path: &str| std::fs::metadata(path).unwrap().file_type();
        assert!(brings_lines(kind("Cargo.toml")));
        assert!(!brings_lines(kind("/dev/null")));
        assert!(!brings_lines(kind("/")));
    }
}
