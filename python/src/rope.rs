//! One rope of a frame, with everything in its message.

use crate::centerline::Centerline;
use crate::errors::value_error;
use crate::frame::Frame;
use crate::shape::Shape;
use crate::space::SpaceShape;
use crate::views;
use lariat_wire::{Absent, Basis, CenterlinePoints, Descriptor, Descriptor3, FitQuality, Seen};
use numpy::PyArray;
use numpy::ndarray::{Ix1, Ix2};
use pyo3::prelude::*;
use std::time::Duration;

/// Identity of a rope: its number and the run of the chain that assigned it.
#[pyclass(frozen, eq, hash, module = "lariat")]
#[derive(PartialEq, Eq, Hash)]
pub(crate) struct Track(pub(crate) lariat_wire::Track);

#[pymethods]
impl Track {
    /// Number of the rope in messages, files and images.
    #[getter]
    fn number(&self) -> u32 {
        self.0.number()
    }

    /// Run of the chain, counted by its reader from 1.
    #[getter]
    fn run(&self) -> u64 {
        self.0.run()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Track {} of run {}>", self.0.number(), self.0.run())
    }
}

/// A rope at the time of its image.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Rope {
    frame: Py<Frame>,
    index: usize,
}

impl Rope {
    /// The rope of a frame.
    pub(crate) fn of(frame: &Bound<'_, Frame>, rope: &lariat_wire::Rope) -> Self {
        let index = frame.get().index_of(rope);
        Self {
            frame: frame.clone().unbind(),
            index,
        }
    }

    /// State of the rope for this maximum age of its image.
    pub(crate) fn seen(&self, max_age: Duration) -> Option<Seen<'_>> {
        self.frame.get().frame().ropes(max_age).nth(self.index)
    }

    pub(crate) fn rope(&self) -> PyResult<lariat_wire::Rope<'_>> {
        match self.seen(Duration::MAX) {
            Some(Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _)) => Ok(rope),
            Some(Seen::Lost(last) | Seen::Stale(last)) => Ok(last.as_it_was()),
            Some(seen @ Seen::Absent(_)) => Err(value_error(seen)),
            None => Err(value_error(Absent::NoRope)),
        }
    }

    pub(crate) fn descriptor(&self) -> &Descriptor {
        const NONE: &Descriptor = &Descriptor::EMPTY;
        let message = self.frame.get().frame().message();
        message
            .and_then(|message| message.curves().get(self.index))
            .unwrap_or(NONE)
    }

    pub(crate) fn descriptor3(&self) -> Option<&Descriptor3> {
        self.rope().ok()?.descriptor3().ok()
    }

    pub(crate) fn points(&self) -> &CenterlinePoints {
        const NONE: &CenterlinePoints = &CenterlinePoints::EMPTY;
        let message = self.frame.get().frame().message();
        message
            .and_then(|message| message.centerlines().get(self.index))
            .unwrap_or(NONE)
    }
}

#[pymethods]
impl Rope {
    /// Identity of the rope. `Frame.rope` finds the same rope by it.
    #[getter]
    fn track(&self) -> PyResult<Track> {
        Ok(Track(self.rope()?.track()))
    }

    /// Age of the shape when the frame was requested, s: the time since its image was taken or, for
    /// a lost rope, since the last image that showed it.
    #[getter]
    pub(crate) fn age(&self) -> PyResult<f64> {
        Ok(self.rope()?.age().as_secs_f64())
    }

    /// Exposure time of its image in nanoseconds of `time.monotonic_ns()`.
    #[getter]
    fn exposed_ns(&self) -> PyResult<u64> {
        Ok(self.rope()?.exposed_ns())
    }

    /// Unit of its coordinates, as `Frame.unit`.
    #[getter]
    fn unit(&self) -> Option<&'static str> {
        self.frame.get().unit()
    }

    /// The points that its curve was fitted to, with their widths: the observed points, whether or
    /// not the curve follows them. `None` if the sender gives no points; `lariat run` always does.
    #[getter]
    fn centerline(this: &Bound<'_, Self>) -> Option<Centerline> {
        Centerline::of_rope(this)
    }

    /// Fit of the curve to those points: `"good"`, `"coarse"`, or `"not judged"` by the sender.
    #[getter]
    fn fit(&self) -> Option<&'static str> {
        self.descriptor().fit().map(FitQuality::name)
    }

    /// Calibrated probability, 0 to 1, that this is a rope and its centerline is whole and in
    /// order.
    #[getter]
    fn confidence(&self) -> f32 {
        self.descriptor().confidence
    }

    /// Its curve, with points, directions and covariance.
    #[getter]
    fn shape(this: &Bound<'_, Self>) -> PyResult<Shape> {
        Shape::of_rope(this)
    }

    /// Its curve in space, for a reader opened with `space=True`. If its position is unknown,
    /// raises `ValueError` with the reason.
    #[getter]
    fn in_space(this: &Bound<'_, Self>) -> PyResult<SpaceShape> {
        SpaceShape::of_rope(this)
    }

    /// Predicts the rope at the time `t_ns` of `time.monotonic_ns()` from its velocities, with its
    /// covariance.
    fn predict(&self, t_ns: u64) -> PyResult<Shape> {
        let rope = self.rope()?;
        let prediction = rope.predict(t_ns).map_err(value_error)?;
        Ok(Shape::moved(prediction.to_descriptor()))
    }

    /// Its control points, of shape (control points, 2), or its feature points or center.
    #[getter]
    fn control_points<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |rope| rope.descriptor().control_points())
    }

    /// Covariance of each control point's coordinates, rows of xx, xy, yy.
    #[getter]
    fn covariances<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |rope| rope.descriptor().covariances())
    }

    /// Velocity of each control point, units per second; `None` unless the chain filters them
    /// (`--filter`).
    #[getter]
    fn velocities<'py>(this: &Bound<'py, Self>) -> Option<Bound<'py, PyArray<f64, Ix2>>> {
        let is_filtered = this.get().descriptor().filtered == 1;
        is_filtered.then(|| views::rows(this, |rope| rope.descriptor().velocities()))
    }

    /// Weights of the control points; 1 unless the curve is rational.
    #[getter]
    fn weights<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix1>> {
        views::row(this, |rope| rope.descriptor().weights())
    }

    /// The inner knots of a B-spline, ascending between 0 and 1; empty for other curves.
    #[getter]
    fn knots<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix1>> {
        views::row(this, |rope| rope.descriptor().inner_knots())
    }

    /// The family of curves: `"bezier"`, `"bspline"`, `"rational"`, `"fourier"`, `"points"` or
    /// `"mass"`.
    #[getter]
    fn basis(&self) -> Option<&'static str> {
        self.descriptor().basis().map(Basis::name)
    }

    /// Polynomial degree of the curve (3 for a cubic B-spline); number of harmonics for a Fourier
    /// series.
    #[getter]
    fn degree(&self) -> u32 {
        self.descriptor().degree
    }

    /// Number of fitted centerline points.
    #[getter]
    fn samples(&self) -> u32 {
        self.descriptor().samples
    }

    /// True if the rope is closed.
    #[getter]
    fn closed(&self) -> bool {
        self.descriptor().closed != 0
    }

    /// True for each end, first and last, that leaves the image.
    #[getter]
    fn leaves_image(&self) -> (bool, bool) {
        let border = self.descriptor().border;
        (border & 1 != 0, border & 2 != 0)
    }

    /// Share of its points that are covered or outside the image, and so interpolated: 0 to 1.
    #[getter]
    fn hidden(&self) -> PyResult<f64> {
        Ok(self.rope()?.hidden())
    }

    /// Arc length of the centerline.
    #[getter]
    fn length(&self) -> f64 {
        self.descriptor().length
    }

    /// Median width of the rope.
    #[getter]
    fn width(&self) -> f64 {
        self.descriptor().width
    }

    /// Root mean square distance of the points from the curve at their rho.
    #[getter]
    fn rms(&self) -> f64 {
        self.descriptor().rms
    }

    /// Maximum distance of a point from the curve at its rho.
    #[getter]
    fn max(&self) -> f64 {
        self.descriptor().max
    }

    /// Variance of one coordinate's residual.
    #[getter]
    fn residual_variance(&self) -> f64 {
        self.descriptor().residual_variance
    }

    /// Condition number of the regression.
    #[getter]
    fn condition(&self) -> f64 {
        self.descriptor().condition
    }

    fn __repr__(&self) -> String {
        let descriptor = self.descriptor();
        format!(
            "<lariat.Rope {}: {} of {} control points, {:.1} {} long, rms {:.2}>",
            descriptor.track,
            self.basis().unwrap_or("curve"),
            descriptor.count,
            descriptor.length,
            self.unit().unwrap_or("units"),
            descriptor.rms,
        )
    }

    fn _repr_html_<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py()
            .import("lariat._drawing")?
            .call_method1("rope", (this,))
    }
}
