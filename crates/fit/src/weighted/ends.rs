//! Pins a curve to its first and its last point exactly.
//!
//! In the coordinates `y` of `weighted`, a point of the curve is `zᵢᵀy`, and pinning both ends
//! means `Vᵀy = p` with `V = [z₀ z₍N₋₁₎]`. The best such `y` is the free one, corrected along `V`:
//!
//! ```text
//! y + V Q⁻¹ (p − Vᵀy),   Q = VᵀV
//! ```
//!
//! The ends have weight 1 in the free fit. This does not change the pinned fit, and keeps the free
//! fit determined if only the pins determine the curve. It also makes `Q ≤ 1`. The noise in `y` is
//! `I − VQ⁻¹Vᵀ` from the points between, and `VQ⁻²Vᵀ` from the two ends, together `I + VJVᵀ` with
//! `J = Q⁻² − Q⁻¹`.

/// `V` and `Q⁻¹`.
pub(super) struct Ends {
    /// `V`, row by row.
    pub(super) v: Vec<[f64; 2]>,
    q_inverse: [[f64; 2]; 2],
}

impl Ends {
    pub(super) fn new(count: usize) -> Self {
        Self {
            v: vec![[0.0; 2]; count],
            q_inverse: [[0.0; 2]; 2],
        }
    }

    /// Sets `V`, whose row `j` is `z(j)`.
    pub(super) fn set(&mut self, z: impl Fn(usize) -> [f64; 2]) {
        let (mut first, mut mixed, mut last) = (0.0, 0.0, 0.0);
        for (j, v) in self.v.iter_mut().enumerate() {
            *v = z(j);
            first += v[0] * v[0];
            mixed += v[0] * v[1];
            last += v[1] * v[1];
        }
        let determinant = first * last - mixed * mixed;
        self.q_inverse = [
            [last / determinant, -mixed / determinant],
            [-mixed / determinant, first / determinant],
        ];
    }

    /// Corrects `y` so that the curve's ends are `pinned`.
    pub(super) fn pin<const D: usize>(&self, pinned: [[f64; D]; 2], y: &mut [[f64; D]]) {
        for axis in 0..D {
            let pinned = pinned.map(|point| point[axis]);
            let correction = self.correction(pinned, |j| y[j][axis]);
            for (y, v) in y.iter_mut().zip(&self.v) {
                y[axis] += v[0] * correction[0] + v[1] * correction[1];
            }
        }
    }

    /// `Q⁻¹ (p − Vᵀy)` of one coordinate.
    fn correction(&self, pinned: [f64; 2], y: impl Fn(usize) -> f64) -> [f64; 2] {
        let mut left = pinned;
        for (j, v) in self.v.iter().enumerate() {
            left[0] -= v[0] * y(j);
            left[1] -= v[1] * y(j);
        }
        times(&self.q_inverse, left)
    }

    /// `J = Q⁻² − Q⁻¹`.
    pub(super) fn j(&self) -> [[f64; 2]; 2] {
        let [first, last] = self.q_inverse.map(|row| times(&self.q_inverse, row));
        let q = &self.q_inverse;
        [
            [first[0] - q[0][0], first[1] - q[0][1]],
            [last[0] - q[1][0], last[1] - q[1][1]],
        ]
    }

    /// `tr Q⁻¹ − 2 − tr(Q⁻² VᵀKV)`, the degrees of freedom that pinning returns: the ends' own
    /// noise, which appears in the residuals of the points between.
    pub(super) fn freedom(&self, k: Option<&[f64]>) -> f64 {
        let q = &self.q_inverse;
        let mut freedom = q[0][0] + q[1][1] - 2.0;
        if let Some(k) = k {
            // w = V Q⁻¹: the trace is Σ wᵀ K w over its two columns.
            let rows = k.chunks_exact(self.v.len());
            for (v, row) in self.v.iter().zip(rows) {
                let w = times(q, *v);
                for (u, &number) in self.v.iter().zip(row) {
                    let u = times(q, *u);
                    freedom -= number * (w[0] * u[0] + w[1] * u[1]);
                }
            }
        }
        freedom
    }

    /// Replaces the symmetric `k` by `ΠKΠ`, `Π = I − VQ⁻¹Vᵀ`.
    pub(super) fn project(&self, k: &mut [f64]) {
        let count = self.v.len();
        // Π on each row, then on each column.
        for (step, along) in [(count, 1), (1, count)] {
            for line in 0..count {
                let at = |i: usize| line * step + i * along;
                let shift = self.correction([0.0; 2], |i| k[at(i)]);
                for (i, v) in self.v.iter().enumerate() {
                    k[at(i)] += v[0] * shift[0] + v[1] * shift[1];
                }
            }
        }
    }
}

/// A symmetric matrix times a vector.
fn times(m: &[[f64; 2]; 2], x: [f64; 2]) -> [f64; 2] {
    m.map(|row| row[0] * x[0] + row[1] * x[1])
}
