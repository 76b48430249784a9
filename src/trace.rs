//! `lariat trace`: finds the shapes of the ropes in pictures, with the chain's own pipeline but
//! without shared memory.

mod frames;
mod masks;
mod overlay;
mod report;
mod tracer;

use crate::fit_lines::is_closed;
use crate::trace::frames::Input;
use crate::trace::overlay::Overlays;
use crate::trace::report::{Report, Table};
use crate::trace::tracer::Tracer;
use anyhow::Result;
use clap::Args;
use lariat_chain::exit::wrong_use;
use lariat_chain::inputs;
use lariat_chain::layout;
use lariat_chain::output::Existing;
use lariat_chain::settings::{Flags, Settings};
use lariat_wire::Unit;
use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Find the ropes in pictures and fit curves to them
#[derive(Debug, Args)]
pub(crate) struct TraceArgs {
    /// Pictures, folders of them, Y4M videos, recordings, or `-`: a Y4M video or raw frames on standard input
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// Print a JSON object for each picture, one per line
    #[arg(long)]
    json: bool,
    /// Write a PNG of each picture with curve, points and control polygon drawn over it into this folder
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// Overwrite existing overlays
    #[arg(long)]
    force: bool,
    /// Treat the pictures as one moving scene: ropes keep their number and direction
    #[arg(long)]
    video: bool,
    /// Folder of masks: one per picture, with the same name, white for rope
    #[arg(long, value_name = "DIR")]
    masks: Option<PathBuf>,
    #[command(flatten)]
    flags: Flags,
}

/// Flags that apply only to sources of frames.
const OF_FRAMES: [&str; 6] = [
    "--from",
    "--to",
    "--every",
    "--topic",
    "--size",
    "--pixel-format",
];

/// Runs `lariat trace`.
///
/// # Errors
/// Returns an error if settings are invalid or the output cannot be written. A picture that cannot
/// be read is reported and skipped; the exit code reflects it.
pub(crate) fn run(args: TraceArgs) -> Result<ExitCode> {
    let settings = Settings::resolve(&args.flags.without(&OF_FRAMES))?;
    let tracer = Tracer::new(&settings, args.masks.as_deref())?;
    let mut complaints = Complaints(ExitCode::SUCCESS);
    let (images, missing) = inputs::pictures(&args.images);
    missing.into_iter().for_each(|why| complaints.say(why));
    if let Some(flag) = OF_FRAMES.into_iter().find(|flag| args.flags.has(flag))
        && !images.iter().any(|image| frames::names_frames(image))
    {
        wrong_use!(
            "{flag} is for videos, recordings and standard input, and there are only pictures"
        );
    }
    let mut work = Work {
        overlays: overlays(&args, &images, &tracer)?,
        printer: Printer::new(args.json, &images, tracer.unit()),
        tracer,
        complaints,
    };
    for image in &images {
        match Input::open(image, &args) {
            Ok(input) => {
                if work.trace(input, args.video)?.is_break() {
                    break;
                }
            }
            Err(why) => work.complaints.say(why),
        }
    }
    Ok(work.complaints.0)
}

/// Prepares the overlays, if requested. They may not replace any of the pictures and masks.
fn overlays(args: &TraceArgs, images: &[PathBuf], tracer: &Tracer) -> Result<Option<Overlays>> {
    let Some(folder) = &args.overlay else {
        return Ok(None);
    };
    let masks = images.iter().filter_map(|image| tracer.mask_of(image));
    let inputs = images.iter().cloned().chain(masks).collect();
    Overlays::new(folder, images, inputs, Existing::forced(args.force)).map(Some)
}

/// Exit code that reflects all errors; each error is reported when it occurs.
struct Complaints(ExitCode);

impl Complaints {
    fn say(&mut self, why: anyhow::Error) {
        eprintln!("lariat: {why:#}");
        self.0 = ExitCode::FAILURE;
    }
}

/// The tracer and its outputs.
struct Work {
    tracer: Tracer,
    printer: Printer,
    overlays: Option<Overlays>,
    complaints: Complaints,
}

impl Work {
    /// Traces all pictures of an input. Stops when nobody reads the output any more.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written.
    fn trace(&mut self, mut input: Input, is_video: bool) -> Result<ControlFlow<()>> {
        self.tracer.begin(&mut input, is_video);
        loop {
            let begin = Instant::now();
            let traced = match input.next(&mut |why| self.complaints.say(why)) {
                Ok(None) => break,
                Ok(Some(shown)) => (self.tracer)
                    .trace(&shown, begin)
                    .map(|report| (shown, report)),
                Err(why) => Err(why),
            };
            let (shown, report) = match traced {
                Ok(traced) => traced,
                Err(why) => {
                    self.complaints.say(why);
                    break;
                }
            };
            // Overlays are drawn even if nobody reads the output.
            if self.printer.is_closed_after(&report)? {
                self.complaints.0 = ExitCode::FAILURE;
                if self.overlays.is_none() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            if let Some(overlays) = &mut self.overlays
                && let Err(why) = overlays.write(shown, &report, self.tracer.mapping())
            {
                self.complaints.say(why);
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}

/// Format and destination of the output.
struct Printer {
    json: bool,
    table: Table,
    output: io::BufWriter<io::StdoutLock<'static>>,
}

impl Printer {
    fn new(json: bool, images: &[PathBuf], unit: Unit) -> Self {
        // A frame's name ends with its number.
        let names = images
            .iter()
            .map(|image| match frames::names_frames(image) {
                true => image.join("12345"),
                false => image.clone(),
            });
        let names: Vec<PathBuf> = names.collect();
        Self {
            json,
            table: Table::new(
                &names,
                unit.name(),
                layout::has_colours(io::stdout().is_terminal()),
            ),
            output: io::BufWriter::new(io::stdout().lock()),
        }
    }

    /// Prints a report and flushes it before the next picture. Returns true if nobody reads the
    /// output any more.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written.
    fn is_closed_after(&mut self, report: &Report) -> Result<bool> {
        let printed = match self.json {
            true => report.write_json(&mut self.output),
            false => self.table.write(report, &mut self.output),
        };
        for notice in &report.notices {
            eprintln!("lariat: {}: {}", report.image, notice.text);
        }
        is_closed(printed.and_then(|()| self.output.flush()))
    }
}
