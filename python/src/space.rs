//! A rope's curve in space.

use crate::along::{Rho, nowhere};
use crate::errors::value_error;
use crate::rope::Rope;
use crate::views;
use lariat_wire::{Descriptor3, FitQuality, Place};
use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// The curve f(rho) in space, mm, from a depth camera, with rho from 0 at the rope's first end to 1
/// at its last.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct SpaceShape {
    rope: Py<Rope>,
}

impl SpaceShape {
    /// The curve of an observed rope.
    ///
    /// # Errors
    /// The reader does not follow in space, the chain lacks a depth camera, or the rope's position
    /// is unknown.
    pub(crate) fn of_rope(rope: &Bound<'_, Rope>) -> PyResult<Self> {
        rope.get().rope()?.in_space().map_err(value_error)?;
        Ok(Self {
            rope: rope.clone().unbind(),
        })
    }

    fn descriptor(&self) -> &Descriptor3 {
        const NONE: &Descriptor3 = &Descriptor3::EMPTY;
        self.rope.get().descriptor3().unwrap_or(NONE)
    }

    fn shape(&self) -> PyResult<lariat_wire::Shape<'_, 3>> {
        lariat_wire::Shape::in_space(self.descriptor()).map_err(value_error)
    }
}

#[pymethods]
impl SpaceShape {
    /// The control points, of shape (control points, 3), mm.
    #[getter]
    fn control_points<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |shape| shape.descriptor().control_points())
    }

    /// Covariance of each control point's coordinates, rows of xx, xy, xz, yy, yz, zz, mm².
    #[getter]
    fn covariances<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |shape| shape.descriptor().covariances())
    }

    /// Velocity of each control point, mm/s; `None` unless the chain filters them (`--filter`).
    #[getter]
    fn velocities<'py>(this: &Bound<'py, Self>) -> Option<Bound<'py, PyArray<f64, Ix2>>> {
        let is_filtered = this.get().descriptor().filtered == 1;
        is_filtered.then(|| views::rows(this, |shape| shape.descriptor().velocities()))
    }

    /// The fitted centerline points, of shape (points, 3), mm.
    #[getter]
    fn centerline<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f32, Ix2>> {
        views::rows(this, |shape| shape.descriptor().points())
    }

    /// Standard deviation of each of those points along the camera's line of sight, mm.
    #[getter]
    fn sigmas<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f32, Ix1>> {
        views::row(this, |shape| shape.descriptor().sigmas())
    }

    /// Number of points measured in the depth image; the others are interpolated.
    #[getter]
    fn measured(&self) -> u32 {
        self.descriptor().measured
    }

    /// `"known"`, or `"before"` for the last known position of a lost rope.
    #[getter]
    fn place(&self) -> Option<&'static str> {
        self.descriptor().place().map(Place::name)
    }

    /// Fit of the curve to its points: `"good"`, `"coarse"`, or `"not judged"`.
    #[getter]
    fn fit(&self) -> Option<&'static str> {
        self.descriptor().fit().map(FitQuality::name)
    }

    /// Arc length of the centerline, mm.
    #[getter]
    fn length(&self) -> f64 {
        self.descriptor().length
    }

    /// Median width of the rope, mm.
    #[getter]
    fn width(&self) -> f64 {
        self.descriptor().width
    }

    /// True if the curve is closed.
    #[getter]
    fn closed(&self) -> PyResult<bool> {
        Ok(self.shape()?.is_closed())
    }

    /// `count` points at equal steps of rho: from end to end, or once around a closed curve.
    #[pyo3(signature = (count=120))]
    fn points<'py>(&self, py: Python<'py>, count: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = self.shape()?;
        let numbers = (0..count).flat_map(|i| shape.point_at(shape.even_rho(i, count)));
        PyArray1::from_vec(py, numbers.collect()).reshape([count, 3])
    }

    /// The point at rho, 0 to 1. For n values of rho, an array of shape (n, 3).
    fn point_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = self.shape()?;
        Ok(rho.vectors(py, |rho| shape.point_at(rho)))
    }

    /// The derivative with respect to rho: f′(rho).
    fn derivative_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = self.shape()?;
        Ok(rho.vectors(py, |rho| shape.derivative_at(rho)))
    }

    /// The unit tangent; NaN if the curve is a point.
    fn tangent_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = self.shape()?;
        Ok(rho.vectors(py, |rho| shape.tangent_at(rho).unwrap_or(nowhere())))
    }

    /// The nearest point of the curve to `point`: its rho, the point itself, and the distance.
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        point: [f64; 3],
    ) -> PyResult<(f64, Bound<'py, PyArray1<f64>>, f64)> {
        let nearest = self.shape()?.nearest(point);
        let on = PyArray1::from_slice(py, &nearest.point);
        Ok((nearest.rho, on, nearest.distance))
    }

    fn __repr__(&self) -> String {
        let descriptor = self.descriptor();
        format!(
            "<lariat.SpaceShape of rope {}: {} control points, {:.1} mm long>",
            descriptor.track, descriptor.count, descriptor.length
        )
    }
}
