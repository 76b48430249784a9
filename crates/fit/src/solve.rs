//! `s = (BᵀB)⁻¹ Bᵀ c̄` (equation 8 of the paper) in three ways, all of their algebra done beforehand.

use crate::factor::{Qr, cholesky, solve_cholesky, solve_upper};
use crate::folded::{Points, Rows};
use crate::kernel::Project;
use crate::matrix::Matrix;
use crate::system::System;

/// How a fit is computed, ready.
pub(crate) enum Solve {
    /// By the rows of `P`, in one product.
    Product(Rows),
    /// By factors.
    Steps(Steps),
}

/// The ways that solve triangles.
pub(crate) enum Steps {
    /// The rows of `Aᵀ`, the factor `L` of `AᵀA = LLᵀ`, and room for the right-hand sides.
    Cholesky {
        rows: Rows,
        l: Matrix,
        right: Matrix,
    },
    /// The factors of `A`, what the pinned ends take from its right-hand sides, and room for these.
    Qr {
        factors: Qr,
        pinned: Matrix,
        right: Matrix,
    },
}

impl Solve {
    pub(crate) fn pinv(p: &Matrix, mirrored: bool) -> Self {
        Self::Product(Rows::of_product(p, mirrored))
    }

    /// `None` where `AᵀA` is not positive definite in this arithmetic.
    pub(crate) fn cholesky(system: &System, dimensions: usize, mirrored: bool) -> Option<Self> {
        let (a, points) = (&system.a, system.b.nrows());
        let l = cholesky(a.transposed().times(a))?;
        let columns = l.ncols();
        let mut products = a.part(0..points, 0..columns).transposed();
        if system.offset() > 0 {
            let taken = a.transposed().times(&system.pinned);
            for j in 0..columns {
                products[(j, 0)] -= taken[(j, 0)];
                products[(j, points - 1)] -= taken[(j, 1)];
            }
        }
        Some(Self::Steps(Steps::Cholesky {
            rows: Rows::of_product(&products, mirrored),
            l,
            right: Matrix::zeros(columns, dimensions),
        }))
    }

    pub(crate) fn qr(factors: Qr, system: &System, dimensions: usize) -> Self {
        Self::Steps(Steps::Qr {
            right: Matrix::zeros(factors.nrows(), dimensions),
            pinned: system.pinned.clone(),
            factors,
        })
    }
}

impl Steps {
    /// The control points of `points`, which `lanes` holds in columns. Allocates nothing.
    pub(crate) fn solve<const D: usize>(
        &mut self,
        arch: lariat_portable::Arch,
        points: &[[f64; D]],
        lanes: &Points<D>,
        halves: &mut Halves<D>,
        control_points: &mut [[f64; D]],
    ) {
        match self {
            Self::Cholesky { rows, l, right } => {
                let solved = pin(points, control_points, right.nrows());
                project(arch, rows, lanes, halves, solved);
                write_columns(solved, right);
                for axis in 0..D {
                    solve_cholesky(l, right.column_mut(axis));
                }
                read_columns(right, solved);
            }
            Self::Qr {
                factors,
                pinned,
                right,
            } => {
                let solved = pin(points, control_points, factors.r().ncols());
                // Below the points stand the ridge's rows, which ask for 0.
                right.fill(0.0);
                write_columns(points, right);
                if pinned.ncols() > 0 {
                    let ends = points[0].into_iter().zip(points[points.len() - 1]);
                    for (axis, (first, last)) in ends.enumerate() {
                        for (i, number) in right.column_mut(axis).iter_mut().enumerate() {
                            *number -= pinned[(i, 0)] * first + pinned[(i, 1)] * last;
                        }
                    }
                }
                arch.dispatch(
                    #[inline(always)]
                    || {
                        for axis in 0..D {
                            let column = right.column_mut(axis);
                            factors.apply_transposed(column);
                            solve_upper(factors.r(), column);
                        }
                    },
                );
                read_columns(right, solved);
            }
        }
    }
}

/// Room for the two halves of a folded product.
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

/// Sets the outer control points where fewer than all are solved for; the others are returned.
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

fn write_columns<const D: usize>(points: &[[f64; D]], columns: &mut Matrix) {
    for axis in 0..D {
        for (number, point) in columns.column_mut(axis).iter_mut().zip(points) {
            *number = point[axis];
        }
    }
}

fn read_columns<const D: usize>(columns: &Matrix, points: &mut [[f64; D]]) {
    for axis in 0..D {
        for (number, point) in columns.column(axis).iter().zip(points.iter_mut()) {
            point[axis] = *number;
        }
    }
}
