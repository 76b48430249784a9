//! `lariat-bench`: the measurements behind the figures that lariat claims. The product does not
//! depend on it.
//!
//! `lariat bench`, `compare`, `paper` and `servo` run this program (`latency` is `lariat bench`).
//! Its other commands and its benches:
//!
//! | command | output |
//! |---|---|
//! | `cargo bench --manifest-path bench/Cargo.toml --bench extract` | one extraction, cold and tracked, step by step, next to a pass that only reads the frame: pixel formats, sizes, adversarial pictures, and (`-- --dataset DIR`) photographs. `-- --quick` takes some seconds |
//! | `cargo bench --manifest-path bench/Cargo.toml --bench fit` | one fit, next to the bare multiply-adds |
//! | `lariat-bench accuracy --dataset DIR` | for each set of labeled photographs: DICE of the ropes drawn from points and widths, wrong counts, missed and stray parts, disagreements between drawing and label with their causes, time of each step, and the worst five; also the number of right pictures, of wrong ones without a notice, and of whole ropes, and the reliability of the curves' confidence. `--mask network`: always use the network. `--csv FILE`: a line for each image. `--overlay DIR`: the result drawn over each photograph. The upper strand of each crossing is compared with human judgment (`labels/`, or `--crossings FILE`) |
//! | `lariat-bench backgrounds` | for each class of drawn ropes in difficult light or on a background that is not plain: pictures that are right, silently wrong, or with a false rope; median time; reliability of the curves' confidence. `--mask`, `--class`, `--seed`, `--seeds`; `--list`: the pictures that are not right |
//! | `lariat-bench accuracy --rendered` | for each class of drawn ropes with known truth: wrong counts, distance from the centerline, correspondence along it, ends, widths, connections and order at crossings, and the worst five. `--class`, `--seed`, `--seeds`, `--size`: choice of pictures; `--csv`, `--overlay` as above |
//! | `lariat-bench rivals` | the same work by OpenCV and scikit-image on the same pictures, one thread each, side by side (`rivals/` says what to install; `--python PATH`): drawn frames, and photographs with `--dataset DIR` or `--images FILE…` |
//! | `lariat-bench clusterings` | 120 centers in the mask of a rope by the paper's clusterings, from k-means++ and from the last frame's centers, next to scikit-learn, MiniSom and scikit-fuzzy from the same start (`--python PATH`) |
//! | `lariat-bench recording` | the write speed of raw frames with each compression, next to `dd` with the same block size in the same rounds, both until the data is on disk (`--folder DIR` selects the disk) |
//! | `lariat-bench tracking` | for each story and seed of drawn films of moving ropes with known truth: missed ropes, wrong counts, reversed directions, swapped identities, exchanged strands. `--story`, `--frames`, `--seeds`, `--first-seed`; `--verbose` frame by frame, `--overlay` as above |
//! | `lariat-bench learn-joins` | the weights of joins between strands, fitted to drawn pictures, and how many crossings they resolve. `--tangles`, `--seeds`, `--first-seed` |
//! | `lariat-bench instructions` | nothing: valgrind counts the instructions of its parts (`.ci/gates instructions`) |
//! | `lariat-bench 3d` | for drawn ropes in 3-D in front of a color camera and a depth camera, or two color cameras: distance from the true axis, ends, curves, control points within the stated ellipsoids. `--seeds`, `--only`; `--deform DIR`: ropes that move as in the motion capture of DEFORM, whose pickles are read without executing them, with renamed and reversed tracks (`--frames`, `--width-mm`, `--verbose`, `--overlay`) |
//! | `lariat-bench readers` | the cost of reading the newest message for a control loop in Rust and in C; the time from sending until a waiting loop wakes, in turns with bare iceoryx2; and the chain with no control loop, with 16, and with 16 including a stopped and a killed one. Builds the program and `lariat-c` first. `--seconds`, `--rounds`, `--readers`, `--fps` |
//!
//! In a checkout, `lariat-bench` is `cargo run --release --manifest-path bench/Cargo.toml --`.
//!
//! Speed (`benches/`) is printed next to a floor from the same run, because the ratio is what
//! counts. The measurements share frames, the floor, medians and tables.

#[macro_use]
extern crate lariat_chain;

/// Prints text. Returns an error if the reader of the output is gone, which ends the measurement.
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
mod joins;
mod latency;
mod mask;
mod network;
mod opencv;
pub mod paint;
mod paper;
mod parallel;
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
