//! Exit codes of all commands:
//!
//! | code | |
//! |---|---|
//! | 0 | done |
//! | 1 | the command ran, and the answer is no, or something failed or was lost |
//! | 2 | wrong use: the command line or the settings make no sense |
//!
//! [`is_wrong_use`] decides between 1 and 2. Wrong use is a [`WrongUse`] or [`Problems`] anywhere
//! in an error's chain, or an invalid name for a rig or a domain. The code is 1 if an input file, a
//! camera, a rig or a chain is missing, or if an output file already exists. The same command may
//! work later. A settings file that cannot be read leaves every setting unknown, so the code is 2.
//! A running chain marks its refusal of a change as wrong use, and the client exits with that code
//! (`control.rs`).

use crate::settings::Problems;
use lariat_wire::WireError;
use std::fmt;
use std::process::ExitCode;

/// The exit codes as the help shows them.
pub const CODES: &str = "Exit codes: 0 done; 1 failed, or a check failed; 2 wrong use or settings.";

/// A request that makes no sense, regardless of the machine and its files. The text is a sentence
/// that tells the user what to do.
#[derive(Debug)]
pub struct WrongUse(pub String);

impl fmt::Display for WrongUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for WrongUse {}

/// Returns from the function with a [`WrongUse`].
#[macro_export]
macro_rules! wrong_use {
    ($($text:tt)*) => {
        return Err($crate::exit::WrongUse(format!($($text)*)).into())
    };
}
pub use crate::wrong_use;

/// Returns true for an error in the command line or in the settings.
pub fn is_wrong_use(error: &anyhow::Error) -> bool {
    let names =
        |cause: &WireError| matches!(cause, WireError::RigName(_) | WireError::DomainName(_));
    // In the iterator of causes, an error that was added as context has another type. Only `error`
    // itself can be downcast to it.
    let has_context = error.downcast_ref::<WrongUse>().is_some();
    let is_one = |cause: &(dyn std::error::Error + 'static)| {
        cause.is::<WrongUse>() || cause.is::<Problems>() || cause.downcast_ref().is_some_and(names)
    };
    has_context || error.chain().any(is_one)
}

/// Returns the exit code for an error.
pub fn code(error: &anyhow::Error) -> ExitCode {
    match is_wrong_use(error) {
        true => ExitCode::from(2),
        false => ExitCode::FAILURE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::{Context, Result, anyhow, bail};

    fn refused() -> Result<()> {
        wrong_use!("write 2, not {}", 3);
    }

    fn failed() -> Result<()> {
        bail!("the disk is full")
    }

    #[test]
    fn wrong_use_is_known_under_any_context_and_other_failures_are_not() {
        assert!(is_wrong_use(&refused().unwrap_err()));
        assert!(is_wrong_use(
            &refused().context("of --control-points").unwrap_err()
        ));
        assert!(is_wrong_use(&Problems::default().into()));
        let rig = "Not A Name".parse::<lariat_wire::Rig>().unwrap_err();
        assert!(is_wrong_use(&rig.into()));
        assert!(!is_wrong_use(&failed().context("of --out").unwrap_err()));
    }

    #[test]
    fn a_failure_that_is_laid_to_wrong_use_is_wrong_use() {
        let failure = std::io::Error::other("it is not UTF-8 text");
        let blamed = anyhow!(failure).context(WrongUse("cannot read the settings".to_owned()));
        assert!(is_wrong_use(&blamed));
        assert_eq!(
            format!("{blamed:#}"),
            "cannot read the settings: it is not UTF-8 text"
        );
    }
}
