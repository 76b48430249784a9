//! Locates the program `lariat`, which measurements start the same way as users do.

use std::env;
use std::path::PathBuf;

use anyhow::{Context, Result};

/// Finds `lariat` in this program's folder or on the path, in this order.
///
/// # Errors
/// `lariat` is in neither.
pub(crate) fn lariat() -> Result<PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    let own = env::current_exe().ok();
    let own = own.and_then(|program| program.parent().map(PathBuf::from));
    let mut folders = own.into_iter().chain(env::split_paths(&path));
    let found = folders.find_map(|folder| {
        let lariat = folder.join("lariat");
        lariat.is_file().then_some(lariat)
    });
    found.context(
        "lariat is neither in this program's folder nor on the path: `cargo build --release` builds it in a checkout",
    )
}
