//! Running medians along a centerline: the median of each coordinate over nine neighbors (J. W.
//! Tukey, *Exploratory Data Analysis*, 1977). Four of the nine may be arbitrary outliers. On a bent
//! rope the medians cut corners slightly, so they are a start and not a result.

use lariat_portable::{Simd, WithSimd};

/// Number of neighbors in a median.
const WINDOW: usize = 9;

/// Maximum number of windows sorted in parallel.
const LANES: usize = 8;

/// Exchanges that bring the median of nine to the middle (J. L. Smith's network, as in A. W. Paeth,
/// *Median finding on a 3 × 3 grid*, Graphics Gems, 1990): the smaller number goes to the first
/// place.
const EXCHANGES: [(usize, usize); 19] = [
    (1, 2),
    (4, 5),
    (7, 8),
    (0, 1),
    (3, 4),
    (6, 7),
    (1, 2),
    (4, 5),
    (7, 8),
    (0, 3),
    (5, 8),
    (4, 7),
    (3, 6),
    (1, 4),
    (2, 5),
    (4, 7),
    (4, 2),
    (6, 4),
    (4, 2),
];

/// Scratch memory for the medians of one column, and the chosen points.
pub(super) struct Medians {
    /// Indices of the visible points, in order.
    seen: Vec<usize>,
    /// Their numbers, padded for a last window that is not full.
    numbers: Vec<f64>,
    medians: Vec<f64>,
}

impl Medians {
    pub(super) fn new(points: usize) -> Self {
        Self {
            seen: Vec::with_capacity(points),
            numbers: vec![0.0; points + LANES + WINDOW],
            medians: vec![0.0; points + LANES],
        }
    }

    /// Chooses the points whose weight is not 0. Returns false if there are too few for a median.
    pub(super) fn choose(&mut self, weights: &[f64]) -> bool {
        self.seen.clear();
        for (i, &weight) in weights.iter().enumerate() {
            if weight > 0.0 {
                self.seen.push(i);
            }
        }
        self.seen.len() >= WINDOW
    }

    /// Writes the median of `column` over the nine chosen points around each chosen point to
    /// `medians`. For the first and the last four points, it is the median of the first and the
    /// last nine. Other entries are 0.
    pub(super) fn run(&mut self, arch: lariat_portable::Arch, column: &[f64], medians: &mut [f64]) {
        for (number, &at) in self.numbers.iter_mut().zip(&self.seen) {
            *number = column[at];
        }
        let windows = self.seen.len() + 1 - WINDOW;
        arch.dispatch(Sort {
            numbers: &self.numbers,
            windows,
            medians: &mut self.medians,
        });
        medians.fill(0.0);
        for (place, &at) in self.seen.iter().enumerate() {
            medians[at] = self.medians[place.saturating_sub(WINDOW / 2).min(windows - 1)];
        }
    }
}

/// Computes `medians[i]` of nine `numbers` from the `i`-th.
struct Sort<'a> {
    numbers: &'a [f64],
    windows: usize,
    medians: &'a mut [f64],
}

impl WithSimd for Sort<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for from in (0..self.windows).step_by(S::F64_LANES) {
            let mut sorted = [simd.splat_f64s(0.0); WINDOW];
            for (k, lanes) in sorted.iter_mut().enumerate() {
                let at = from + k..from + k + S::F64_LANES;
                *lanes = S::as_simd_f64s(&self.numbers[at]).0[0];
            }
            for (first, second) in EXCHANGES {
                let (a, b) = (sorted[first], sorted[second]);
                sorted[first] = simd.min_f64s(a, b);
                sorted[second] = simd.max_f64s(a, b);
            }
            let to = &mut self.medians[from..from + S::F64_LANES];
            S::as_mut_simd_f64s(to).0[0] = sorted[WINDOW / 2];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn they_are_the_middle_of_nine_sorted_numbers(
            points in prop::collection::vec((-1e3f64..1e3, any::<bool>()), 0..60),
        ) {
            let column: Vec<f64> = points.iter().map(|(number, _)| *number).collect();
            let weights: Vec<f64> = points.iter().map(|(_, seen)| f64::from(u8::from(*seen))).collect();
            let mut medians = Medians::new(points.len());
            let kept: Vec<usize> = (0..points.len()).filter(|&i| points[i].1).collect();
            prop_assert_eq!(medians.choose(&weights), kept.len() >= 9);
            if kept.len() < 9 {
                return Ok(());
            }
            let mut found = vec![f64::NAN; points.len()];
            medians.run(lariat_portable::Arch::new(), &column, &mut found);
            for (i, &found) in found.iter().enumerate() {
                let expected = match kept.iter().position(|&at| at == i) {
                    None => 0.0,
                    Some(place) => {
                        let from = place.saturating_sub(4).min(kept.len() - 9);
                        let mut window: Vec<f64> = kept[from..from + 9].iter().map(|&at| column[at]).collect();
                        window.sort_by(f64::total_cmp);
                        window[4]
                    }
                };
                prop_assert_eq!(found, expected);
            }
        }
    }
}
