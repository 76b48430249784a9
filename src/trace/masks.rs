//! External masks: pictures in a folder, each named after its picture.

mod scale;

use anyhow::{Context, Result, bail};
use lariat_capture::{MaskPicture, natural_order};
use lariat_extract::{Image, PixelFormat, mask_levels};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// Words that may follow a picture's name in its mask's name, after a dot, a dash or an underscore.
/// Other words and numbers may belong to another picture's name.
const SUFFIXES: [&str; 16] = [
    "mask",
    "masks",
    "seg",
    "segm",
    "segmentation",
    "label",
    "labels",
    "labelids",
    "gt",
    "groundtruth",
    "pred",
    "prediction",
    "matte",
    "alpha",
    "binary",
    "instances",
];

/// A folder of masks.
pub(super) struct Masks {
    folder: PathBuf,
    /// Pictures in the folder.
    files: Vec<PathBuf>,
    /// True if each mask is thresholded by its own histogram.
    chooses_level: bool,
    /// Notices so far. The masks of a folder are mostly of one kind, so a notice is given once.
    said: RefCell<Vec<String>>,
}

/// A mask as extraction accepts it.
pub(super) struct MaskOf {
    pub(super) path: PathBuf,
    size: [u32; 2],
    levels: Vec<u8>,
    /// Notices about this mask that are new.
    pub(super) news: Vec<String>,
}

impl MaskOf {
    /// # Errors
    /// Returns an error if the mask is larger than extraction accepts.
    pub(super) fn image(&self) -> Result<Image<'_>> {
        let [width, height] = self.size.map(|side| side as usize);
        let image = Image::new(&self.levels, width, height, width, PixelFormat::Gray8);
        image.with_context(|| self.path.display().to_string())
    }

    /// Brightest level of the mask.
    pub(super) fn brightest(&self) -> u8 {
        self.levels.iter().copied().max().unwrap_or(0)
    }
}

impl Masks {
    /// Opens a folder of masks. `chooses_level`: each mask is thresholded by its own histogram.
    ///
    /// # Errors
    /// Returns an error if there is no such folder.
    pub(super) fn new(folder: &Path, chooses_level: bool) -> Result<Self> {
        if !folder.is_dir() {
            bail!(
                "there is no folder {}: --masks takes a folder of pictures, white for rope",
                folder.display()
            );
        }
        let about = || format!("cannot list the folder {}", folder.display());
        let mut files = Vec::new();
        for entry in std::fs::read_dir(folder).with_context(about)? {
            let path = entry.with_context(about)?.path();
            if lariat_capture::names_a_picture(&path) {
                files.push(path);
            }
        }
        let name = |path: &PathBuf| path.as_os_str().as_encoded_bytes().to_owned();
        files.sort_by(|a, b| natural_order(&name(a), &name(b)));
        Ok(Self {
            folder: folder.to_owned(),
            files,
            chooses_level,
            said: RefCell::default(),
        })
    }

    /// Returns the mask file of the picture at `path`, if there is exactly one.
    pub(super) fn name(&self, path: &Path) -> Option<PathBuf> {
        self.find(path).ok()
    }

    /// Finds the one file with the picture's name, or otherwise the one with a word of [`SUFFIXES`]
    /// after it.
    fn find(&self, path: &Path) -> Result<PathBuf> {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let whole = path.file_name().unwrap_or_default().to_string_lossy();
        let stem_of = |file: &Path| {
            let stem = file.file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        };
        let is_suffixed = |file: &Path| {
            let found = stem_of(file);
            let rest = found.strip_prefix(&*stem);
            let rest = rest.and_then(|rest| rest.strip_prefix(['.', '_', '-']));
            rest.is_some_and(|rest| SUFFIXES.contains(&rest.to_ascii_lowercase().as_str()))
        };
        // Pictures and masks may be in the same folder.
        let itself = path.canonicalize().ok();
        let is_itself = |file: &Path| itself.is_some() && file.canonicalize().ok() == itself;
        let with = |is_it: &dyn Fn(&Path) -> bool| -> Vec<&PathBuf> {
            let files = self.files.iter();
            files
                .filter(|file| is_it(file) && !is_itself(file))
                .collect()
        };
        let mut found = with(&|file| stem_of(file) == stem);
        if found.is_empty() {
            found = with(&|file| stem_of(file) == whole || is_suffixed(file));
        }
        match found[..] {
            [file] => Ok(file.clone()),
            [] => bail!(
                "there is no mask of {}: it would be {}",
                path.display(),
                self.folder.join(format!("{stem}.png")).display()
            ),
            [first, second, ..] => bail!(
                "there are several masks of {}, {} and {}: leave one of them in the folder",
                path.display(),
                first.display(),
                second.display()
            ),
        }
    }

    /// Reads the mask of the picture at `path`, which has this size.
    ///
    /// # Errors
    /// Returns an error if the mask is missing, is not a picture, or does not belong to that
    /// picture.
    pub(super) fn of(&self, path: &Path, size: [u32; 2]) -> Result<MaskOf> {
        let file = self.find(path)?;
        let about = || file.display().to_string();
        let MaskPicture {
            width,
            height,
            mut levels,
            mut news,
        } = MaskPicture::load(&file)?;
        if self.chooses_level {
            let [width, height] = [width, height].map(|side| side as usize);
            let image = Image::new(&levels, width, height, width, PixelFormat::Gray8);
            let read = mask_levels(&image.with_context(about)?).with_context(about)?;
            if let Some(read) = read {
                levels = read.levels;
                news.extend(read.notice);
            }
        }
        if [width, height] != size {
            let scaled = scale::to(size, [width, height], levels).with_context(about)?;
            (levels, news) = (scaled.0, [news, vec![scaled.1]].concat());
        }
        let mut said = self.said.borrow_mut();
        news.retain(|news| !said.contains(news));
        said.extend(news.iter().cloned());
        Ok(MaskOf {
            path: file,
            size,
            levels,
            news,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[&str], picture: &str) -> Result<String> {
        let folder = tempfile::tempdir()?;
        for file in files {
            std::fs::write(folder.path().join(file), "")?;
        }
        let file = Masks::new(folder.path(), true)?.find(Path::new(picture))?;
        let name = file.file_name().unwrap_or_default();
        Ok(name.to_string_lossy().into_owned())
    }

    #[test]
    fn a_mask_has_the_pictures_name_or_one_that_says_mask_behind_it() {
        for (files, expected) in [
            (&["a.png", "a_mask.png"][..], "a.png"),
            (&["a.jpg", "ab.png"], "a.jpg"),
            (&["a_mask.png", "b_mask.png", "a_2.png"], "a_mask.png"),
            (&["a.mask.png", "a.txt"], "a.mask.png"),
            (&["a-SEG.tif"], "a-SEG.tif"),
            (&["a.jpg.png"], "a.jpg.png"),
        ] {
            assert_eq!(found(files, "pictures/a.jpg").unwrap(), expected);
        }
    }

    #[test]
    fn a_name_that_may_be_another_pictures_is_not_taken_and_two_masks_are_refused() {
        for files in [&["a_2.png"][..], &["a_left.png"], &["ab_mask.png"], &[]] {
            let said = found(files, "a.png").unwrap_err().to_string();
            assert!(said.contains("there is no mask of a.png"), "{said}");
        }
        for files in [["a.png", "a.jpg"], ["a_mask.png", "a.seg.png"]] {
            let said = found(&files, "a.bmp").unwrap_err().to_string();
            assert!(said.contains("several masks"), "{said}");
        }
    }
}
