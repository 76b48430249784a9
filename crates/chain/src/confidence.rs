//! How commands show the confidence in a rope.

use lariat_wire::MIN_CONFIDENCE;

/// Returns true if the confidence is below [`MIN_CONFIDENCE`] or not a number. Such a rope is
/// highlighted.
pub fn is_low(confidence: f64) -> bool {
    confidence.is_nan() || confidence < f64::from(MIN_CONFIDENCE)
}

/// Returns the word that describes a rope: its status, or `unsure` if the rope is in sight and its
/// confidence is low.
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
