//! `lariat paper`: the experiments of arXiv 2312.16502 again, as one page with figures and as tables of numbers.

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

/// The experiments of the paper that lariat is built on, again and with numbers, as one page
///
/// Writes report.html, which opens without a network and prints well, and the numbers behind each figure as CSV.
#[derive(Debug, Args)]
pub(crate) struct PaperArgs {
    /// Folder for report.html and the CSVs; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Real pictures of ropes, PNG, JPEG, WebP, TIFF, BMP or PGM, or folders of them (default: ropes that lariat draws, whose true centerlines
    /// are known)
    #[arg(long, value_name = "PATH", num_args = 1..)]
    images: Vec<PathBuf>,
    /// Which ropes and noises are drawn; the same seed gives the same numbers, but for times
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Overwrite a report that is there already
    #[arg(long)]
    force: bool,
    /// A first look, in some seconds: few and small pictures, so that chance has a part in the numbers
    #[arg(long)]
    quick: bool,
}

/// Runs `lariat paper`.
///
/// # Errors
/// Pictures that cannot be read or show no rope, a folder that cannot be written. Nothing is written then.
pub(crate) fn run(args: PaperArgs) -> Result<ExitCode> {
    let files = pictures(&args.images)?;
    // Before the work, so that nobody waits for it in vain.
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
    // Last, so that a page has its numbers beside it.
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

/// The pictures that the user named; of a data set's folder those in its `images`.
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
    // What the extractor does not take is said with the file's name.
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

/// One line on a terminal that says what is being done, and nothing elsewhere.
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
