//! What lariat's exit code says, of every command:
//!
//! | code | |
//! |---|---|
//! | 0 | done |
//! | 1 | it ran, and the answer is no, or something failed or was lost |
//! | 2 | it did not begin: the command line or the settings make no sense |

use crate::settings::Problems;
use std::fmt;
use std::process::ExitCode;

/// The same in the help.
pub const CODES: &str = "Exit codes: 0 done; 1 the answer is no, or something failed or was lost;\n\
                                2 the command line or the settings make no sense.";

/// What was asked makes no sense, whatever the machine and the files. Its text is a sentence that says what to do.
#[derive(Debug)]
pub struct WrongUse(pub String);

impl fmt::Display for WrongUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for WrongUse {}

/// Leaves the function with a [`WrongUse`].
#[macro_export]
macro_rules! wrong_use {
    ($($text:tt)*) => {
        return Err($crate::exit::WrongUse(format!($($text)*)).into())
    };
}
pub use crate::wrong_use;

/// The code of an error.
pub fn code(error: &anyhow::Error) -> ExitCode {
    let is_wrong_use = |cause: &(dyn std::error::Error + 'static)| {
        cause.is::<WrongUse>() || cause.is::<Problems>()
    };
    match error.chain().any(is_wrong_use) {
        true => ExitCode::from(2),
        false => ExitCode::FAILURE,
    }
}
