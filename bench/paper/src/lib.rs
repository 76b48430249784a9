//! The experiments of F. Chen, *Bezier-based Regression Feature Descriptor for Deformable Linear
//! Objects* (arXiv 2312.16502), repeated with numbers where the paper has pictures, and extended.
//!
//! [`repeat`] draws ropes with known centerlines, or takes [`Picture`]s of others. It runs the
//! extractor on them and fits the ropes that it finds. It returns a [`Report`]: one HTML page with
//! embedded figures, and the numbers behind each figure as CSV. It writes no files, and its only
//! external input is the clock. The same seed gives the same numbers, apart from measured times.
//!
//! ```
//! use lariat_paper::{Effort, Options, Ropes, repeat};
//!
//! let options = Options { effort: Effort::least(), ..Options::default() };
//! let report = repeat(&options, Ropes::Drawn, &mut |_| {})?;
//! assert!(report.html.contains("Figure 3"));
//! assert!(report.csvs.iter().any(|csv| csv.name == "figure-3-orders.csv"));
//! # Ok::<(), lariat_paper::PaperError>(())
//! ```
//!
//! # How it works
//!
//! `lariat paper` runs this crate, `bench/paper`. `docs/paper.md` maps each equation and claim of
//! the paper to the code.
//!
//! Each experiment is one module (`clusterings`, `fits`, `orders`, `robustness/`, `cost`, `rivals`,
//! `conditioning`, `ordering`, `at_rest`). It first computes plain numbers. From these alone it
//! makes its figure, its CSV and the sentences of its caption, so a caption cannot contradict the
//! numbers. Tests supply numbers for both outcomes.
//!
//! - `shapes` holds the ropes that all experiments share, drawn or seen in pictures.
//! - `family` holds the families of curves, to be compared at an equal number of parameters.
//! - `bench/plot` is the style of all charts (colors, dashes, markers, legends above the plot) and
//!   of the page (HTML without scripts or external resources).
//! - `overlay` draws curves over a picture.
//!
//! All randomness is splitmix64 from the seed, with one stream per experiment, so two runs differ
//! only in their times. The effect of a disturbance is measured against the same curve without it.
//! The model's own error is larger for most ropes and would hide the effect.

mod at_rest;
mod clusterings;
mod conditioning;
mod cost;
mod csv;
mod curves;
mod family;
mod figure;
mod fits;
mod options;
mod ordering;
mod orders;
mod overlay;
mod picture;
mod polyline;
mod random;
mod report;
mod rivals;
mod robustness;
mod shapes;

pub use csv::Csv;
pub use options::{Effort, Options, PaperError, Ropes};
pub use picture::Picture;
pub use report::{Report, repeat};
