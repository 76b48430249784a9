//! A fitted curve and its evaluation.

use crate::along::{Rho, nowhere};
use crate::errors::value_error;
use crate::views;
use lariat_fit::{Basis, Curve};
use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArray, PyArray2, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// A curve fitted to points, in their unit: f(rho), with rho from 0 at the first point to 1 at the
/// last.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Fit {
    fit: lariat_fit::Fit,
    points: usize,
}

impl Fit {
    pub(crate) fn new(fit: lariat_fit::Fit, points: usize) -> Self {
        Self { fit, points }
    }

    fn curve(&self) -> PyResult<Curve<'_>> {
        let fit = &self.fit;
        Curve::new(fit.basis, &fit.control_points, &fit.weights, &fit.knots).map_err(value_error)
    }
}

#[pymethods]
impl Fit {
    /// The family of curves: `"bezier"`, `"bspline"`, `"rational"`, `"fourier"`, `"points"` or
    /// `"mass"`.
    #[getter]
    fn basis(&self) -> &'static str {
        self.fit.basis.name()
    }

    /// Polynomial degree of the curve (3 for a cubic B-spline); number of harmonics for a Fourier
    /// series.
    #[getter]
    fn degree(&self) -> usize {
        self.fit.basis.order()
    }

    /// True if the curve is closed.
    #[getter]
    fn closed(&self) -> bool {
        self.fit.basis.is_closed()
    }

    /// The control points, of shape (control points, 2).
    #[getter]
    fn control_points<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f64, Ix2>> {
        views::rows(this, |fit| &fit.fit.control_points)
    }

    /// Weights of the control points; `None` unless the curve is rational.
    #[getter]
    fn weights<'py>(this: &Bound<'py, Self>) -> Option<Bound<'py, PyArray<f64, Ix1>>> {
        (!this.get().fit.weights.is_empty()).then(|| views::row(this, |fit| &fit.fit.weights))
    }

    /// The clamped knots; `None` unless the curve is a B-spline.
    #[getter]
    fn knots<'py>(this: &Bound<'py, Self>) -> Option<Bound<'py, PyArray<f64, Ix1>>> {
        let is_spline = matches!(this.get().fit.basis, Basis::BSpline { .. });
        is_spline.then(|| views::row(this, |fit| &fit.fit.knots))
    }

    /// Root mean square distance of the points from the curve at their rho.
    #[getter]
    fn rms(&self) -> f64 {
        self.fit.rms_px
    }

    /// Maximum distance of a point from the curve at its rho.
    #[getter]
    fn max(&self) -> f64 {
        self.fit.max_px
    }

    /// Variance of one coordinate's residual; 0 if there are only as many points as control points.
    #[getter]
    fn residual_variance(&self) -> f64 {
        self.fit.residual_variance
    }

    /// Condition number of the regression: the largest amplification of a relative error from
    /// points to control points.
    #[getter]
    fn condition(&self) -> f64 {
        self.fit.condition
    }

    /// Standard deviation of the least certain control point's coordinate, for unit noise in the
    /// points.
    #[getter]
    fn noise_gain(&self) -> f64 {
        self.fit.noise_gain()
    }

    /// Joint covariance of all control points, for the vector x0, y0, x1, y1, …: the residual
    /// variance times `(BᵀB)⁻¹ ⊗ I₂`.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (fit, count) = (&self.fit, self.fit.control_points.len());
        let matrix = PyArray2::zeros(py, [2 * count, 2 * count], false);
        {
            let mut matrix = matrix.try_readwrite()?;
            let mut matrix = matrix.as_array_mut();
            for j in 0..count {
                for k in 0..count {
                    let shared = fit.residual_variance * fit.covariance_factor[(j, k)];
                    for axis in 0..2 {
                        matrix[[2 * j + axis, 2 * k + axis]] = shared;
                    }
                }
            }
        }
        Ok(matrix)
    }

    /// The point at rho, 0 to 1. For n values of rho, an array of shape (n, 2).
    fn point_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let curve = self.curve()?;
        Ok(rho.vectors(py, |rho| curve.point(rho)))
    }

    /// The derivative with respect to rho: f′(rho).
    fn derivative_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let curve = self.curve()?;
        Ok(rho.vectors(py, |rho| curve.derivative(rho, 1)))
    }

    /// The unit tangent; NaN if the curve is a point.
    fn tangent_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let curve = self.curve()?;
        Ok(rho.vectors(py, |rho| curve.tangent(rho).unwrap_or(nowhere())))
    }

    /// The curvature, one over the radius; NaN where the derivative vanishes.
    fn curvature_at<'py>(&self, py: Python<'py>, rho: Rho<'py>) -> PyResult<Bound<'py, PyAny>> {
        let curve = self.curve()?;
        rho.numbers(py, |rho| curve.curvature(rho).unwrap_or(f64::NAN))
    }

    /// The Jacobian of the point at rho with respect to the control points, the same for x and y.
    fn jacobian_at<'py>(
        &self,
        py: Python<'py>,
        rho: Rho<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let curve = self.curve()?;
        let count = self.fit.control_points.len();
        Ok(rho.rows(py, count, |rho, row| curve.jacobian(rho, row)))
    }

    /// Length of the curve.
    fn length(&self) -> PyResult<f64> {
        Ok(self.curve()?.length())
    }

    /// The nearest point of the curve to `point`: its rho, and the distance.
    fn nearest(&self, point: [f64; 2]) -> PyResult<(f64, f64)> {
        let nearest = self.curve()?.nearest(point);
        Ok((nearest.rho, nearest.distance))
    }

    fn __repr__(&self) -> String {
        format!(
            "<lariat.Fit: {} through {} points, rms {:.3}, max {:.3}>",
            self.fit.basis, self.points, self.fit.rms_px, self.fit.max_px
        )
    }

    fn _repr_html_<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py()
            .import("lariat._drawing")?
            .call_method1("fit", (this,))
    }
}
