//! The measurements behind the figures that lariat claims.
//!
//! | command | what it prints |
//! |---|---|
//! | `cargo bench -p lariat-bench --bench fit` | one fit, beside the bare multiply-adds |
//! | `cargo run --release -p lariat-bench -- accuracy --dataset DIR` | on photographs with labels, for each set: DICE of the ropes drawn from points and widths, wrong counts, what was missed and what strays, where drawing and label disagree and why, time for each step, the worst five. `--csv FILE`: a line for each image. `--overlay DIR`: what was found, drawn over each photograph. Which strand is on top at each crossing is held against what an eye saw (`labels/`, or `--crossings FILE`) |
//! | `cargo run --release -p lariat-bench -- accuracy --rendered` | on drawn ropes with known truth, for each class of picture: wrong counts, distance from the centerline, correspondence along it, ends, widths, connections and order at crossings, the worst five. `--class`, `--seed`, `--seeds`, `--size`: which pictures; `--csv`, `--overlay` as above |
//! | `cargo run --release -p lariat-bench -- time` | on drawn films of moving ropes with known truth, for each story and seed: ropes missed, wrong counts, directions turned, numbers swapped, strands exchanged. `--story`, `--frames`, `--seeds`, `--first-seed`; `--verbose` frame by frame, `--overlay` as above |
//!
//! Speed (`benches/`) is printed beside a floor of the same run, so that what counts is the ratio.
