//! Standard output. A closed pipe, as after `| head`, ends a command and is not a fault. Any other
//! write error is a fault.

use anyhow::{Context, Result};
use std::fmt;
use std::io::{self, Write};

/// Error: nobody reads standard output any more.
#[derive(Debug)]
pub struct Unread;

impl Unread {
    /// Returns true if this is the cause of an error.
    pub fn is_cause_of(error: &anyhow::Error) -> bool {
        let is_unread = |cause: &io::Error| cause.get_ref().is_some_and(|inner| inner.is::<Self>());
        error
            .chain()
            .filter_map(|cause| cause.downcast_ref())
            .any(is_unread)
    }
}

impl fmt::Display for Unread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("nobody reads it any more")
    }
}

impl std::error::Error for Unread {}

/// Prints a text immediately.
///
/// # Errors
/// Returns an error if standard output cannot be written, or if [nobody reads it](Unread).
pub fn print(text: &str) -> Result<()> {
    if text.is_empty() {
        return Ok(());
    }
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    kept(written).context("cannot write to standard output")
}

/// Marks a broken pipe with [`Unread`], which distinguishes standard output from other pipes.
pub(super) fn kept<T>(written: io::Result<T>) -> io::Result<T> {
    written.map_err(|cause| match cause.kind() {
        io::ErrorKind::BrokenPipe => io::Error::new(io::ErrorKind::BrokenPipe, Unread),
        _ => cause,
    })
}
