//! The experiments of F. Chen, *Bezier-based Regression Feature Descriptor for Deformable Linear Objects*
//! (arXiv 2312.16502), repeated with numbers where it has pictures, and carried on where it stops.
//!
//! [`repeat`] draws ropes whose centerlines are known (or takes [`Picture`]s of others), looks at them with the extractor, fits
//! them, and returns a [`Report`]: one page of HTML with its figures inside, and the numbers behind each figure as CSV.
//! It writes no file and asks for nothing but the time that things take. The same seed gives the same numbers, but for
//! those times.
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
//! One experiment is one module; each makes plain numbers first and from them its table, its drawing and the sentences
//! that say what was found.
//!
//! # How it works
//!
//! `bench/paper`, by `lariat paper`. What each equation and claim of the paper is here: docs/paper.md (`docs/paper.md`).
//!
//! One experiment is one module (`clusterings`, `fits`, `orders`, `robustness/`, `cost`, `rivals`, `conditioning`, `ordering`, `at_rest`).
//! Each runs to plain numbers, and from these alone makes its figure, its CSV and the sentences of its caption, so that a
//! caption cannot say what the numbers do not: tests hand in numbers of both outcomes. `shapes` are the ropes they all share,
//! drawn or seen in pictures; `family` the curves at an equal number of parameters. `bench/plot` is the style of all charts
//! (colors, dashes, markers, legends above the plot) and of the page (HTML without script and without anything to fetch),
//! `overlay` curves over a picture. All randomness is splitmix64 by the seed, a stream for each experiment, so that two runs
//! differ in their times alone. What a disturbance does to a curve is measured from the same curve without it: the model's own
//! error, larger for most ropes, would hide it.

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
