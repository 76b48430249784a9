//! Finds the smooth sequence of numbers near measured numbers that minimizes `Σ info (x −
//! measured)² + λ Σ (second differences)²`.
//!
//! The matrix has five diagonals. It is factored into `L D Lᵀ`, with two diagonals below the main
//! one. The three diagonals of the inverse that are needed are computed from the last row up
//! (Takahashi).

/// A number of the sequence.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Knot {
    /// Information from the measurement of this number alone: the inverse of its variance, and this
    /// inverse times the measured value.
    pub info: f64,
    pub weighted: f64,
}

/// Working memory for the solution.
#[derive(Debug, Clone, Default)]
pub(super) struct Smooth {
    rows: Vec<Row>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Row {
    pivot: f64,
    below: [f64; 2],
    x: f64,
    /// Diagonal of the inverse, and the two next to it.
    inverse: [f64; 3],
}

/// How well a solution fits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// The minimized sum.
    pub sum: f64,
    /// Logarithm of the matrix's determinant.
    pub log_determinant: f64,
}

impl Smooth {
    /// Solves for a sequence of three or more numbers; `None` if too little is measured.
    pub(super) fn solve(&mut self, knots: &[Knot], stiffness: f64) -> Option<Fit> {
        let count = knots.len();
        self.rows.clear();
        let mut log_determinant = 0.0;
        for (i, knot) in knots.iter().enumerate() {
            // Sums of products of 1, −2, 1, as far as the sequence goes.
            let inner = |from: usize, to: usize| i >= from && i + to < count;
            let bends = [(2, 0, 1.0), (1, 1, 4.0), (0, 2, 1.0)];
            let own: f64 = (bends.iter())
                .filter(|&&(from, to, _)| inner(from, to))
                .map(|&(.., share)| share)
                .sum();
            let by_one: f64 = [(2, 0), (1, 1)]
                .iter()
                .filter(|&&(from, to)| inner(from, to))
                .map(|_| -2.0)
                .sum();
            let by_two = if i >= 2 { 1.0 } else { 0.0 };
            let [own, by_one, by_two] = [own, by_one, by_two].map(|share| stiffness * share);
            let one = i.checked_sub(1).map_or(Row::default(), |k| self.rows[k]);
            let two = i.checked_sub(2).map_or(Row::default(), |k| self.rows[k]);
            let second = if i >= 2 { by_two / two.pivot } else { 0.0 };
            let first = match i {
                0 => 0.0,
                _ => (by_one - second * one.below[0] * two.pivot) / one.pivot,
            };
            let pivot = knot.info + own - first * first * one.pivot - second * second * two.pivot;
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            log_determinant += libm::log(pivot);
            self.rows.push(Row {
                pivot,
                below: [first, second],
                x: knot.weighted - first * one.x - second * two.x,
                inverse: [0.0; 3],
            });
        }
        for i in (0..count).rev() {
            let below = |k: usize| match self.rows.get(i + k) {
                Some(row) => (row.below[k - 1], *row),
                None => (0.0, Row::default()),
            };
            let ((first, one), (second, two)) = (below(1), below(2));
            let row = &mut self.rows[i];
            row.x = row.x / row.pivot - first * one.x - second * two.x;
            let beside = -(first * one.inverse[0] + second * one.inverse[1]);
            let next = -(first * one.inverse[1] + second * two.inverse[0]);
            let own = 1.0 / row.pivot - first * beside - second * next;
            row.inverse = [own, beside, next];
        }
        let mut sum = 0.0;
        for (knot, row) in knots.iter().zip(&self.rows) {
            if knot.info > 0.0 {
                let off = knot.weighted / knot.info - row.x;
                sum += knot.info * off * off;
            }
        }
        for three in self.rows.windows(3) {
            let bend = three[0].x - 2.0 * three[1].x + three[2].x;
            sum += stiffness * bend * bend;
        }
        Some(Fit {
            sum,
            log_determinant,
        })
    }

    /// The numbers, each with its variance.
    pub(super) fn values(&self) -> impl Iterator<Item = (f64, f64)> {
        self.rows.iter().map(|row| (row.x, row.inverse[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::{Knot, Smooth};

    /// Solves the same problem by elimination of the full matrix.
    fn whole(knots: &[Knot], stiffness: f64) -> (Vec<f64>, Vec<f64>) {
        let n = knots.len();
        let mut m = vec![vec![0.0; 2 * n + 1]; n];
        for i in 0..n {
            m[i][i] += knots[i].info;
            m[i][n] = knots[i].weighted;
            m[i][n + 1 + i] = 1.0;
        }
        for i in 1..n - 1 {
            let bend = [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)];
            for (a, x) in bend {
                for (b, y) in bend {
                    m[a][b] += stiffness * x * y;
                }
            }
        }
        for i in 0..n {
            let pivot = m[i][i];
            m[i].iter_mut().for_each(|c| *c /= pivot);
            for j in 0..n {
                let factor = m[j][i];
                if j != i && factor != 0.0 {
                    let row = m[i].clone();
                    m[j].iter_mut().zip(row).for_each(|(c, r)| *c -= factor * r);
                }
            }
        }
        let values = m.iter().map(|row| row[n]).collect();
        (values, (0..n).map(|i| m[i][n + 1 + i]).collect())
    }

    #[test]
    fn the_solution_and_its_variances_are_those_of_the_whole_matrix() {
        for count in [3, 4, 7, 20] {
            let knots: Vec<Knot> = (0..count)
                .map(|i| {
                    let info = if i % 3 == 1 { 0.0 } else { 1.0 + i as f64 };
                    let weighted = info * f64::from(i * i % 7);
                    Knot { info, weighted }
                })
                .collect();
            let mut smooth = Smooth::default();
            smooth.solve(&knots, 2.5).expect("enough is known");
            let (values, variances) = whole(&knots, 2.5);
            for (k, (x, variance)) in smooth.values().enumerate() {
                assert!((x - values[k]).abs() < 1e-9, "{x} is not {}", values[k]);
                assert!((variance - variances[k]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_row_of_which_nothing_is_known_has_no_solution() {
        assert!(
            Smooth::default()
                .solve(&[Knot::default(); 5], 1.0)
                .is_none()
        );
    }
}
