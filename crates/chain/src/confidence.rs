//! The confidence in a rope, as commands show it.

/// Confidence below which a rope stands out: it is a calibrated probability, so that such a rope is rather wrong than right.
const LOW: f64 = 0.5;

/// Tells whether a rope of this confidence stands out. A value that is not a number does.
pub fn is_low(confidence: f64) -> bool {
    confidence.is_nan() || confidence < LOW
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rope_that_is_rather_wrong_than_right_stands_out() {
        assert!(is_low(0.49) && is_low(f64::NAN));
        assert!(!is_low(0.5) && !is_low(1.0));
    }
}
