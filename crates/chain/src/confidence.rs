//! The confidence in a rope, as commands show it.

use lariat_wire::MIN_CONFIDENCE;

/// Tells whether a rope of this confidence stands out: below [`MIN_CONFIDENCE`]. A value that is not a number does.
pub fn is_low(confidence: f64) -> bool {
    confidence.is_nan() || confidence < f64::from(MIN_CONFIDENCE)
}

/// The word for how much of a rope is seen: its status, or `unsure` where the confidence of one that is in sight is low.
pub fn status_word(status: &str, confidence: f64) -> &str {
    match status {
        "ok" | "partial" if is_low(confidence) => "unsure",
        _ => status,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rope_that_is_rather_wrong_than_right_stands_out() {
        assert!(is_low(0.49) && is_low(f64::NAN));
        assert!(!is_low(0.5) && !is_low(1.0));
        let words = ["ok", "partial", "lost"].map(|status| status_word(status, 0.05));
        assert_eq!(words, ["unsure", "unsure", "lost"]);
        assert_eq!(status_word("ok", 0.9), "ok");
    }
}
