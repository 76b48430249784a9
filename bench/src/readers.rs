//! `lariat-bench readers`: the cost of reading for a control loop, next to a floor from the same
//! run, and the cost of control loops for the chain.

mod counts;
mod crowd;
mod latest;
mod part;
mod wake;

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result};
use lariat_wire::{Domain, Reader, Rig};

pub(crate) use part::{PartArgs, part};

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Length of each measurement in seconds
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    seconds: f64,
    /// Number of measurements of each kind, taken in turn
    #[arg(long, value_name = "N", default_value_t = 3)]
    rounds: usize,
    /// Number of control loops next to the chain, at least two
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u16).range(2..=23))]
    readers: u16,
    /// Frames per second of that chain
    #[arg(long, value_name = "HZ", default_value_t = 120.0)]
    fps: f64,
}

/// Measures and prints three tables.
///
/// # Errors
/// A process cannot be started, or the transport fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    let place = Place::new()?;
    let time = Duration::from_secs_f64(args.seconds);
    println!("{}", latest::measure(&place, time)?)?;
    println!("{}", wake::measure(&place, time, args.rounds)?)?;
    print!("{}", crowd::measure(&place, args)?)?;
    Ok(())
}

/// A domain of its own, and a folder for temporary files.
struct Place {
    domain: String,
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Result<Self> {
        Ok(Self {
            domain: format!("rb{}", std::process::id()),
            folder: tempfile::tempdir().context("cannot make a temporary folder")?,
        })
    }

    fn reader(&self) -> Result<Reader> {
        Ok(Reader::open_in(
            Domain::named(&self.domain)?,
            &Rig::default(),
        )?)
    }

    /// Starts this program again as another process with a part in the measurement.
    fn start(&self, arguments: &[&str]) -> Result<Part> {
        let this = std::env::current_exe().context("this program has no file")?;
        let process = Command::new(this)
            .arg("readers-part")
            .args(arguments)
            .env("LARIAT_DOMAIN", &self.domain)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("this program cannot be started again")?;
        Ok(Part { process })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{}", self.domain));
    }
}

/// Another process of this program. It ends when its standard input does, and so always ends with
/// this one.
struct Part {
    process: Child,
}

impl Part {
    /// Ends the process and returns its output.
    fn end(mut self) -> Result<String> {
        drop(self.process.stdin.take());
        let mut said = String::new();
        if let Some(mut stdout) = self.process.stdout.take() {
            std::io::Read::read_to_string(&mut stdout, &mut said)?;
        }
        self.process.wait()?;
        Ok(said)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        drop(self.process.stdin.take());
        // A stopped process would not notice the end of its input.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
