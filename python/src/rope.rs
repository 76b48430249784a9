//! One rope of a frame, and all that its message says of it.

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

/// Which rope: its number, and the run of the chain that gave it.
#[pyclass(frozen, eq, hash, module = "lariat")]
#[derive(PartialEq, Eq, Hash)]
pub(crate) struct Track(pub(crate) lariat_wire::Track);

#[pymethods]
impl Track {
    /// The rope's number, as messages, files and pictures have it.
    #[getter]
    fn number(&self) -> u32 {
        self.0.number()
    }

    /// Which run of the chain it is of, counted by its reader from 1.
    #[getter]
    fn run(&self) -> u64 {
        self.0.run()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Track {} of run {}>", self.0.number(), self.0.run())
    }
}

/// A rope, as it was when its image was taken.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Rope {
    frame: Py<Frame>,
    index: usize,
}

impl Rope {
    /// The rope that was seen so, if there is one.
    pub(crate) fn of(frame: &Bound<'_, Frame>, rope: &lariat_wire::Rope) -> Self {
        let index = frame.get().index_of(rope);
        Self {
            frame: frame.clone().unbind(),
            index,
        }
    }

    /// What is known of it, if the image may be so old.
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
    /// Which rope it is: give it to `Frame.rope` to have the same one again.
    #[getter]
    fn track(&self) -> PyResult<Track> {
        Ok(Track(self.rope()?.track()))
    }

    /// How long ago the rope had this shape when the frame was asked for, s: since its image was taken, and, of a lost one,
    /// since the last image that it was seen in.
    #[getter]
    pub(crate) fn age(&self) -> PyResult<f64> {
        Ok(self.rope()?.age().as_secs_f64())
    }

    /// When its image was taken, in nanoseconds of `time.monotonic_ns()`.
    #[getter]
    fn exposed_ns(&self) -> PyResult<u64> {
        Ok(self.rope()?.exposed_ns())
    }

    /// What it is measured in, as the frame's `unit`.
    #[getter]
    fn unit(&self) -> Option<&'static str> {
        self.frame.get().unit()
    }

    /// The points that its curve was fitted to, with their widths: where the rope was seen, whether the curve lies on them
    /// or not. `None` if who sent it gives none; `lariat run` always does.
    #[getter]
    fn centerline(this: &Bound<'_, Self>) -> Option<Centerline> {
        Centerline::of_rope(this)
    }

    /// Whether the curve lies on those points: `"good"`, `"coarse"`, or `"not judged"` by who sent it.
    #[getter]
    fn fit(&self) -> Option<&'static str> {
        self.descriptor().fit().map(FitQuality::name)
    }

    /// How sure it is that this is a rope, and its centerline whole and in order, 0 to 1: of those at 0.9, nine of ten are.
    #[getter]
    fn confidence(&self) -> f32 {
        self.descriptor().confidence
    }

    /// Its curve: any point of it, its direction, its covariance.
    #[getter]
    fn shape(this: &Bound<'_, Self>) -> PyResult<Shape> {
        Shape::of_rope(this)
    }

    /// Its curve in space, of a reader that was opened with `space=True`. Raises `ValueError`, with the reason, where it is not
    /// known where the rope is.
    #[getter]
    fn in_space(this: &Bound<'_, Self>) -> PyResult<SpaceShape> {
        SpaceShape::of_rope(this)
    }

    /// Where it will be at the moment `t_ns` of `time.monotonic_ns()`, by its velocities, and how uncertain.
    fn predict(&self, t_ns: u64) -> PyResult<Shape> {
        let rope = self.rope()?;
        let prediction = rope.predict(t_ns).map_err(value_error)?;
        Ok(Shape::moved(prediction.to_descriptor()))
    }

    /// Its control points, of shape (control points, 2); feature points and center too.
    #[getter]
    fn control_points<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |rope| rope.descriptor().control_points())
    }

    /// Covariance of each control point's coordinates, rows of xx, xy, yy.
    #[getter]
    fn covariances<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |rope| rope.descriptor().covariances())
    }

    /// Velocity of each control point, units a second; `None` unless the chain filters them (`--filter`).
    #[getter]
    fn velocities<'py>(this: &Bound<'py, Self>) -> Option<Bound<'py, PyArray<f64, Ix2>>> {
        let is_filtered = this.get().descriptor().filtered == 1;
        is_filtered.then(|| views::rows(this, |rope| rope.descriptor().velocities()))
    }

    /// Weights of the control points: those of a rational curve, else 1.
    #[getter]
    fn weights<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix1>> {
        views::row(this, |rope| rope.descriptor().weights())
    }

    /// The inner knots of a B-spline, ascending between 0 and 1; none of other curves.
    #[getter]
    fn knots<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix1>> {
        views::row(this, |rope| rope.descriptor().inner_knots())
    }

    /// The family of curves: `"bezier"`, `"bspline"`, `"rational"`, `"fourier"`, `"points"` or `"mass"`.
    #[getter]
    fn basis(&self) -> Option<&'static str> {
        self.descriptor().basis().map(Basis::name)
    }

    /// Degree of the curve's polynomials, 3 of a cubic B-spline whatever its control points; of a Fourier series its harmonics.
    #[getter]
    fn degree(&self) -> u32 {
        self.descriptor().degree
    }

    /// How many points of the centerline were fitted.
    #[getter]
    fn samples(&self) -> u32 {
        self.descriptor().samples
    }

    /// Whether the rope has no ends.
    #[getter]
    fn closed(&self) -> bool {
        self.descriptor().closed != 0
    }

    /// Which of its ends leave the image, first and last.
    #[getter]
    fn leaves_image(&self) -> (bool, bool) {
        let border = self.descriptor().border;
        (border & 1 != 0, border & 2 != 0)
    }

    /// Which share of it was covered by something, and so bridged: 0 to 1.
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

    /// The largest such distance.
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
