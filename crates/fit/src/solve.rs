//! `s = (BᵀB)⁻¹ Bᵀ c̄` (equation 8 of the paper) in three ways, all of their algebra done beforehand.

use crate::folded::{FoldedPoints, FoldedRows, unfold};
use crate::kernel::Project;
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

    fn r(&self) -> MatRef<'_, f64> {
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

/// One of the three ways, ready.
pub(crate) enum Solve {
    /// The folded rows of `(BᵀB)⁻¹Bᵀ`.
    Pinv { rows: FoldedRows },
    /// The folded rows of `Bᵀ`, the factor `L` of `BᵀB = LLᵀ`, and room for the right-hand sides.
    Cholesky {
        rows: FoldedRows,
        l: Mat<f64>,
        right: Mat<f64>,
    },
    /// The factors of `B`, and room for the right-hand sides.
    Qr { factors: QrOfB, right: Mat<f64> },
}

impl Solve {
    pub(crate) fn pinv(pseudoinverse: &Mat<f64>) -> Self {
        Self::Pinv {
            rows: FoldedRows::of_product(pseudoinverse.as_ref()),
        }
    }

    /// `None` where `BᵀB` is not positive definite in this arithmetic.
    pub(crate) fn cholesky(b: &Mat<f64>) -> Option<Self> {
        let mut l = b.transpose() * b;
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
        Some(Self::Cholesky {
            rows: FoldedRows::of_product(b.transpose()),
            l,
            right: Mat::zeros(columns, 2),
        })
    }

    pub(crate) fn qr(factors: QrOfB) -> Self {
        let right = Mat::zeros(factors.basis.nrows(), 2);
        Self::Qr { factors, right }
    }

    /// The control points of `points`, which `folded` holds folded; `even` and `odd` are room for halves.
    /// Allocates nothing.
    pub(crate) fn solve(
        &mut self,
        arch: pulp::Arch,
        points: &[[f64; 2]],
        folded: &FoldedPoints,
        [even, odd]: [&mut [[f64; 2]]; 2],
        control_points: &mut [[f64; 2]],
    ) {
        match self {
            Self::Pinv { rows } => {
                arch.dispatch(Project {
                    rows,
                    points: folded,
                    even,
                    odd,
                });
                unfold(even, odd, control_points);
            }
            Self::Cholesky { rows, l, right } => {
                arch.dispatch(Project {
                    rows,
                    points: folded,
                    even,
                    odd,
                });
                unfold(even, odd, control_points);
                write_columns(control_points, right);
                solve_lower_triangular_in_place(l.as_ref(), right.as_mut(), Par::Seq);
                solve_upper_triangular_in_place(l.transpose(), right.as_mut(), Par::Seq);
                read_columns(right, control_points);
            }
            Self::Qr { factors, right } => {
                write_columns(points, right);
                factors.apply_q_transposed(right.as_mut());
                let columns = control_points.len();
                solve_upper_triangular_in_place(
                    factors.r(),
                    right.as_mut().subrows_mut(0, columns),
                    Par::Seq,
                );
                read_columns(right, control_points);
            }
        }
    }
}

fn write_columns(points: &[[f64; 2]], columns: &mut Mat<f64>) {
    for (axis, column) in columns.col_iter_mut().enumerate() {
        for (number, point) in column.iter_mut().zip(points) {
            *number = point[axis];
        }
    }
}

fn read_columns(columns: &Mat<f64>, points: &mut [[f64; 2]]) {
    for (axis, column) in columns.col_iter().enumerate() {
        for (number, point) in column.iter().zip(points.iter_mut()) {
            point[axis] = *number;
        }
    }
}
