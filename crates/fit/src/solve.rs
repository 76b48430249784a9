//! `s = (BᵀB)⁻¹ Bᵀ c̄` (equation 8 of the paper) in three ways, with all algebra done in advance.

use crate::factor::{Qr, cholesky};
use crate::folded::{Points, Rows};
use crate::kernel::Project;
use crate::matrix::product;
use crate::system::System;
use faer::{Mat, MatRef};

/// A prepared solver.
pub(crate) enum Solve {
    /// One product with the rows of `P`.
    Product(Rows),
    /// A solve by factors.
    Steps(Steps),
}

/// A product and triangles: `Aᵀc̄` and `LLᵀ`, or `Qᵀc̄` and `R`.
pub(crate) struct Steps {
    /// The rows of `Aᵀ` or `Qᵀ`, minus the effect of pinned ends on the right-hand side.
    rows: Rows,
    triangle: Triangle,
    /// Scratch memory for the right-hand sides.
    right: Mat<f64>,
}

enum Triangle {
    /// `L` of `AᵀA = LLᵀ`.
    Cholesky(Mat<f64>),
    /// `R` of `A = QR`.
    Qr(Mat<f64>),
}

impl Solve {
    pub(crate) fn pinv(p: MatRef<'_, f64>, mirrored: bool) -> Self {
        Self::Product(Rows::of_product(p, mirrored))
    }

    /// Returns `None` if `AᵀA` is not numerically positive definite.
    pub(crate) fn cholesky(system: &System, dimensions: usize, mirrored: bool) -> Option<Self> {
        let a = system.a.as_ref();
        let l = cholesky(product(a.transpose(), a).as_ref())?;
        let right = Mat::zeros(l.ncols(), dimensions);
        Some(Self::Steps(Steps {
            rows: Rows::of_product(right_hand_side(a, system).as_ref(), mirrored),
            triangle: Triangle::Cholesky(l),
            right,
        }))
    }

    pub(crate) fn qr(factors: &Qr, system: &System, dimensions: usize, mirrored: bool) -> Self {
        let r = factors.r().to_owned();
        let right = Mat::zeros(r.ncols(), dimensions);
        Self::Steps(Steps {
            rows: Rows::of_any(right_hand_side(factors.q(), system).as_ref(), mirrored),
            triangle: Triangle::Qr(r),
            right,
        })
    }
}

/// The matrix that maps the points to `mᵀ ([c̄; 0] − E [c₁; c_N])`, for an `m` with the rows of
/// `A`.
fn right_hand_side(m: MatRef<'_, f64>, system: &System) -> Mat<f64> {
    let points = system.b.nrows();
    // The ridge's rows, below the points, have a right-hand side of 0.
    let mut products = m.subrows(0, points).transpose().to_owned();
    if system.offset() > 0 {
        let taken = product(m.transpose(), system.pinned.as_ref());
        for j in 0..products.nrows() {
            products[(j, 0)] -= taken[(j, 0)];
            products[(j, points - 1)] -= taken[(j, 1)];
        }
    }
    products
}

impl Steps {
    /// Computes the control points of `points`, which are also in `lanes` as columns. Does not
    /// allocate.
    pub(crate) fn solve<const D: usize>(
        &mut self,
        arch: lariat_portable::Arch,
        points: &[[f64; D]],
        lanes: &Points<D>,
        halves: &mut Halves<D>,
        control_points: &mut [[f64; D]],
    ) {
        let Self {
            rows,
            triangle,
            right,
        } = self;
        let solved = pin(points, control_points, right.nrows());
        project(arch, rows, lanes, halves, solved);
        write_columns(solved, right);
        for axis in 0..D {
            let column = right.col_as_slice_mut(axis);
            match triangle {
                Triangle::Cholesky(l) => solve_cholesky(l, column),
                Triangle::Qr(r) => solve_upper(r, column),
            }
        }
        read_columns(right, solved);
    }
}

/// `a · b`.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `to −= factor · from`.
fn subtract(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to -= factor * from;
    }
}

/// Replaces a column by `R⁻¹` times it.
fn solve_upper(r: &Mat<f64>, column: &mut [f64]) {
    for j in (0..column.len()).rev() {
        let r = r.col_as_slice(j);
        column[j] /= r[j];
        let known = column[j];
        subtract(&mut column[..j], known, r);
    }
}

/// Replaces a column by `(LLᵀ)⁻¹` times it.
fn solve_cholesky(l: &Mat<f64>, column: &mut [f64]) {
    for j in 0..column.len() {
        let l = l.col_as_slice(j);
        column[j] /= l[j];
        let known = column[j];
        subtract(&mut column[j + 1..], known, &l[j + 1..]);
    }
    for j in (0..column.len()).rev() {
        let l = l.col_as_slice(j);
        column[j] = (column[j] - dot(&l[j + 1..], &column[j + 1..])) / l[j];
    }
}

/// Scratch memory for the two halves of a folded product.
pub(crate) struct Halves<const D: usize> {
    pub(crate) even: Vec<[f64; D]>,
    pub(crate) odd: Vec<[f64; D]>,
}

impl<const D: usize> Halves<D> {
    pub(crate) fn new(count: usize) -> Self {
        Self {
            even: vec![[0.0; D]; count],
            odd: vec![[0.0; D]; count],
        }
    }
}

fn project<const D: usize>(
    arch: lariat_portable::Arch,
    rows: &Rows,
    points: &Points<D>,
    halves: &mut Halves<D>,
    out: &mut [[f64; D]],
) {
    let (even, odd) = halves.of(rows);
    arch.dispatch(Project {
        rows,
        points,
        even,
        odd,
    });
    rows.unfold(even, odd, out);
}

/// Sets the outer control points if they are pinned. Returns the others.
fn pin<'a, const D: usize>(
    points: &[[f64; D]],
    control_points: &'a mut [[f64; D]],
    solved: usize,
) -> &'a mut [[f64; D]] {
    let count = control_points.len();
    if solved == count {
        return control_points;
    }
    control_points[0] = points[0];
    control_points[count - 1] = points[points.len() - 1];
    &mut control_points[1..count - 1]
}

fn write_columns<const D: usize>(points: &[[f64; D]], columns: &mut Mat<f64>) {
    for axis in 0..D {
        for (number, point) in columns.col_as_slice_mut(axis).iter_mut().zip(points) {
            *number = point[axis];
        }
    }
}

fn read_columns<const D: usize>(columns: &Mat<f64>, points: &mut [[f64; D]]) {
    for axis in 0..D {
        for (number, point) in columns.col_as_slice(axis).iter().zip(points.iter_mut()) {
            point[axis] = *number;
        }
    }
}
