//! Photographs used as backgrounds.

use std::path::Path;

use anyhow::Context;
use image::RgbImage;
use image::imageops::{self, FilterType};

use crate::canvas::{Canvas, Field, happens, spread};
use lariat_portable::SplitMix64;

/// Photographs without ropes.
pub(crate) struct Photographs(Vec<RgbImage>);

impl Photographs {
    /// Loads all photographs of a folder, in the order of their names. Empty without a folder.
    pub(crate) fn of(folder: Option<&Path>) -> anyhow::Result<Self> {
        let Some(folder) = folder else {
            return Ok(Self(Vec::new()));
        };
        let entries = std::fs::read_dir(folder)
            .with_context(|| format!("cannot read the folder {}", folder.display()))?;
        let mut files: Vec<_> = entries
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<Result<_, _>>()?;
        files.retain(|file| {
            let ending = file.extension().and_then(|ending| ending.to_str());
            matches!(ending, Some("png" | "jpg" | "jpeg"))
        });
        files.sort();
        let read = |file: &std::path::PathBuf| {
            let unread = || format!("cannot read {}", file.display());
            let bytes = std::fs::read(file).with_context(unread)?;
            let picture = image::load_from_memory(&bytes).with_context(unread)?;
            Ok(picture.to_rgb8())
        };
        files
            .iter()
            .map(read)
            .collect::<anyhow::Result<_>>()
            .map(Self)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns a square part of a random photograph, scaled by ½ to 2, and rotated or mirrored.
    pub(crate) fn cut(&self, side: usize, random: &mut SplitMix64) -> Canvas {
        let picture = &self.0[random.below(self.0.len())];
        let most = picture.width().min(picture.height());
        let asked = (side as f32 * spread(random, 0.5, 2.0)) as u32;
        let size = asked.clamp(16, most.max(16)).min(most);
        let [x, y] = [picture.width(), picture.height()]
            .map(|length| random.below((length - size + 1) as usize) as u32);
        let square = imageops::crop_imm(picture, x, y, size, size).to_image();
        let side_px = side as u32;
        let mut square = imageops::resize(&square, side_px, side_px, FilterType::Triangle);
        if happens(random, 0.5) {
            square = imageops::flip_horizontal(&square);
        }
        if happens(random, 0.3) {
            square = imageops::rotate90(&square);
        }
        let values = square
            .pixels()
            .map(|pixel| pixel.0.map(f32::from))
            .collect();
        Field { side, values }
    }
}
