//! Messages between a stage and its chain: lines of text.

use lariat_chain::stages::status::{LastWord, Word};

/// Parses lines that may be messages between a stage and its chain. A valid one survives a round
/// trip through text.
///
/// # Panics
/// Panics if an invariant does not hold.
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
