//! Charts as SVG, and HTML pages that contain them: one style for all of lariat's reports.
//!
//! The input is numbers ([`Spread`] summarizes their distribution), the output is text. Nothing is
//! read, written or fetched.
//!
//! ```
//! use lariat_plot::{Axis, Chart, LineStyle, draw, page};
//!
//! let mut chart = Chart::new(
//!     Axis::linear("time, s", [0.0, 4.0], 1.0),
//!     Axis::log("error, px", [0.5, 100.0]),
//! );
//! chart.line("a rope", LineStyle::nth(0), vec![[0.0, 80.0], [2.0, 3.0], [4.0, 1.0]]);
//! let svg = draw("error against time", &[chart], 1)?;
//! assert!(page("A rope", &svg).ends_with("</html>\n"));
//! # Ok::<(), lariat_plot::PlotError>(())
//! ```

mod chart;
mod page;
pub mod spread;
pub mod words;

pub use chart::{Axis, Chart, LineStyle, Mark, Marker, PlotError, Stroke, draw};
pub use page::{check_tags, escaped, page};
pub use spread::Spread;
