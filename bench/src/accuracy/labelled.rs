//! Labeled photographs for other modules.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use image::DynamicImage;
use lariat_extract::Curve;

use super::labels::Labels;
use super::spline::through;
use super::{dataset, photo, whole};

/// A photograph and its label.
pub(crate) struct Labelled {
    pub(crate) photo: DynamicImage,
    label: Labels,
}

impl Labelled {
    /// Returns the label as a mask: white for rope.
    pub(crate) fn mask(&self) -> Vec<u8> {
        let ropes = self.label.ropes.iter();
        ropes.map(|&rope| if rope == 0 { 0 } else { 255 }).collect()
    }

    /// Returns for each curve whether it is one whole labeled rope.
    pub(crate) fn is_whole(&self, curves: &[Curve]) -> Vec<bool> {
        let splines: Vec<_> = curves.iter().map(through).collect();
        whole::curves(&self.label, curves, &splines)
    }
}

/// Returns all labeled photographs of a folder of sets.
///
/// # Errors
/// The folder holds no set. An item is an error if the photograph or its label cannot be read.
pub(crate) fn photographs(folder: &Path) -> Result<impl Iterator<Item = Result<Labelled>>> {
    let pairs = dataset::find(folder)?.into_iter().flat_map(|set| set.pairs);
    let read = |pair: &dataset::Pair| {
        let label = Labels::load(&pair.label)?;
        let photo = photo::load(&pair.image)?;
        let size = [photo.width() as usize, photo.height() as usize];
        ensure!(
            size == [label.width, label.height],
            "its label is of another size"
        );
        Ok(Labelled { photo, label })
    };
    Ok(pairs.map(move |pair| {
        read(&pair).with_context(|| format!("cannot use {}", pair.image.display()))
    }))
}
