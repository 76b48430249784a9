//! The points that a rope's curve was fitted to.

use crate::along::Rho;
use crate::rope::Rope;
use crate::views;
use lariat_wire::{Absent, CenterlinePoints, Nearest};
use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArray, PyArray1, PyArrayDyn};
use pyo3::prelude::*;

/// The points of a rope at equal steps of arc length, joined by straight lines, in the frame's
/// unit. They are the unfiltered observed points, whether or not the curve follows them. rho is 0
/// at the first point and 1 at the last; on a closed rope, 1 is the first point again.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Centerline {
    rope: Py<Rope>,
}

impl Centerline {
    /// The centerline of a rope; `None` if the sender gives no points.
    pub(crate) fn of_rope(rope: &Bound<'_, Rope>) -> Option<Self> {
        lariat_wire::Centerline::of(rope.get().points())?;
        Some(Self {
            rope: rope.clone().unbind(),
        })
    }

    fn points_sent(&self) -> &CenterlinePoints {
        self.rope.get().points()
    }

    fn line(&self) -> PyResult<lariat_wire::Centerline<'_>> {
        // There were points when this object was created, and they do not change.
        let line = lariat_wire::Centerline::of(self.points_sent());
        line.ok_or_else(|| crate::errors::value_error(Absent::Unreadable))
    }
}

#[pymethods]
impl Centerline {
    /// The points, of shape (n, 2).
    #[getter]
    fn points<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f32, Ix2>> {
        views::rows(this, |line| line.points_sent().points())
    }

    /// Width of the rope at each point.
    #[getter]
    fn widths<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f32, Ix1>> {
        views::row(this, |line| line.points_sent().widths())
    }

    /// True for each point that is covered or outside the image; its position is then interpolated.
    #[getter]
    fn hidden<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let points = self.points_sent();
        let hidden = (0..points.points().len()).map(|i| points.is_hidden(i));
        PyArray1::from_vec(py, hidden.collect())
    }

    /// True if the first point follows the last.
    #[getter]
    fn closed(&self) -> bool {
        self.points_sent().closed != 0
    }

    /// The point at rho, 0 to 1, on the straight line between its two neighbors. For n values of
    /// rho, an array of shape (n, 2).
    fn point_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let line = self.line()?;
        Ok(rho.vectors(py, |rho| line.point_at(rho)))
    }

    /// The nearest point to `point`: its rho, the point itself, and the distance.
    fn nearest<'py>(&self, py: Python<'py>, point: [f64; 2]) -> PyResult<Found<'py>> {
        Ok(found(py, self.line()?.nearest(point)))
    }

    fn __len__(&self) -> usize {
        self.points_sent().points().len()
    }

    fn __repr__(&self) -> String {
        let track = self.rope.get().descriptor().track;
        format!(
            "<lariat.Centerline of rope {track}: {} points>",
            self.__len__()
        )
    }
}

/// A nearest point in Python: rho, point, distance.
pub(crate) type Found<'py> = (f64, Bound<'py, PyArray1<f64>>, f64);

pub(crate) fn found(py: Python<'_>, nearest: Nearest) -> Found<'_> {
    let point = PyArray1::from_vec(py, nearest.point.to_vec());
    (nearest.rho, point, nearest.distance)
}
