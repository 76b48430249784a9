//! The measurements behind the figures that lariat claims.
//!
//! | command | what it prints |
//! |---|---|
//! | `cargo bench -p lariat-bench --bench extract` | one extraction, cold and tracked, step by step, beside a pass that only reads the frame: pixel formats, sizes, pictures made to be slow, and (`-- --dataset DIR`) photographs. `-- --quick`: in some seconds |
//! | `cargo bench -p lariat-bench --bench fit` | one fit, beside the bare multiply-adds |
//! | `cargo run --release -p lariat-bench -- accuracy --dataset DIR` | on photographs with labels, for each set: DICE of the ropes drawn from points and widths, wrong counts, what was missed and what strays, where drawing and label disagree and why, time for each step, the worst five. `--csv FILE`: a line for each image. `--overlay DIR`: what was found, drawn over each photograph. Which strand is on top at each crossing is held against what an eye saw (`labels/`, or `--crossings FILE`) |
//! | `cargo run --release -p lariat-bench -- accuracy --rendered` | on drawn ropes with known truth, for each class of picture: wrong counts, distance from the centerline, correspondence along it, ends, widths, connections and order at crossings, the worst five. `--class`, `--seed`, `--seeds`, `--size`: which pictures; `--csv`, `--overlay` as above |
//! | `cargo run --release -p lariat-bench -- rivals` | the same work by OpenCV and scikit-image on the same pictures, one thread each, side by side (`rivals/` says what to install; `--python PATH`): drawn frames, and photographs by `--dataset DIR` or `--images FILE…` |
//! | `cargo run --release -p lariat-bench -- methods` | 120 centers in the mask of a rope by the paper's clusterings, from k-means++ and from the last frame's centers, beside scikit-learn, MiniSom and scikit-fuzzy from the same start (`--python PATH`) |
//! | `cargo run --release -p lariat-bench -- time` | on drawn films of moving ropes with known truth, for each story and seed: ropes missed, wrong counts, directions turned, numbers swapped, strands exchanged. `--story`, `--frames`, `--seeds`, `--first-seed`; `--verbose` frame by frame, `--overlay` as above |
//! | `cargo run --release -p lariat-bench -- readers` | what a look at the newest message costs a control loop in Rust and in C, how long a waiting one sleeps after a message was sent beside bare iceoryx2 in turn, and the chain with no control loop, with 16, and with 16 of which one is stopped and one killed. Builds of the program and of `lariat-c` come first. `--seconds`, `--rounds`, `--readers`, `--fps` |
//!
//! Speed (`benches/`) is printed beside a floor of the same run, so that what counts is the ratio.
//! What the measurements share is here: frames, the floor, medians, tables.

mod elsewhere;
mod films;
mod floor;
mod formats;
mod opencv;
mod photographs;
mod picture;
mod statistics;
mod table;

pub use elsewhere::{MBEST_MS, STEPS_MS};
pub use films::{TrueFrame, rendered};
pub use floor::ReadPass;
pub use formats::converted;
pub use opencv::opencv_bounds;
pub use photographs::{PhotoSet, load, photographs};
pub use picture::Picture;
pub use statistics::Samples;
pub use table::{Table, micros, millis, multiple, times};
