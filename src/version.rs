//! Output of `lariat --version`: the version, the commit, and the vector instructions in use here.

use std::sync::LazyLock;

use lariat_portable::Arch;

/// The version, followed by a line for each of the other facts.
pub(crate) fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        format!(
            "{}\ncommit: {}\nSIMD:   {}",
            env!("CARGO_PKG_VERSION"),
            env!("LARIAT_COMMIT"),
            Arch::new()
        )
    });
    &LONG
}
