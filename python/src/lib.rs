//! The Rust half of the Python package, imported as `lariat._native`: extraction and fit of arrays,
//! a reader for control loops, and writers for cameras and mask networks. The parts that are
//! simpler in Python (drawings for notebooks, the states of a rope) are in `lariat/`.
//!
//! All numbers of an array are stored in an object of this crate. The array is a view that keeps
//! the object alive, so reading copies nothing. Other Python threads can run during every longer
//! call.

mod along;
mod centerline;
mod errors;
mod fit;
mod fitting;
mod frame;
mod frames;
mod pixels;
mod reader;
mod rope;
mod scene;
mod seen;
mod shape;
mod space;
mod tracer;
mod views;
mod way;
mod writer;

/// The module as Python imports it.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    /// # Errors
    /// Python is out of memory.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    #[pymodule_export]
    use crate::centerline::Centerline;
    #[pymodule_export]
    use crate::fit::Fit;
    #[pymodule_export]
    use crate::fitting::Fitter;
    #[pymodule_export]
    use crate::frame::Frame;
    #[pymodule_export]
    use crate::frames::{Frames, Image};
    #[pymodule_export]
    use crate::reader::{Reader, take_short_slices};
    #[pymodule_export]
    use crate::rope::{Rope, Track};
    #[pymodule_export]
    use crate::scene::{Crossing, Curve, Notice, Scene};
    #[pymodule_export]
    use crate::seen::{Absent, Fresh, Lost, Partial, Stale, Unsure};
    #[pymodule_export]
    use crate::shape::Shape;
    #[pymodule_export]
    use crate::space::SpaceShape;
    #[pymodule_export]
    use crate::tracer::{Tracer, pick};
    #[pymodule_export]
    use crate::way::Trace;
    #[pymodule_export]
    use crate::writer::{Slot, Writer};
}
