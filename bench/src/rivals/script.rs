//! Runs a script of `bench/rivals` once over all pictures and parses its output.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Samples;
use serde::Deserialize;

/// The compared work, in the order of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Work {
    Threshold,
    Components,
    Distance,
    ThinningSkimage,
    ThinningOpencv,
    Chain,
}

impl Work {
    pub(super) const ALL: [Self; 6] = [
        Self::Threshold,
        Self::Components,
        Self::Distance,
        Self::ThinningSkimage,
        Self::ThinningOpencv,
        Self::Chain,
    ];

    /// Returns the name in the table.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Threshold => "OpenCV HSV + inRange",
            Self::Components => "OpenCV connected components",
            Self::Distance => "OpenCV distance transform",
            Self::ThinningSkimage => "scikit-image thinning",
            Self::ThinningOpencv => "OpenCV contrib thinning",
            Self::Chain => "whole chain, 120 points",
        }
    }

    fn file(self) -> &'static str {
        match self {
            Self::Threshold => "threshold.py",
            Self::Components => "components.py",
            Self::Distance => "distance.py",
            Self::ThinningSkimage => "thinning.py",
            Self::ThinningOpencv => "thinning_opencv.py",
            Self::Chain => "chain.py",
        }
    }
}

/// Measurements of a script over all passes.
#[derive(Debug, Default)]
pub(super) struct Done {
    /// For each picture, the medians of the passes, in nanoseconds.
    ns: BTreeMap<usize, Samples>,
    /// Libraries and their versions.
    pub(super) versions: BTreeMap<String, String>,
    /// For each picture, the rope's points, if the script finds them.
    pub(super) points: BTreeMap<usize, Vec<[f32; 2]>>,
    /// The chain's thinning function, chosen from the installed ones.
    pub(super) thinning: Option<String>,
}

impl Done {
    /// Returns the median time for a picture in nanoseconds, if it was measured.
    pub(super) fn median_ns(&self, picture: usize) -> Option<f64> {
        self.ns.get(&picture).map(Samples::median)
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Missing {
        missing: String,
    },
    Measured {
        picture: usize,
        median_ms: f64,
        versions: BTreeMap<String, String>,
        #[serde(default)]
        points: Vec<[f32; 2]>,
        thinning: Option<String>,
    },
}

/// Runs the script over the pictures of `list`.
///
/// # Errors
/// Returns a sentence: what is missing and how to install it, or the script's error.
pub(super) fn run(work: Work, python: &Path, list: PathBuf, done: &mut Done) -> Result<(), String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("rivals");
    let shown = python.display();
    let output = Command::new(python)
        // Leaves no compiled copies next to the scripts.
        .arg("-B")
        .arg(folder.join(work.file()))
        .arg(list)
        .output()
        .map_err(|error| {
            format!(
                "`{shown}` cannot be run ({error}): name a Python 3 by --python, with what `-m pip install -r \
                 bench/rivals/requirements.txt` installs"
            )
        })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.trim().lines().last().unwrap_or("it says nothing");
        return Err(format!("{} went wrong: {last}", work.file()));
    }
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let line = serde_json::from_str(line)
            .map_err(|error| format!("{} printed {line:?}: {error}", work.file()))?;
        take(line, python, done)?;
    }
    Ok(())
}

fn take(line: Line, python: &Path, done: &mut Done) -> Result<(), String> {
    match line {
        Line::Missing { missing } => Err(format!(
            "`{0}` has no {missing}: install it by `{0} -m pip install -r bench/rivals/requirements.txt`",
            python.display()
        )),
        Line::Measured {
            picture,
            median_ms,
            versions,
            points,
            thinning,
        } => {
            done.ns.entry(picture).or_default().push(1e6 * median_ms);
            done.versions.extend(versions);
            done.thinning = thinning.or(done.thinning.take());
            if !points.is_empty() {
                done.points.insert(picture, points);
            }
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_gathered_picture_by_picture() {
        let mut done = Done::default();
        let lines = [
            r#"{"picture": 0, "median_ms": 1.5, "rounds": 5, "versions": {"OpenCV": "5.0"}}"#,
            r#"{"picture": 1, "median_ms": 2.0, "rounds": 5, "versions": {"NumPy": "2.4"},
                "points": [[1.0, 2.0]], "widths_px": [3.0], "thinning": "fast"}"#,
            r#"{"picture": 0, "median_ms": 2.5, "rounds": 5, "versions": {"OpenCV": "5.0"}}"#,
        ];
        for line in lines {
            take(
                serde_json::from_str(line).unwrap(),
                Path::new("python3"),
                &mut done,
            )
            .unwrap();
        }
        assert_eq!([done.ns[&0].count(), done.ns[&1].count()], [2, 1]);
        assert_eq!(done.ns[&1].median(), 2e6);
        assert_eq!(done.versions.len(), 2);
        assert_eq!(
            (done.points.len(), done.thinning.as_deref()),
            (1, Some("fast"))
        );
    }

    #[test]
    fn what_is_missing_is_said_with_the_command_that_installs_it() {
        let line = serde_json::from_str(r#"{"missing": "scikit-image"}"#).unwrap();
        let said = take(line, Path::new("py"), &mut Done::default()).unwrap_err();
        assert!(
            said.contains("no scikit-image") && said.contains("`py -m pip install"),
            "{said}"
        );
    }
}
