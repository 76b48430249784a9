//! The sets of a data set and their pairs of photograph and label.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// A set of photographs.
#[derive(Debug, PartialEq)]
pub(super) struct Set {
    /// Name of the folder.
    pub(super) name: String,
    /// Pairs in the order of their names.
    pub(super) pairs: Vec<Pair>,
}

/// A photograph and its label.
#[derive(Debug, PartialEq)]
pub(super) struct Pair {
    /// The files' common name without its extension.
    pub(super) name: String,
    pub(super) image: PathBuf,
    pub(super) label: PathBuf,
}

/// Returns the sets in `folder`: itself if it holds `images` and `labels`, otherwise each folder in
/// it that does.
///
/// # Errors
/// The folder does not exist or contains no set, a set is empty, or a picture lacks its label.
pub(super) fn find(folder: &Path) -> Result<Vec<Set>> {
    let mut folders = vec![folder.to_owned()];
    folders.extend(entries(folder)?);
    folders.retain(|path| path.join("images").is_dir() && path.join("labels").is_dir());
    if folders.is_empty() {
        bail!(
            "{} has no set: name a folder that has `images` and `labels` in it, or that holds such folders",
            folder.display()
        );
    }
    folders.iter().map(|folder| set(folder)).collect()
}

fn set(folder: &Path) -> Result<Set> {
    let images = folder.join("images");
    let mut pairs = Vec::new();
    for image in entries(&images)? {
        let ending = image.extension().map(|e| e.to_ascii_lowercase());
        let is_picture = ending.is_some_and(|e| e == "png" || e == "jpg" || e == "jpeg");
        let Some(name) = image.file_stem().map(|stem| stem.to_string_lossy()) else {
            continue;
        };
        if !is_picture || name.starts_with('.') {
            continue;
        }
        let label = folder.join("labels").join(format!("{name}.png"));
        if !label.is_file() {
            bail!(
                "{} has no label: put one at {}, or take the picture out of the set",
                image.display(),
                label.display()
            );
        }
        let name = name.into_owned();
        pairs.push(Pair { name, image, label });
    }
    if pairs.is_empty() {
        bail!("{} holds no picture (PNG or JPEG)", images.display());
    }
    // The folder may be given as `.` or `..`.
    let whole = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let name = whole.file_name().unwrap_or(whole.as_os_str());
    Ok(Set {
        name: name.to_string_lossy().into_owned(),
        pairs,
    })
}

/// Returns the contents of a folder, ordered by name.
fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let about = || format!("cannot list the folder {}", folder.display());
    let listed = fs::read_dir(folder).with_context(about)?;
    let paths: Result<Vec<_>, _> = listed.map(|entry| entry.map(|e| e.path())).collect();
    let mut paths = paths.with_context(about)?;
    paths.sort();
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(path: &Path) {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "").unwrap();
    }

    #[test]
    fn each_folder_with_images_and_labels_is_a_set() {
        let root = tempfile::tempdir().unwrap();
        for set in ["two", "one"] {
            for name in ["b", "a"] {
                touch(&root.path().join(format!("{set}/images/{name}.JPG")));
                touch(&root.path().join(format!("{set}/labels/{name}.png")));
            }
        }
        touch(&root.path().join("one/images/notes.txt"));
        touch(&root.path().join("other/images/a.png"));
        let sets = find(root.path()).unwrap();
        let names: Vec<_> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names, ["one", "two"]);
        let pairs: Vec<_> = sets[0].pairs.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(pairs, ["a", "b"]);
        assert_eq!(find(&root.path().join("two")).unwrap(), sets[1..]);
    }

    #[test]
    fn what_is_missing_is_named() {
        let root = tempfile::tempdir().unwrap();
        let refusal = |path: &Path| format!("{:#}", find(path).unwrap_err());
        assert!(refusal(&root.path().join("none")).contains("cannot list"));
        assert!(refusal(root.path()).contains("has no set"));
        fs::create_dir_all(root.path().join("labels")).unwrap();
        fs::create_dir_all(root.path().join("images")).unwrap();
        assert!(refusal(root.path()).contains("no picture"));
        touch(&root.path().join("images/a.png"));
        assert!(refusal(root.path()).contains("a.png has no label"));
    }
}
