//! `lariat-bench`: the measurements behind the figures that lariat claims. The product does not depend on it.
//!
//! `lariat bench`, `compare`, `paper` and `servo` run this program (`latency` is `lariat bench`). Its other commands and its benches:
//!
//! | command | what it prints |
//! |---|---|
//! | `cargo bench --manifest-path bench/Cargo.toml --bench extract` | one extraction, cold and tracked, step by step, beside a pass that only reads the frame: pixel formats, sizes, pictures made to be slow, and (`-- --dataset DIR`) photographs. `-- --quick`: in some seconds |
//! | `cargo bench --manifest-path bench/Cargo.toml --bench fit` | one fit, beside the bare multiply-adds |
//! | `lariat-bench accuracy --dataset DIR` | on photographs with labels, for each set: DICE of the ropes drawn from points and widths, wrong counts, what was missed and what strays, where drawing and label disagree and why, time for each step, the worst five; how many pictures are right, and wrong without a notice, how many ropes whole, and how true the curves' confidence is. `--mask network`: as the network alone finds ropes. `--csv FILE`: a line for each image. `--overlay DIR`: what was found, drawn over each photograph. Which strand is on top at each crossing is held against what an eye saw (`labels/`, or `--crossings FILE`) |
//! | `lariat-bench backgrounds` | on drawn ropes under hard light and on grounds that are not plain, for each class: pictures right, wrong without a word, with a false rope, median time; how true the curves' confidence is. `--mask`, `--class`, `--seed`, `--seeds`; `--list`: what is wrong |
//! | `lariat-bench accuracy --rendered` | on drawn ropes with known truth, for each class of picture: wrong counts, distance from the centerline, correspondence along it, ends, widths, connections and order at crossings, the worst five. `--class`, `--seed`, `--seeds`, `--size`: which pictures; `--csv`, `--overlay` as above |
//! | `lariat-bench rivals` | the same work by OpenCV and scikit-image on the same pictures, one thread each, side by side (`rivals/` says what to install; `--python PATH`): drawn frames, and photographs by `--dataset DIR` or `--images FILE…` |
//! | `lariat-bench clusterings` | 120 centers in the mask of a rope by the paper's clusterings, from k-means++ and from the last frame's centers, beside scikit-learn, MiniSom and scikit-fuzzy from the same start (`--python PATH`) |
//! | `lariat-bench recording` | how fast raw frames are recorded with each compression, beside `dd` with the same block size, in the same rounds, both until the disk has it (`--folder DIR`: on which disk) |
//! | `lariat-bench tracking` | on drawn films of moving ropes with known truth, for each story and seed: ropes missed, wrong counts, directions turned, numbers swapped, strands exchanged. `--story`, `--frames`, `--seeds`, `--first-seed`; `--verbose` frame by frame, `--overlay` as above |
//! | `lariat-bench instructions` | nothing: valgrind counts the instructions of its parts (`.ci/gates instructions`) |
//! | `lariat-bench 3d` | drawn ropes in space before a colour camera and a depth camera, or a second colour camera: distance from the true axis, ends, curves, control points within the stated ellipsoids. `--seeds`, `--only`; `--deform DIR`: ropes as the motion capture of DEFORM saw them move, its pickles read without running them, with renamed and turned tracks (`--frames`, `--width-mm`, `--verbose`, `--overlay`) |
//! | `lariat-bench readers` | what a look at the newest message costs a control loop in Rust and in C, how long a waiting one sleeps after a message was sent beside bare iceoryx2 in turn, and the chain with no control loop, with 16, and with 16 of which one is stopped and one killed. Builds of the program and of `lariat-c` come first. `--seconds`, `--rounds`, `--readers`, `--fps` |
//!
//! In a checkout `lariat-bench` is `cargo run --release --manifest-path bench/Cargo.toml --`.
//!
//! Speed (`benches/`) is printed beside a floor of the same run, so that what counts is the ratio.
//! The measurements share frames, the floor, medians and tables.

#[macro_use]
extern crate lariat_chain;

/// Prints, and returns an error where nobody reads any more, which ends the measurement.
macro_rules! print {
    ($($text:tt)*) => {
        lariat_chain::output::print(&format!($($text)*))
    };
}

/// Prints a line as `print` does.
macro_rules! println {
    ($($text:tt)*) => {
        lariat_chain::output::print(&(format!($($text)*) + "\n"))
    };
}

mod accuracy;
mod backgrounds;
mod bare;
mod bases;
mod clusterings;
mod command;
mod compare;
mod confidence;
mod enlarged;
mod films;
mod fit_rivals;
mod floor;
mod formats;
mod instructions;
mod latency;
mod mask;
mod network;
mod opencv;
pub mod paint;
mod paper;
mod photographs;
mod picture;
mod program;
mod published;
mod python;
mod readers;
mod recording;
mod reliability;
mod right;
mod rivals;
mod servo;
mod soak;
mod statistics;
mod table;
mod three_d;
mod tracking;

pub use bare::{RelayMessage, RelayReceiver, RelaySender};
pub use command::run;
pub use films::{TrueFrame, rendered};
pub use floor::ReadPass;
pub use formats::converted;
pub use opencv::opencv_bounds;
pub use photographs::{PhotoSet, load, photographs};
pub use picture::Picture;
pub use published::{MBEST_MS, STEPS_MS};
pub use statistics::Samples;
pub use table::{Table, micros, millis, multiple, times};
