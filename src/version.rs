//! What `lariat --version` says beside the version: whose commit it is, what was built into it, and where it computes here.

use std::sync::LazyLock;

use lariat_portable::Arch;

/// The version, and a line for each of the others.
pub(crate) fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        format!(
            "{}\ncommit:   {}\nfeatures: {}\nSIMD:     {}",
            env!("CARGO_PKG_VERSION"),
            env!("LARIAT_COMMIT"),
            if cfg!(feature = "lab") { "lab" } else { "none" },
            Arch::new()
        )
    });
    &LONG
}
