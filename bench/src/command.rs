//! The command line of `lariat-bench`.

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use lariat_chain::{exit, output::Unread};

use crate::{
    accuracy, backgrounds, bases, clusterings, compare, confidence, fit_rivals, instructions,
    joins, latency, network, paper, readers, recording, rivals, servo, soak, three_d, tracking,
};

/// Measure the figures that lariat claims (`cargo bench` measures single steps)
#[derive(Parser)]
#[command(name = "lariat-bench", version, after_help = exit::CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure end-to-end latency on this machine, with its lower bounds and other systems:
    /// `lariat bench`
    Latency(latency::BenchArgs),
    /// Program that `latency` starts
    #[command(hide = true)]
    LatencyPart(latency::PartArgs),
    /// Compare two summary.json files and show changes that exceed the noise
    Compare(compare::CompareArgs),
    /// Repeat the experiments of the paper that lariat is based on, with numbers, as one page
    Paper(paper::PaperArgs),
    /// Drive a simulated rope to a shape through the whole chain, and measure the result
    Servo(servo::ServoArgs),
    /// Controller that `servo` starts
    #[command(hide = true)]
    Controller(Box<servo::ControllerArgs>),
    /// Measure the distance of the extracted curves from the ground truth
    Accuracy(accuracy::Args),
    /// Count ropes that are lost, reversed or exchanged over many frames of moving ropes
    #[command(alias = "time")]
    Tracking(tracking::Args),
    /// Measure the share of right pictures on difficult backgrounds and in difficult light
    #[command(name = "backgrounds", alias = "hard")]
    Backgrounds(backgrounds::Args),
    /// Run one part at a time, for valgrind to count its instructions
    Instructions(instructions::Args),
    /// Measure ropes in 3-D, seen by a simulated depth camera, against the true axis
    #[command(name = "3d", alias = "space")]
    ThreeD(three_d::Args),
    /// Measure the time of each layer of the mask network, with the machine's limit and ONNX
    /// Runtime
    Network(network::Args),
    /// Fit the weights of a curve's confidence to drawn pictures, and test them on others
    CalibrateConfidence(confidence::Args),
    /// Fit the weights of joins between strands to drawn pictures
    LearnJoins(joins::Args),
    /// Run the chain with each basis and option, and compare its curves with the true rope
    Bases(bases::Args),
    /// Process a day of frames by a simulated clock, and compare the cost of its hours
    Soak(soak::Args),
    /// Do the same work with OpenCV and scikit-image, and show it next to lariat's
    Rivals(rivals::Args),
    /// Fit the same curve with NumPy, SciPy and geomdl, and show it next to lariat's
    FitRivals(fit_rivals::Args),
    /// Compute the paper's four clusterings, and compare them with scikit-learn, MiniSom and
    /// scikit-fuzzy
    Clusterings(clusterings::Args),
    /// Measure the write speed of recordings, compared with dd
    Recording(recording::Args),
    /// Measure the cost of reading for a control loop, and the cost of control loops for the chain
    Readers(readers::Args),
    /// Program that `readers` starts
    #[command(hide = true)]
    ReadersPart(readers::PartArgs),
}

/// Runs the command line and prints errors to standard error.
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
            Self::LearnJoins(args) => joins::run(&args)?,
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

/// Parses a picture's size, such as `640x480`.
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
            // Text may mention a command without its arguments.
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
