//! The pictures for all programs: in memory for lariat, and as PNG files of the same pixels for the
//! scripts.

use std::fs;
use std::path::{Path, PathBuf};

use crate::{Picture, load, opencv_bounds, photographs, rendered};
use anyhow::{Context, Result, bail};
use image::{ExtendedColorType, save_buffer};
use lariat_capture::RenderOptions;
use lariat_drawn::scenes::Truth;
use lariat_extract::{HsvRange, PixelFormat, pick};
use serde::Serialize;
use tempfile::TempDir;

use super::Args;

/// Name of the set of drawn frames.
pub(super) const DRAWN: &str = "drawn, 640×480";

/// A picture.
pub(super) struct Shown {
    /// Index of its set in [`Pictures::sets`].
    pub(super) set: usize,
    pub(super) picture: Picture,
    /// Color ranges of its ropes, as `lariat pick` finds them. The scripts and lariat get the same
    /// ranges.
    pub(super) ranges: Vec<HsvRange>,
    /// Ground truth of its rope, if known.
    pub(super) truth: Option<Truth>,
}

/// All pictures, set by set.
pub(super) struct Pictures {
    pub(super) sets: Vec<String>,
    pub(super) shown: Vec<Shown>,
}

/// The list that the scripts read, in a folder that is removed with this value.
pub(super) struct List {
    folder: TempDir,
}

impl List {
    pub(super) fn path(&self) -> PathBuf {
        self.folder.path().join("pictures.json")
    }
}

#[derive(Serialize)]
struct Listed {
    rounds: usize,
    pictures: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    path: PathBuf,
    ranges: Vec<[[u8; 3]; 2]>,
}

impl Pictures {
    /// Collects the drawn frames and the requested photographs. Returns a sentence for each that
    /// was left out.
    pub(super) fn gather(args: &Args) -> Result<(Self, Vec<String>)> {
        let mut pictures = Self {
            sets: Vec::new(),
            shown: Vec::new(),
        };
        let options = RenderOptions {
            frames: Some(args.frames),
            truth_points: 256,
            ..RenderOptions::default()
        };
        let film = rendered(&options)?;
        let film = film.into_iter().map(|f| (f.picture, Some(f.truth)));
        let mut left_out = pictures.add(DRAWN.into(), film);
        if let Some(folder) = &args.dataset {
            for set in photographs(folder)? {
                let untold = set.pictures.into_iter().map(|p| (p, None));
                left_out.extend(pictures.add(set.name, untold));
            }
        }
        if !args.images.is_empty() {
            let untold = load(args.images.clone())?.into_iter().map(|p| (p, None));
            left_out.extend(pictures.add("images".into(), untold));
        }
        if pictures.shown.is_empty() {
            bail!(
                "there is no picture with a rope to measure: name others by --images or --dataset"
            );
        }
        Ok((pictures, left_out))
    }

    fn add(
        &mut self,
        set: String,
        given: impl Iterator<Item = (Picture, Option<Truth>)>,
    ) -> Vec<String> {
        let mut left_out = Vec::new();
        for (k, (picture, truth)) in given.enumerate() {
            match pick(&picture.image(), &[]) {
                Ok(picked) => self.shown.push(Shown {
                    set: self.sets.len(),
                    picture,
                    ranges: picked.ranges,
                    truth,
                }),
                Err(error) => left_out.push(format!(
                    "picture {} of {set} is left out, as its rope's colour is not known: {error}",
                    k + 1
                )),
            }
        }
        self.sets.push(set);
        left_out
    }

    /// Writes the pictures for the scripts.
    pub(super) fn write(&self, rounds: usize) -> Result<List> {
        let folder = tempfile::tempdir().context("cannot make a folder for the pictures")?;
        let mut listed = Listed {
            rounds,
            pictures: Vec::new(),
        };
        for (k, shown) in self.shown.iter().enumerate() {
            let path = folder.path().join(format!("{k:04}.png"));
            save(&shown.picture, &path)?;
            listed.pictures.push(Entry {
                path,
                ranges: shown.ranges.iter().flat_map(opencv_bounds).collect(),
            });
        }
        let list = List { folder };
        fs::write(list.path(), serde_json::to_vec(&listed)?)
            .context("cannot write the list of pictures")?;
        Ok(list)
    }
}

fn save(picture: &Picture, path: &Path) -> Result<()> {
    let color = match picture.format() {
        PixelFormat::Gray8 => ExtendedColorType::L8,
        _ => ExtendedColorType::Rgb8,
    };
    let [width, height] = picture.size().map(|side| side as u32);
    save_buffer(path, picture.bytes(), width, height, color)
        .with_context(|| format!("cannot write {}", path.display()))
}
