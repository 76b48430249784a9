//! The laboratory: the evidence for what lariat claims. The chain knows nothing of it.
//!
//! What users type is [`Command`]: `lariat bench`, `compare`, `paper`, `servo`. The rest is measured by programs of this crate:
//!
//! | command | what it prints |
//! |---|---|
//! | `cargo bench -p lariat-lab --bench extract` | one extraction, cold and tracked, step by step, beside a pass that only reads the frame: pixel formats, sizes, pictures made to be slow, and (`-- --dataset DIR`) photographs. `-- --quick`: in some seconds |
//! | `cargo bench -p lariat-lab --bench fit` | one fit, beside the bare multiply-adds |
//! | `cargo run --release -p lariat-lab -- accuracy --dataset DIR` | on photographs with labels, for each set: DICE of the ropes drawn from points and widths, wrong counts, what was missed and what strays, where drawing and label disagree and why, time for each step, the worst five; how many pictures are right, and wrong without a notice, how many ropes whole, and how true the curves' confidence is. `--mask network`: as the network alone finds ropes. `--csv FILE`: a line for each image. `--overlay DIR`: what was found, drawn over each photograph. Which strand is on top at each crossing is held against what an eye saw (`labels/`, or `--crossings FILE`) |
//! | `cargo run --release -p lariat-lab -- hard` | on drawn ropes under hard light and on grounds that are not plain, for each class: pictures right, wrong without a word, with a false rope, median time; how true the curves' confidence is. `--mask`, `--class`, `--seed`, `--seeds`; `--list`: what is wrong |
//! | `cargo run --release -p lariat-lab -- accuracy --rendered` | on drawn ropes with known truth, for each class of picture: wrong counts, distance from the centerline, correspondence along it, ends, widths, connections and order at crossings, the worst five. `--class`, `--seed`, `--seeds`, `--size`: which pictures; `--csv`, `--overlay` as above |
//! | `cargo run --release -p lariat-lab -- rivals` | the same work by OpenCV and scikit-image on the same pictures, one thread each, side by side (`rivals/` says what to install; `--python PATH`): drawn frames, and photographs by `--dataset DIR` or `--images FILE…` |
//! | `cargo run --release -p lariat-lab -- methods` | 120 centers in the mask of a rope by the paper's clusterings, from k-means++ and from the last frame's centers, beside scikit-learn, MiniSom and scikit-fuzzy from the same start (`--python PATH`) |
//! | `cargo run --release -p lariat-lab -- recording` | how fast raw frames are recorded with each compression, beside `dd` with the same block size, in the same rounds, both until the disk has it (`--folder DIR`: on which disk) |
//! | `cargo run --release -p lariat-lab -- time` | on drawn films of moving ropes with known truth, for each story and seed: ropes missed, wrong counts, directions turned, numbers swapped, strands exchanged. `--story`, `--frames`, `--seeds`, `--first-seed`; `--verbose` frame by frame, `--overlay` as above |
//! | `cargo run --release -p lariat-lab --bin lariat-bench -- space` | drawn ropes in space before a colour camera and a depth camera, or a second colour camera: distance from the true axis, ends, curves, control points within the stated ellipsoids. `--seeds`, `--only`; `--deform DIR`: ropes as the motion capture of DEFORM saw them move, its pickles read without running them, with renamed and turned tracks (`--frames`, `--width-mm`, `--verbose`, `--overlay`) |
//! | `cargo run --release -p lariat-lab -- readers` | what a look at the newest message costs a control loop in Rust and in C, how long a waiting one sleeps after a message was sent beside bare iceoryx2 in turn, and the chain with no control loop, with 16, and with 16 of which one is stopped and one killed. Builds of the program and of `lariat-c` come first. `--seconds`, `--rounds`, `--readers`, `--fps` |
//!
//! Speed (`benches/`) is printed beside a floor of the same run, so that what counts is the ratio.
//! What the measurements share is here: frames, the floor, medians, tables.

#[macro_use]
extern crate lariat_chain;

mod bare;
mod bench;
mod compare;
mod elsewhere;
mod films;
mod floor;
mod formats;
mod opencv;
mod paper;
mod photographs;
mod picture;
mod servo;
mod statistics;
mod table;

use anyhow::Result;
use clap::Subcommand;
use std::process::ExitCode;

pub use bare::{RelayMessage, RelayReceiver, RelaySender};
pub use elsewhere::{MBEST_MS, STEPS_MS};
pub use films::{TrueFrame, rendered};
pub use floor::ReadPass;
pub use formats::converted;
pub use opencv::opencv_bounds;
pub use photographs::{PhotoSet, load, photographs};
pub use picture::Picture;
pub use statistics::Samples;
pub use table::{Table, micros, millis, multiple, times};

/// What the laboratory adds to the commands of `lariat`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// The experiments of the paper that lariat is built on, again and with numbers, as one page
    Paper(paper::PaperArgs),
    /// A simulated rope driven to a shape through the whole chain, and what that depends on
    Servo(servo::ServoArgs),
    /// The controller that `servo` starts
    #[command(hide = true)]
    Controller(Box<servo::ControllerArgs>),
    /// How long a frame is under way on this machine, beside its floors and beside others
    Bench(bench::BenchArgs),
    /// What got better or worse from one summary.json to another
    Compare(compare::CompareArgs),
    /// A program that `bench` starts
    #[command(hide = true)]
    BenchPart(bench::PartArgs),
}

impl Command {
    /// Does what was asked.
    ///
    /// # Errors
    /// A sentence on what is wrong and what to do.
    pub fn run(self) -> Result<ExitCode> {
        match self {
            Self::Paper(args) => paper::run(args),
            Self::Servo(args) => servo::run(&args),
            Self::Controller(args) => servo::run_controller(&args),
            Self::Bench(args) => bench::run(&args),
            Self::Compare(args) => compare::run(&args),
            Self::BenchPart(args) => bench::run_part(&args),
        }
    }
}
