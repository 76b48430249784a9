//! Finds the commit that `lariat --version` shows: from git, otherwise from `cargo package`,
//! otherwise none.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let commit = of_git().or_else(of_package);
    println!(
        "cargo::rustc-env=LARIAT_COMMIT={}",
        commit.as_deref().unwrap_or("unknown")
    );
}

/// Commit of this checkout. A folder without `.git` may be inside the checkout of another project.
fn of_git() -> Option<String> {
    if !Path::new(".git").exists() {
        return None;
    }
    // Files that change with each commit and checkout. A missing one would make cargo rebuild every time.
    for name in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", name])?;
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    git(&["rev-parse", "--short=12", "HEAD"])
}

fn git(words: &[&str]) -> Option<String> {
    let output = Command::new("git").args(words).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// Commit in the file that `cargo package` adds: `"sha1": "…"`.
fn of_package() -> Option<String> {
    let text = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let (_, after) = text.split_once("\"sha1\"")?;
    let commit = after.split('"').nth(1)?;
    Some(commit.chars().take(12).collect())
}
