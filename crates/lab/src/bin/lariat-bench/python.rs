//! A script of `rivals/`, run to its end on a file of JSON that says what is asked; its lines, each of them JSON, read.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What the script prints.
///
/// # Errors
/// The request cannot be written, there is no such Python, or the script goes wrong.
pub(crate) fn ask<Line: DeserializeOwned>(
    python: &Path,
    script: &str,
    request: &impl Serialize,
) -> Result<Vec<Line>> {
    let file = tempfile::NamedTempFile::new().context("cannot make a temporary file")?;
    serde_json::to_writer(&file, request)
        .with_context(|| format!("cannot write what {script} is asked"))?;
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("rivals")
        .join(script);
    // No compiled copies beside the scripts.
    let output = Command::new(python)
        .arg("-B")
        .arg(path)
        .arg(file.path())
        .output();
    let output = output.with_context(|| {
        format!(
            "`{}` cannot be run: name a Python 3 by --python",
            python.display()
        )
    })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!(
            "{script} went wrong: {}",
            said.trim().lines().last().unwrap_or("it says nothing")
        );
    }
    let lines = String::from_utf8_lossy(&output.stdout);
    let read =
        |line| serde_json::from_str(line).with_context(|| format!("{script} printed {line:?}"));
    lines.lines().map(read).collect()
}
