//! Photographs from a user's folder.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use lariat_capture::{FileOptions, Source, open};
use lariat_extract::PixelFormat;
use lariat_wire as wire;

use crate::Picture;

/// A set of photographs.
#[derive(Debug)]
pub struct PhotoSet {
    /// Name of the folder.
    pub name: String,
    /// The photographs, upright, in natural order of their names.
    pub pictures: Vec<Picture>,
}

/// Returns the sets in `folder`: itself if it holds `images`, otherwise each folder in it that
/// does.
///
/// # Errors
/// The folder does not exist or contains no set, or a set has no readable picture.
pub fn photographs(folder: &Path) -> Result<Vec<PhotoSet>> {
    let about = || format!("cannot list the folder {}", folder.display());
    let listed = std::fs::read_dir(folder).with_context(about)?;
    let mut folders = vec![folder.to_owned()];
    for entry in listed {
        folders.push(entry.with_context(about)?.path());
    }
    folders.retain(|path| path.join("images").is_dir());
    folders.sort();
    if folders.is_empty() {
        bail!(
            "{} has no photographs: name a folder that has `images` in it, or that holds such folders",
            folder.display()
        );
    }
    let sets = folders.iter().map(|set| {
        let whole = std::fs::canonicalize(set).unwrap_or_else(|_| set.clone());
        let name = whole.file_name().unwrap_or(whole.as_os_str());
        Ok(PhotoSet {
            name: name.to_string_lossy().into_owned(),
            pictures: load(vec![set.join("images")])?,
        })
    });
    sets.collect()
}

/// Loads picture files, or folders of them. A gray picture becomes `Gray8`.
///
/// # Errors
/// A file cannot be read, or is not a picture.
pub fn load(paths: Vec<PathBuf>) -> Result<Vec<Picture>> {
    let mut source = open(&Source::Paths {
        paths,
        options: FileOptions::default(),
    })?;
    let mut pictures = Vec::new();
    while let Some(frame) = source.next()? {
        let format = match frame.format {
            wire::PixelFormat::Gray8 => PixelFormat::Gray8,
            wire::PixelFormat::Rgb8 => PixelFormat::Rgb8,
            other => bail!("a picture file was decoded as {other:?}, and must be grey or RGB"),
        };
        let size = [frame.width as usize, frame.height as usize];
        let write = |bytes: &mut [u8]| source.write(bytes);
        let picture = Picture::new(size, format, frame.bytes(), write)
            .context("a decoded picture is padded, and must not be")?;
        pictures.push(picture);
    }
    Ok(pictures)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Rgb, RgbImage};

    #[test]
    fn each_folder_with_images_is_a_set() {
        let root = tempfile::tempdir().unwrap();
        for (set, width) in [("one", 20), ("two", 30)] {
            let images = root.path().join(set).join("images");
            std::fs::create_dir_all(&images).unwrap();
            let picture = RgbImage::from_pixel(width, 10, Rgb([9, 8, 7]));
            picture.save(images.join("a.png")).unwrap();
        }
        let sets = photographs(root.path()).unwrap();
        let names: Vec<_> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names, ["one", "two"]);
        assert_eq!(sets[1].pictures[0].size(), [30, 10]);
        assert_eq!(sets[1].pictures[0].bytes()[..3], [9, 8, 7]);
        let alone = photographs(&root.path().join("two")).unwrap();
        assert_eq!((alone.len(), alone[0].name.as_str()), (1, "two"));
    }

    #[test]
    fn a_folder_without_photographs_is_refused() {
        let root = tempfile::tempdir().unwrap();
        let said = photographs(root.path()).unwrap_err().to_string();
        assert!(said.contains("has no photographs"), "{said}");
    }
}
