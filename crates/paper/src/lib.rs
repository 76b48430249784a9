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
pub use picture::{Picture, base64};
pub use report::{Report, repeat};
