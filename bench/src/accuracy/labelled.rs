//! Labeled photographs for other modules.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use image::{DynamicImage, GrayImage, RgbImage};
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

    /// Changes the photograph and its label.
    pub(crate) fn map(
        &mut self,
        photo: impl Fn(&RgbImage) -> RgbImage,
        label: impl Fn(&GrayImage) -> GrayImage,
    ) {
        self.photo = photo(&self.photo.to_rgb8()).into();
        let Labels {
            width,
            height,
            ropes,
        } = &mut self.label;
        let size = [*width as u32, *height as u32];
        if let Some(whole) = GrayImage::from_raw(size[0], size[1], std::mem::take(ropes)) {
            *ropes = label(&whole).into_raw();
        }
    }

    /// Returns for each curve whether it is one whole labeled rope.
    pub(crate) fn is_whole(&self, curves: &[Curve]) -> Vec<bool> {
        let splines: Vec<_> = curves.iter().map(through).collect();
        whole::curves(&self.label, curves, &splines)
    }

    /// Returns whether a curve is off every labeled rope for more than half of its length.
    pub(crate) fn is_off(&self, curve: &Curve) -> bool {
        let reach = f64::from(curve.width_px.max(4.0)) / 2.0;
        let near = [
            [0.0, 0.0],
            [reach, 0.0],
            [-reach, 0.0],
            [0.0, reach],
            [0.0, -reach],
        ];
        let is_on = |point: &&[f32; 2]| {
            let at = |off: [f64; 2]| [0, 1].map(|k| (f64::from(point[k]) + off[k]).round() as i64);
            near.iter()
                .any(|&off| self.label.at(at(off)[0], at(off)[1]) != 0)
        };
        2 * curve.points.iter().filter(is_on).count() < curve.points.len()
    }
}

/// A photograph and its label that are not read yet.
pub(crate) struct Unread(dataset::Pair);

impl Unread {
    /// Reads the photograph and its label.
    ///
    /// # Errors
    /// One of them cannot be read, or their sizes differ.
    pub(crate) fn load(&self) -> Result<Labelled> {
        self.read()
            .with_context(|| format!("cannot use {}", self.0.image.display()))
    }

    fn read(&self) -> Result<Labelled> {
        let label = Labels::load(&self.0.label)?;
        let photo = photo::load(&self.0.image)?;
        let size = [photo.width() as usize, photo.height() as usize];
        ensure!(
            size == [label.width, label.height],
            "its label is of another size"
        );
        Ok(Labelled { photo, label })
    }
}

/// Returns all labeled photographs of a folder of sets.
///
/// # Errors
/// The folder holds no set.
pub(crate) fn photographs(folder: &Path) -> Result<impl Iterator<Item = Unread>> {
    let pairs = dataset::find(folder)?.into_iter().flat_map(|set| set.pairs);
    Ok(pairs.map(Unread))
}
