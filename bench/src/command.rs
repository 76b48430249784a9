//! The command line of `lariat-bench`.

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use lariat_chain::{exit, output::Unread};

use crate::{
    accuracy, backgrounds, bases, clusterings, compare, confidence, fit_rivals, instructions,
    latency, network, paper, readers, recording, rivals, servo, soak, three_d, tracking,
};

/// The measurements behind the figures that lariat claims (those of single steps are run by `cargo bench`)
#[derive(Parser)]
#[command(name = "lariat-bench", version, after_help = exit::CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// End-to-end latency on this machine, with its lower bounds and with other systems: `lariat bench`
    Latency(latency::BenchArgs),
    /// A program that `latency` starts
    #[command(hide = true)]
    LatencyPart(latency::PartArgs),
    /// Changes from one summary.json to another that exceed the noise
    Compare(compare::CompareArgs),
    /// The experiments of the paper that lariat is built on, repeated and with numbers, as one page
    Paper(paper::PaperArgs),
    /// Drives a simulated rope to a shape through the whole chain, and measures how well
    Servo(servo::ServoArgs),
    /// The controller that `servo` starts
    #[command(hide = true)]
    Controller(Box<servo::ControllerArgs>),
    /// Distance of the extracted curves from the truth
    Accuracy(accuracy::Args),
    /// Ropes lost, reversed or exchanged over many frames of moving ropes
    #[command(alias = "time")]
    Tracking(tracking::Args),
    /// Share of right pictures on grounds and under light that a plain table does not have
    #[command(name = "backgrounds", alias = "hard")]
    Backgrounds(backgrounds::Args),
    /// One part at a time, for valgrind to count its instructions
    Instructions(instructions::Args),
    /// Ropes in space by a drawn depth camera, against the true axis
    #[command(name = "3d", alias = "space")]
    ThreeD(three_d::Args),
    /// Time of each layer of the mask network, with the machine's limit and ONNX Runtime
    Network(network::Args),
    /// Fits the weights of a curve's confidence to drawn pictures, and tests them on others
    CalibrateConfidence(confidence::Args),
    /// The chain with each basis and option: its curves against the true rope
    Bases(bases::Args),
    /// A day of frames by a simulated clock: the cost of the last hour against that of the first
    Soak(soak::Args),
    /// The same work by OpenCV and scikit-image, side by side with lariat's
    Rivals(rivals::Args),
    /// The same curve by NumPy, SciPy and geomdl, side by side with lariat's
    FitRivals(fit_rivals::Args),
    /// Centers by the paper's four clusterings, side by side with scikit-learn's, MiniSom's and scikit-fuzzy's
    Clusterings(clusterings::Args),
    /// Speed of writing recordings, compared with dd
    Recording(recording::Args),
    /// Cost of reading for a control loop, and of control loops for the chain
    Readers(readers::Args),
    /// A program that `readers` starts
    #[command(hide = true)]
    ReadersPart(readers::PartArgs),
}

/// Runs the command line, and reports an error on standard error.
pub fn run() -> ExitCode {
    Cli::parse().command.run().unwrap_or_else(|error| {
        if Unread::is_cause_of(&error) {
            return ExitCode::FAILURE;
        }
        eprintln!("lariat-bench: {error:#}");
        exit::code(&error)
    })
}

impl Command {
    fn run(self) -> Result<ExitCode> {
        match self {
            Self::Latency(args) => return latency::run(&args),
            Self::LatencyPart(args) => return latency::run_part(&args),
            Self::Compare(args) => return compare::run(&args),
            Self::Paper(args) => return paper::run(args),
            Self::Servo(args) => return servo::run(&args),
            Self::Controller(args) => return servo::run_controller(&args),
            Self::Accuracy(args) => accuracy::run(&args)?,
            Self::Tracking(args) => tracking::run(&args)?,
            Self::Backgrounds(args) => backgrounds::run(&args)?,
            Self::Instructions(args) => instructions::run(&args)?,
            Self::ThreeD(args) => three_d::run(&args)?,
            Self::Network(args) => network::run(&args)?,
            Self::CalibrateConfidence(args) => confidence::run(&args)?,
            Self::Bases(args) => bases::run(&args)?,
            Self::Soak(args) => soak::run(&args)?,
            Self::Rivals(args) => rivals::run(&args)?,
            Self::FitRivals(args) => fit_rivals::run(&args)?,
            Self::Clusterings(args) => clusterings::run(&args)?,
            Self::Recording(args) => recording::run(&args)?,
            Self::Readers(args) => readers::run(&args)?,
            Self::ReadersPart(args) => readers::part(&args)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// A picture's size, as in `640x480`.
pub(crate) fn size(text: &str) -> Result<[usize; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| {
        let [width, height] = [width, height].map(str::parse::<usize>);
        Some([width.ok()?, height.ok()?])
    });
    let sides = sides.filter(|sides| !sides.contains(&0));
    sides.ok_or_else(|| format!("'{text}' is not a size: write it as 640x480"))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use clap::error::ErrorKind;
    use lariat_test_support::documents;

    use super::Cli;

    #[test]
    fn every_measurement_in_the_documents_is_understood() {
        let mut count = 0;
        for documents::Command { text, mut words } in documents::commands() {
            match [&words[0][..], words.get(1).map_or("", |word| word)] {
                ["lariat-bench", _] => {}
                ["lariat", "bench"] => words[1] = "latency".to_owned(),
                ["lariat", "compare" | "paper" | "servo"] => {}
                _ => continue,
            }
            count += 1;
            let parsed = Cli::command().try_get_matches_from(words);
            // A command may be mentioned without what it takes.
            let mentioned = [
                ErrorKind::MissingRequiredArgument,
                ErrorKind::MissingSubcommand,
                ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand,
            ];
            if let Some(error) = parsed.err().filter(|e| !mentioned.contains(&e.kind())) {
                panic!("{text}: {error}");
            }
        }
        assert!(count > 10, "the documents have {count} measurements only");
    }

    #[test]
    fn no_flag_is_defined_twice() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_size_has_two_sides() {
        assert_eq!(super::size("640x480"), Ok([640, 480]));
        for wrong in ["0x480", "640x0", "640", "640x", "640x480x3", "-1x2"] {
            assert!(super::size(wrong).is_err(), "{wrong}");
        }
    }
}
