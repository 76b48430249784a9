//! Version of the keys in a command's JSON.

use serde::Serialize;

/// A JSON object that begins with `schema`, the version of its keys. A new key does not need a new
/// version; a key that is removed or changes its meaning does.
#[derive(Serialize)]
pub(crate) struct Versioned<T> {
    schema: u32,
    #[serde(flatten)]
    content: T,
}

impl<T> Versioned<T> {
    /// Wraps content with the first version of its keys.
    pub(crate) fn first(content: T) -> Self {
        Self { schema: 1, content }
    }
}
