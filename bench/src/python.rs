//! Runs a script of `rivals/` on a JSON request and parses its output, in which every line is JSON.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A line that a script prints.
#[derive(Deserialize)]
#[serde(untagged)]
enum Line<Measured> {
    Missing {
        missing: String,
    },
    Measured {
        #[serde(flatten)]
        measured: Measured,
        versions: BTreeMap<String, String>,
    },
}

/// Versions and missing libraries that scripts report.
#[derive(Default)]
pub(crate) struct Said {
    versions: BTreeMap<String, String>,
    missing: Vec<String>,
}

impl Said {
    /// Runs the script and returns its measurements.
    ///
    /// # Errors
    /// The request cannot be written, the Python interpreter does not exist, or the script fails.
    pub(crate) fn ask<Measured: DeserializeOwned>(
        &mut self,
        python: &Path,
        script: &str,
        request: &impl Serialize,
    ) -> Result<Vec<Measured>> {
        let mut all = Vec::new();
        for line in ask(python, script, request)? {
            match line {
                Line::Missing { missing } if self.missing.contains(&missing) => {}
                Line::Missing { missing } => self.missing.push(missing),
                Line::Measured { measured, versions } => {
                    self.versions.extend(versions);
                    all.push(measured);
                }
            }
        }
        Ok(all)
    }

    /// Prints the libraries that this Python lacks, and the versions of the others.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub(crate) fn print(&self, python: &Path) -> Result<()> {
        for missing in &self.missing {
            println!(
                "! `{0}` has no {missing}: install it by `{0} -m pip install -r bench/rivals/requirements.txt`",
                python.display()
            )?;
        }
        let versions = self.versions.iter();
        let versions: Vec<_> = versions
            .map(|(name, version)| format!("{name} {version}"))
            .collect();
        println!("{}", versions.join(", "))
    }
}

/// Runs a script and returns its output lines.
///
/// # Errors
/// The request cannot be written, the Python interpreter does not exist, or the script fails.
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
    // Leaves no compiled copies next to the scripts.
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
