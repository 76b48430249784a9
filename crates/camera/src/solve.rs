//! Solves eight linear equations in eight unknowns.

pub(crate) const SIZE: usize = 8;

/// Smallest pivot, as a share of the largest number in its row. A smaller one is a rounding error:
/// the points do not determine a homography.
const LEAST_PIVOT: f64 = 1e-11;

/// Solves `a x = b` by elimination with scaled partial pivoting; `None` if `a` is singular except
/// for rounding.
pub(crate) fn solve(mut a: [[f64; SIZE]; SIZE], mut b: [f64; SIZE]) -> Option<[f64; SIZE]> {
    let largest = |row: &[f64; SIZE]| row.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    // Scales the rows alike, so that pivots can be compared.
    for (row, right) in a.iter_mut().zip(&mut b) {
        let scale = largest(row);
        let sound = scale.is_finite() && scale > 0.0;
        sound.then_some(())?;
        row.iter_mut().for_each(|x| *x /= scale);
        *right /= scale;
    }
    for k in 0..SIZE {
        let pivot = (k..SIZE).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        a.swap(k, pivot);
        b.swap(k, pivot);
        let sound = a[k][k].abs() > LEAST_PIVOT;
        sound.then_some(())?;
        let (row, right) = (a[k], b[k]);
        for i in k + 1..SIZE {
            let factor = a[i][k] / row[k];
            for j in k..SIZE {
                a[i][j] -= factor * row[j];
            }
            b[i] -= factor * right;
        }
    }
    for k in (0..SIZE).rev() {
        let known: f64 = (k + 1..SIZE).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b.iter().all(|x| x.is_finite()).then_some(b)
}
