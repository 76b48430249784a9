//! A rope's curve for control laws, observed or predicted.

use crate::along::{Rho, nowhere};
use crate::centerline::{Found, found};
use crate::errors::value_error;
use crate::rope::Rope;
use crate::views;
use lariat_wire::Descriptor;
use numpy::ndarray::Ix2;
use numpy::{PyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// The curve f(rho) in the frame's unit, with rho from 0 at the rope's first end to 1 at its last.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Shape {
    source: Source,
}

/// Source of its numbers.
enum Source {
    Seen(Py<Rope>),
    Moved(Box<Descriptor>),
}

impl Shape {
    /// The curve of an observed rope.
    ///
    /// # Errors
    /// The chain describes ropes by points or by their center instead of a curve.
    pub(crate) fn of_rope(rope: &Bound<'_, Rope>) -> PyResult<Self> {
        lariat_wire::Shape::of(rope.get().descriptor()).map_err(value_error)?;
        Ok(Self {
            source: Source::Seen(rope.clone().unbind()),
        })
    }

    /// The curve of a predicted rope.
    pub(crate) fn moved(descriptor: Descriptor) -> Self {
        Self {
            source: Source::Moved(Box::new(descriptor)),
        }
    }

    fn descriptor(&self) -> &Descriptor {
        match &self.source {
            Source::Seen(rope) => rope.get().descriptor(),
            Source::Moved(descriptor) => descriptor,
        }
    }

    fn shape(&self) -> PyResult<lariat_wire::Shape<'_>> {
        lariat_wire::Shape::of(self.descriptor()).map_err(value_error)
    }
}

#[pymethods]
impl Shape {
    /// The control points, of shape (control points, 2); for a closed rope, the coefficients of its
    /// Fourier series.
    #[getter]
    fn control_points<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |shape| shape.descriptor().control_points())
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
        PyArray1::from_vec(py, numbers.collect()).reshape([count, 2])
    }

    /// The point at rho, 0 to 1. For n values of rho, an array of shape (n, 2).
    fn point_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = self.shape()?;
        Ok(rho.vectors(py, |rho| shape.point_at(rho)))
    }

    /// The nearest point of the curve to `point`: its rho, the point itself, and the distance.
    fn nearest<'py>(&self, py: Python<'py>, point: [f64; 2]) -> PyResult<Found<'py>> {
        Ok(found(py, self.shape()?.nearest(point)))
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

    /// The unit normal, to the right of the direction of travel in the image; NaN if the curve is a
    /// point.
    fn normal_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = self.shape()?;
        Ok(rho.vectors(py, |rho| shape.normal_at(rho).unwrap_or(nowhere())))
    }

    /// The signed curvature, one over the radius, positive if the curve turns towards its normal.
    /// NaN where the derivative vanishes.
    fn curvature_at<'py>(&self, py: Python<'py>, rho: Rho<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shape = self.shape()?;
        rho.numbers(py, |rho| shape.curvature_at(rho).unwrap_or(f64::NAN))
    }

    /// The Jacobian of the point at rho with respect to the control points, the same for x and y.
    /// For n values of rho, an array of shape (n, control points).
    fn jacobian_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = self.shape()?;
        let count = shape.control_points().len();
        Ok(rho.rows(py, count, |rho, row| {
            row.copy_from_slice(&shape.jacobian_at(rho))
        }))
    }

    /// The joint covariance of all control points, for the vector x0, y0, x1, y1, …, in the unit
    /// squared.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let covariance = self.shape()?.covariance();
        let size = covariance.size();
        let mut matrix = vec![0.0; size * size];
        covariance.write_to(&mut matrix);
        PyArray1::from_vec(py, matrix).reshape([size, size])
    }

    /// True if `covariance` is exact up to rounding, as for plain least squares with or without a
    /// filter. Otherwise (ridge, pinned ends, weights, a plane) each control point's own covariance
    /// is exact, and the correlations are those of the plain fit.
    #[getter]
    fn covariance_is_exact(&self) -> PyResult<bool> {
        Ok(self.shape()?.covariance().is_exact())
    }

    /// The covariance of the point at rho, of shape (2, 2). For n values of rho, (n, 2, 2).
    fn covariance_at<'py>(&self, py: Python<'py>, rho: Rho<'py>) -> PyResult<Bound<'py, PyAny>> {
        let covariance = self.shape()?.covariance();
        let numbers = rho.rows(py, 4, |rho, row| {
            let [xx, xy, yy] = covariance.of_point(rho);
            row.copy_from_slice(&[xx, xy, xy, yy]);
        });
        Ok(match rho.count() {
            None => numbers.reshape([2, 2])?.into_any(),
            Some(count) => numbers.reshape([count, 2, 2])?.into_any(),
        })
    }

    fn __repr__(&self) -> String {
        let predicted = match self.source {
            Source::Seen(_) => "",
            Source::Moved(_) => "predicted, ",
        };
        let descriptor = self.descriptor();
        format!(
            "<lariat.Shape of rope {}: {predicted}{} control points>",
            descriptor.track, descriptor.count
        )
    }

    fn _repr_html_<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py()
            .import("lariat._drawing")?
            .call_method1("shape", (this,))
    }
}
