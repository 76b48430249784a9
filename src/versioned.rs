//! The version of the keys in a command's JSON.

use serde::Serialize;

/// A JSON object with `schema`, the version of its keys, first. New keys may come without a new version; a key that goes or
/// changes its meaning needs one.
#[derive(Serialize)]
pub(crate) struct Versioned<T> {
    schema: u32,
    #[serde(flatten)]
    content: T,
}

impl<T> Versioned<T> {
    /// The first version.
    pub(crate) fn first(content: T) -> Self {
        Self { schema: 1, content }
    }
}
