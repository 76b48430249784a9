//! What a stage and its chain say to each other: lines of text.

use lariat_chain::stages::status::{LastWord, Word};

/// Lines that may be words between a stage and its chain. What is one is said again as it was meant.
///
/// # Panics
/// Something does not hold.
pub fn words(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    for line in text.lines() {
        match line.parse::<Word>() {
            Ok(word) => assert_eq!(word.to_string().parse().ok(), Some(word)),
            Err(cause) => assert!(!cause.to_string().is_empty()),
        }
    }
    match text.parse::<LastWord>() {
        Ok(word) => assert_eq!(word.to_string().parse().ok(), Some(word)),
        Err(cause) => assert!(!cause.to_string().is_empty()),
    }
}
