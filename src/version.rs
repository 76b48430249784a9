//! What `lariat --version` says besides the version: the commit, and the vector instructions it uses here.

use std::sync::LazyLock;

use lariat_portable::Arch;

/// The version, and a line for each of the others.
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
