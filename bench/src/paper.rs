//! `lariat paper`: repeats the experiments of arXiv 2312.16502 as one page with figures and as
//! tables of numbers.

use anyhow::Result;
use clap::Args;
use lariat_chain::inputs;
use lariat_chain::output::{Existing, OutputFolder, print};
use lariat_chain::picture::Picture;
use lariat_paper::{Effort, Options, Ropes, repeat};
use lariat_sink::Machine;
use std::io::{IsTerminal, stderr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Repeat the experiments of the paper that lariat is based on, with numbers, as one page
///
/// Writes report.html, which opens without a network and prints well, and the numbers behind each
/// figure as CSV.
#[derive(Debug, Args)]
pub(crate) struct PaperArgs {
    /// Folder for report.html and the CSVs; created if missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Real pictures of ropes, PNG, JPEG, WebP, TIFF, BMP or PGM, or folders of them (default:
    /// ropes that lariat draws, with known centerlines)
    #[arg(long, value_name = "PATH", num_args = 1..)]
    images: Vec<PathBuf>,
    /// Seed of the drawn ropes and noise; the same seed gives the same numbers, apart from times
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Overwrite an existing report
    #[arg(long)]
    force: bool,
    /// Make a first estimate in some seconds: few and small pictures, so the numbers vary by chance
    #[arg(long)]
    quick: bool,
}

/// Runs `lariat paper`.
///
/// # Errors
/// Pictures cannot be read or show no rope, or a folder cannot be written. Nothing is written in
/// these cases.
pub(crate) fn run(args: PaperArgs) -> Result<ExitCode> {
    let files = pictures(&args.images)?;
    // Checked before the work, so that nobody waits in vain.
    let folder = OutputFolder::new(&args.out, Existing::forced(args.force), ["report.html"])?;
    let options = Options {
        seed: args.seed,
        effort: if args.quick {
            Effort::least()
        } else {
            Effort::default()
        },
        machine: Some(machine()),
    };
    let mut pictures = files.iter().map(|file| load(file));
    let ropes = if files.is_empty() {
        Ropes::Drawn
    } else {
        Ropes::Pictured(&mut pictures)
    };
    let mut progress = Progress::new();
    let report = repeat(&options, ropes, &mut |step| progress.show(step));
    progress.end();
    let report = report?;
    for csv in &report.csvs {
        folder.write(csv.name, csv.text.as_bytes())?;
    }
    // Written last, so that a page always has its numbers next to it.
    folder.write("report.html", report.html.as_bytes())?;
    let mut text = report.findings.join("\n\n");
    text.push('\n');
    print(&text)?;
    eprintln!(
        "lariat-bench: the report is {}",
        folder.path().join("report.html").display()
    );
    Ok(ExitCode::SUCCESS)
}

/// Returns the user's pictures. For the folder of a data set, returns those in its `images`.
fn pictures(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        let (mut found, mut wrong) = inputs::pictures(std::slice::from_ref(path));
        let images = path.join("images");
        if !wrong.is_empty() && images.is_dir() {
            (found, wrong) = inputs::pictures(&[images]);
        }
        if let Some(error) = wrong.into_iter().next() {
            return Err(error);
        }
        files.append(&mut found);
    }
    Ok(files)
}

fn load(file: &Path) -> Result<lariat_paper::Picture, String> {
    let picture = Picture::load(file).map_err(|error| format!("{error:#}"))?;
    // Name the file in the extractor's error.
    if let Err(error) = picture.image() {
        return Err(format!("{}: {error}", file.display()));
    }
    let rgb = picture.into_rgb();
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    Ok(lariat_paper::Picture {
        name: name.into_owned(),
        width: rgb.width() as usize,
        height: rgb.height() as usize,
        rgb: rgb.into_raw(),
    })
}

fn machine() -> String {
    let machine = Machine::this();
    let cpu = machine
        .cpu
        .unwrap_or_else(|| "unknown processor".to_owned());
    match machine.cores {
        Some(1) => format!("{cpu}, 1 core"),
        Some(cores) => format!("{cpu}, {cores} cores"),
        None => cpu,
    }
}

/// A line on a terminal that shows the current step. Elsewhere nothing is shown.
struct Progress {
    is_shown: bool,
}

impl Progress {
    fn new() -> Self {
        Self {
            is_shown: stderr().is_terminal(),
        }
    }

    fn show(&mut self, step: &str) {
        if self.is_shown {
            eprint!("\r\x1b[Klariat-bench: {step} …");
        }
    }

    fn end(&mut self) {
        if self.is_shown {
            eprint!("\r\x1b[K");
        }
    }
}
