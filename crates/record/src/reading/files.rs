//! The files of a recording: a single file, or those in a folder made by `ros2 bag record`.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::RecordingError;

/// File name endings of recordings: MCAP, also compressed as a whole. The other formats are refused
/// with a hint to convert them.
const ENDINGS: [&str; 5] = [".mcap", ".mcap.zstd", ".mcap.zst", ".db3", ".bag"];

/// Returns whether a file is a recording, judging by its name.
pub fn names_a_recording(path: &Path) -> bool {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().to_ascii_lowercase());
    name.is_some_and(|name| ENDINGS.iter().any(|ending| name.ends_with(ending)))
}

/// Lists the files that a path names, in order, with messages about missing files.
pub(super) fn listed(path: &Path) -> Result<(Vec<PathBuf>, Vec<String>), RecordingError> {
    if !path.is_dir() {
        return Ok((vec![path.to_owned()], Vec::new()));
    }
    let mut found = Vec::new();
    for entry in fs::read_dir(path)? {
        let file = entry?.path();
        if names_a_recording(&file) && file.is_file() {
            found.push(file);
        }
    }
    // The recorder numbers its files without padding: x_2 is before x_10.
    found.sort_by_key(|file| (file.as_os_str().len(), file.clone()));
    let about = fs::read_to_string(path.join("metadata.yaml")).unwrap_or_default();
    let (mut files, mut missing) = (Vec::new(), Vec::new());
    for name in files_of(&about) {
        let packed =
            [String::new(), ".zstd".to_owned()].map(|ending| path.join(format!("{name}{ending}")));
        match packed.into_iter().find(|file| found.contains(file)) {
            Some(file) => files.push(file),
            None => missing.push(format!("{name}, which metadata.yaml names, is missing")),
        }
    }
    // If the recorder was killed, its last file is not listed, or no file is.
    found.retain(|file| !files.contains(file));
    files.append(&mut found);
    match files.is_empty() {
        true => Err(RecordingError::NoFile),
        false => Ok((files, missing)),
    }
}

/// Returns the list `relative_file_paths` of a bag's metadata.
fn files_of(metadata: &str) -> impl Iterator<Item = &str> {
    let lines = metadata.lines().map(str::trim);
    let behind = lines
        .skip_while(|line| *line != "relative_file_paths:")
        .skip(1);
    let entries = behind.map_while(|line| line.strip_prefix("- "));
    entries.map(|name| name.trim().trim_matches(['"', '\'']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_come_in_the_order_of_the_metadata_and_missing_ones_are_named() {
        let folder = tempfile::TempDir::new().unwrap();
        for name in [
            "x_0.mcap",
            "x_2.mcap",
            "x_10.mcap",
            "x_11.mcap.zstd",
            "other.txt",
        ] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let names = |files: &[PathBuf]| -> Vec<String> {
            let name = |file: &PathBuf| file.file_name().unwrap().to_string_lossy().into_owned();
            files.iter().map(name).collect()
        };
        let (files, missing) = listed(folder.path()).unwrap();
        assert_eq!(
            names(&files),
            ["x_0.mcap", "x_2.mcap", "x_10.mcap", "x_11.mcap.zstd"]
        );
        assert!(missing.is_empty());
        let metadata = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - x_0.mcap\n    - x_1.mcap\n    - \"x_11.mcap\"\n  \
                        duration:\n    nanoseconds: 5\n";
        fs::write(folder.path().join("metadata.yaml"), metadata).unwrap();
        let (files, missing) = listed(folder.path()).unwrap();
        assert_eq!(
            names(&files),
            ["x_0.mcap", "x_11.mcap.zstd", "x_2.mcap", "x_10.mcap"]
        );
        assert_eq!(missing, ["x_1.mcap, which metadata.yaml names, is missing"]);
    }
}
