//! The Python package's Rust half, imported as `lariat._native`: extraction and fit of arrays, and a control loop's
//! reader. What Python writes better (drawings for notebooks, the cases of what is seen) stands in `lariat/`.
//!
//! Every number of an array lies in an object of this crate, and the array is a view of it that keeps it alive: nothing is
//! copied to be looked at. Whatever takes longer than a look lets other Python threads run.

mod along;
mod errors;
mod fit;
mod fitting;
mod pixels;
mod scene;
mod tracer;
mod views;

/// The module as Python imports it.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::fit::Fit;
    #[pymodule_export]
    use crate::fitting::Fitter;
    #[pymodule_export]
    use crate::scene::{Crossing, Curve, Notice, Scene};
    #[pymodule_export]
    use crate::tracer::{Tracer, pick};
}
