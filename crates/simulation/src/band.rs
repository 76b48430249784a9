//! Symmetric positive definite systems with entries only near the diagonal.

/// Lower half of a banded matrix, row by row: `rows[r][d]` is the entry in row r, column r − d.
/// `WIDTH` entries per row may be nonzero. The system is solved in place by A = L D Lᵀ (Golub and
/// Van Loan, *Matrix Computations*, 4.3.5), with sums in a fixed order.
#[derive(Debug, Clone)]
pub(crate) struct Band<const WIDTH: usize> {
    pub(crate) rows: Vec<[f64; WIDTH]>,
}

impl<const WIDTH: usize> Band<WIDTH> {
    /// Number of entries next to the diagonal.
    pub(crate) const BESIDE: usize = WIDTH - 1;

    /// Makes a matrix of zeros.
    pub(crate) fn new(size: usize) -> Self {
        Self {
            rows: vec![[0.0; WIDTH]; size],
        }
    }

    /// Replaces the right-hand side by the solution, and the matrix by its factors.
    pub(crate) fn solve(&mut self, side: &mut [f64]) {
        self.factorize();
        let rows = &self.rows;
        for r in 0..rows.len() {
            for d in 1..=Self::BESIDE.min(r) {
                side[r] -= rows[r][d] * side[r - d];
            }
        }
        for (value, row) in side.iter_mut().zip(rows) {
            *value /= row[0];
        }
        for r in (0..rows.len()).rev() {
            for d in 1..=Self::BESIDE.min(r) {
                side[r - d] -= rows[r][d] * side[r];
            }
        }
    }

    /// Factors the matrix into L below the diagonal and D on it.
    fn factorize(&mut self) {
        let rows = &mut self.rows;
        for r in 0..rows.len() {
            let mut row = rows[r];
            let mut pivot = row[0];
            // From the leftmost column on: each entry needs the entries before it, which still
            // contain L times D.
            for d in (1..=Self::BESIDE.min(r)).rev() {
                let column = rows[r - d];
                for e in d + 1..=Self::BESIDE.min(r) {
                    row[d] -= row[e] * column[e - d];
                }
            }
            for d in (1..=Self::BESIDE.min(r)).rev() {
                let scaled = row[d];
                row[d] = scaled / rows[r - d][0];
                pivot -= scaled * row[d];
            }
            row[0] = pivot;
            rows[r] = row;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_solves_the_system() {
        solves::<5>();
        solves::<11>();
    }

    fn solves<const WIDTH: usize>() {
        let size = 40;
        let mut band = Band::<WIDTH>::new(size);
        for r in 0..size {
            for d in 0..=Band::<WIDTH>::BESIDE.min(r) {
                let wave = ((7 * r + 3 * d) % 11) as f64 / 11.0 - 0.5;
                band.rows[r][d] = if d == 0 { 12.0 + wave } else { wave };
            }
        }
        let entry = |i: usize, j: usize| {
            let (r, d) = (i.max(j), i.abs_diff(j));
            if d < WIDTH { band.rows[r][d] } else { 0.0 }
        };
        let truth: Vec<f64> = (0..size).map(|i| (i % 5) as f64 - 2.0).collect();
        let mut side: Vec<f64> = (0..size)
            .map(|i| (0..size).map(|j| entry(i, j) * truth[j]).sum())
            .collect();
        band.clone().solve(&mut side);
        for (found, truth) in side.iter().zip(&truth) {
            assert!((found - truth).abs() < 1e-12, "{found} {truth}");
        }
    }
}
