//! The distribution of a number over many shapes: its median, quartiles, and the range of nine
//! tenths.

/// Quantiles of some numbers. NaN if there are none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Number of values.
    pub count: usize,
    /// 5 % quantile.
    pub p5: f64,
    /// Lower quartile.
    pub p25: f64,
    /// Median.
    pub median: f64,
    /// Upper quartile.
    pub p75: f64,
    /// 95 % quantile.
    pub p95: f64,
}

impl Spread {
    /// Computes the quantiles of all finite values in `numbers`.
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = numbers.into_iter().filter(|x| x.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        Self {
            count: sorted.len(),
            p5: quantile(&sorted, 0.05),
            p25: quantile(&sorted, 0.25),
            median: quantile(&sorted, 0.5),
            p75: quantile(&sorted, 0.75),
            p95: quantile(&sorted, 0.95),
        }
    }
}

/// Returns the `share` quantile of sorted numbers, which may be infinite. NaN if there are none.
///
/// Interpolates between the two nearest numbers by the rule that most programs use, Hyndman and
/// Fan's seventh.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = share * last as f64;
    let below = (place as usize).min(last);
    let above = (below + 1).min(last);
    let part = place - below as f64;
    if part == 0.0 || sorted[below] == sorted[above] {
        return sorted[below];
    }
    sorted[below] + part * (sorted[above] - sorted[below])
}

/// Returns the mean. NaN if there are no numbers.
pub fn mean(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for number in numbers {
        sum += number;
        count += 1;
    }
    sum / count as f64
}

/// Returns the median. NaN if there are no finite numbers.
pub fn median(numbers: impl IntoIterator<Item = f64>) -> f64 {
    Spread::of(numbers).median
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_the_numbers() {
        let spread = Spread::of([4.0, 0.0, 1.0, 3.0, 2.0, f64::NAN]);
        assert_eq!(spread.count, 5);
        assert_eq!([spread.p25, spread.median, spread.p75], [1.0, 2.0, 3.0]);
        assert!((spread.p5 - 0.2).abs() < 1e-12 && (spread.p95 - 3.8).abs() < 1e-12);
        assert_eq!(median([5.0]), 5.0);
        assert!(median([]).is_nan());
        let late = [1.0, 2.0, f64::INFINITY, f64::INFINITY];
        assert_eq!(
            [0.0, 0.5, 0.9].map(|share| quantile(&late, share)),
            [1.0, f64::INFINITY, f64::INFINITY]
        );
    }
}
