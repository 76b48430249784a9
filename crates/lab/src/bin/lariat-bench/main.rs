//! How right lariat's centerlines are, measured on pictures, and how fast its rivals are on them.

/// Prints, at once. What stands against it is to be passed on: where nobody reads any more, the measurement ends.
macro_rules! print {
    ($($text:tt)*) => {
        lariat_chain::output::print(&format!($($text)*))
    };
}

/// Likewise, and the line's end.
macro_rules! println {
    ($($text:tt)*) => {
        lariat_chain::output::print(&(format!($($text)*) + "\n"))
    };
}

mod accuracy;
mod confidence;
mod day;
mod families;
mod fit_rivals;
mod hard;
mod mask;
mod methods;
mod network;
mod python;
mod readers;
mod recording;
mod reliability;
mod right;
mod rivals;
mod space;
mod time;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use lariat_chain::output::Unread;

/// The measurements behind the figures that lariat claims (those of speed are run by `cargo bench`)
#[derive(Parser)]
#[command(name = "lariat-bench", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// How close the extractor's curves are to the truth
    Accuracy(accuracy::Args),
    /// How many pictures are right whose ropes are not just what differs from the table, and what is said of the others
    Hard(hard::Args),
    /// The weights of a curve's confidence, fitted to drawn pictures, and how true it is on others
    CalibrateConfidence(confidence::Args),
    /// The same work by OpenCV and scikit-image, side by side with lariat's
    Rivals(rivals::Args),
    /// The same curve by NumPy, SciPy and geomdl, side by side with lariat's
    FitRivals(fit_rivals::Args),
    /// Centers by the paper's four clusterings, side by side with scikit-learn's, MiniSom's and scikit-fuzzy's
    Methods(methods::Args),
    /// The mask network layer by layer, beside the machine's limit and ONNX Runtime
    Network(network::Args),
    /// The chain with each basis and option: its curves against the true rope
    Families(families::Args),
    /// A day of frames with the clock turned on by hand: whether the last hour costs what the first did
    Day(day::Args),
    /// How fast recordings are written, beside dd
    Recording(recording::Args),
    /// Ropes in space by a drawn depth camera, against the true axis
    Space(space::Args),
    /// What is lost, flipped or exchanged over many frames of moving ropes
    Time(time::Args),
    /// What reading costs a control loop, and what control loops cost the chain
    Readers(readers::Args),
    #[command(hide = true)]
    ReadersPart(readers::PartArgs),
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Accuracy(args) => accuracy::run(&args),
        Command::Hard(args) => hard::run(&args),
        Command::CalibrateConfidence(args) => confidence::run(&args),
        Command::Rivals(args) => rivals::run(&args),
        Command::FitRivals(args) => fit_rivals::run(&args),
        Command::Methods(args) => methods::run(&args),
        Command::Network(args) => network::run(&args),
        Command::Families(args) => families::run(&args),
        Command::Day(args) => day::run(&args),
        Command::Recording(args) => recording::run(&args),
        Command::Space(args) => space::run(&args),
        Command::Time(args) => time::run(&args),
        Command::Readers(args) => readers::run(&args),
        Command::ReadersPart(args) => readers::part(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if Unread::is_cause_of(&error) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("lariat-bench: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// A picture's size, as in `640x480`.
fn size(text: &str) -> Result<[usize; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| {
        let [width, height] = [width, height].map(str::parse::<usize>);
        Some([width.ok()?, height.ok()?])
    });
    let sides = sides.filter(|sides| !sides.contains(&0));
    sides.ok_or_else(|| format!("'{text}' is no size: write it as 640x480"))
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_size_has_two_sides() {
        assert_eq!(super::size("640x480"), Ok([640, 480]));
        for wrong in ["0x480", "640x0", "640", "640x", "640x480x3", "-1x2"] {
            assert!(super::size(wrong).is_err(), "{wrong}");
        }
    }
}
