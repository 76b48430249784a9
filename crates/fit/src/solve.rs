//! `s = (BᵀB)⁻¹ Bᵀ c̄` (equation 8 of the paper) in three ways, all of their algebra done beforehand.

use crate::folded::{Points, Rows};
use crate::kernel::Project;
use crate::system::System;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::qr::no_pivoting as qr;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, MatRef, Par};

/// Householder QR of `B`, as faer keeps it.
pub(crate) struct QrOfB {
    /// The reflections, below the diagonal; `R` on and above it.
    basis: Mat<f64>,
    /// The blocks' triangular factors.
    coefficients: Mat<f64>,
    scratch: MemBuffer,
}

impl QrOfB {
    pub(crate) fn new(b: &Mat<f64>) -> Self {
        let (rows, columns) = (b.nrows(), b.ncols());
        let block = qr::factor::recommended_block_size::<f64>(rows, columns);
        let mut basis = b.clone();
        let mut coefficients = Mat::zeros(block, columns);
        let factor_scratch = qr::factor::qr_in_place_scratch::<f64>(
            rows,
            columns,
            block,
            Par::Seq,
            Default::default(),
        );
        qr::factor::qr_in_place(
            basis.as_mut(),
            coefficients.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(factor_scratch)),
            Default::default(),
        );
        // Sized for the widest right-hand side: the identity, when the inverse is made.
        let scratch = MemBuffer::new(qr::solve::solve_lstsq_in_place_scratch::<f64>(
            rows,
            columns,
            block,
            rows,
            Par::Seq,
        ));
        Self {
            basis,
            coefficients,
            scratch,
        }
    }

    /// Replaces `right` by `Qᵀ right`.
    fn apply_q_transposed(&mut self, right: faer::MatMut<'_, f64>) {
        faer::linalg::householder::apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj(
            self.basis.as_ref(),
            self.coefficients.as_ref(),
            faer::Conj::No,
            right,
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }

    pub(crate) fn r(&self) -> MatRef<'_, f64> {
        let columns = self.basis.ncols();
        self.basis.get(..columns, ..)
    }

    /// `(BᵀB)⁻¹Bᵀ = R⁻¹Qᵀ`, (n+1) × N.
    ///
    /// `Y = R⁻¹` is solved from the left, row by row (`Y R = I`, as `Rᵀ Yᵀ = I`): then `Y R` is the identity
    /// up to ε cond(B). Solved column by column (`R X = Qᵀ`), `X B` would be so only up to ε cond(B)², and a
    /// product with `X` would not give a curve's own control points back at high order.
    pub(crate) fn pseudoinverse(&mut self) -> Mat<f64> {
        let (rows, columns) = (self.basis.nrows(), self.basis.ncols());
        let mut q_transposed = Mat::<f64>::identity(rows, rows);
        self.apply_q_transposed(q_transposed.as_mut());
        let mut y_transposed = Mat::<f64>::identity(columns, columns);
        solve_lower_triangular_in_place(self.r().transpose(), y_transposed.as_mut(), Par::Seq);
        y_transposed.transpose() * q_transposed.get(..columns, ..)
    }
}

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
        l: Mat<f64>,
        right: Mat<f64>,
    },
    /// The factors of `A`, what the pinned ends take from its right-hand sides, and room for these.
    Qr {
        factors: QrOfB,
        pinned: Mat<f64>,
        right: Mat<f64>,
    },
}

impl Solve {
    pub(crate) fn pinv(p: MatRef<'_, f64>, mirrored: bool) -> Self {
        Self::Product(Rows::of_product(p, mirrored))
    }

    /// `None` where `AᵀA` is not positive definite in this arithmetic.
    pub(crate) fn cholesky(system: &System, dimensions: usize, mirrored: bool) -> Option<Self> {
        let (a, points) = (&system.a, system.b.nrows());
        let mut l = a.transpose() * a;
        let columns = l.ncols();
        let scratch =
            llt::factor::cholesky_in_place_scratch::<f64>(columns, Par::Seq, Default::default());
        llt::factor::cholesky_in_place(
            l.as_mut(),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        )
        .ok()?;
        let mut products = a.get(..points, ..).transpose().to_owned();
        if system.offset() > 0 {
            let taken = a.transpose() * &system.pinned;
            for j in 0..columns {
                products[(j, 0)] -= taken[(j, 0)];
                products[(j, points - 1)] -= taken[(j, 1)];
            }
        }
        Some(Self::Steps(Steps::Cholesky {
            rows: Rows::of_product(products.as_ref(), mirrored),
            l,
            right: Mat::zeros(columns, dimensions),
        }))
    }

    pub(crate) fn qr(factors: QrOfB, system: &System, dimensions: usize) -> Self {
        Self::Steps(Steps::Qr {
            right: Mat::zeros(factors.basis.nrows(), dimensions),
            pinned: system.pinned.clone(),
            factors,
        })
    }
}

impl Steps {
    /// The control points of `points`, which `lanes` holds in columns. Allocates nothing.
    pub(crate) fn solve<const D: usize>(
        &mut self,
        arch: pulp::Arch,
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
                solve_lower_triangular_in_place(l.as_ref(), right.as_mut(), Par::Seq);
                solve_upper_triangular_in_place(l.transpose(), right.as_mut(), Par::Seq);
                read_columns(right, solved);
            }
            Self::Qr {
                factors,
                pinned,
                right,
            } => {
                let solved = pin(points, control_points, factors.basis.ncols());
                // Below the points stand the ridge's rows, which ask for 0.
                right.fill(0.0);
                write_columns(points, right);
                if pinned.ncols() > 0 {
                    let ends = [points[0], points[points.len() - 1]];
                    for (axis, column) in right.col_iter_mut().enumerate() {
                        for (i, number) in column.iter_mut().enumerate() {
                            *number -=
                                pinned[(i, 0)] * ends[0][axis] + pinned[(i, 1)] * ends[1][axis];
                        }
                    }
                }
                factors.apply_q_transposed(right.as_mut());
                let columns = solved.len();
                solve_upper_triangular_in_place(
                    factors.r(),
                    right.as_mut().subrows_mut(0, columns),
                    Par::Seq,
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
    arch: pulp::Arch,
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

fn write_columns<const D: usize>(points: &[[f64; D]], columns: &mut Mat<f64>) {
    for (axis, column) in columns.col_iter_mut().enumerate() {
        for (number, point) in column.iter_mut().zip(points) {
            *number = point[axis];
        }
    }
}

fn read_columns<const D: usize>(columns: &Mat<f64>, points: &mut [[f64; D]]) {
    for (axis, column) in columns.col_iter().enumerate() {
        for (number, point) in column.iter().zip(points.iter_mut()) {
            point[axis] = *number;
        }
    }
}
