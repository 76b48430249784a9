//! A film given as pictures, one per frame, with a drawn hand over it.

use std::path::Path;

use anyhow::{Context, Result};
use lariat_drawn::moving::{Hand, TrueRope};
use lariat_extract::{Extractor, Image, Options, PixelFormat, Status};

/// Number of points of a reference curve.
const POINTS: usize = 240;

/// The frames, each with the ropes extracted before a hand is drawn.
pub(super) struct Film {
    pub(super) size: [usize; 2],
    frames: Vec<(Vec<u8>, Vec<TrueRope>)>,
}

impl Film {
    /// Reads the PNG pictures of a folder, in the order of their names.
    pub(super) fn read(folder: &Path) -> Result<Self> {
        let entries = std::fs::read_dir(folder)
            .with_context(|| format!("cannot read the folder {}", folder.display()))?;
        let paths: Result<Vec<_>, _> = entries.map(|entry| Ok(entry?.path())).collect();
        let mut paths: Vec<_> = paths.map_err(|cause: std::io::Error| cause)?;
        paths.retain(|path| path.extension().is_some_and(|ending| ending == "png"));
        paths.sort();
        let mut film = Self {
            size: [0; 2],
            frames: Vec::with_capacity(paths.len()),
        };
        let mut extractor = Extractor::new(Options::default())?;
        for path in &paths {
            let picture = image::open(path)
                .with_context(|| format!("cannot read {}", path.display()))?
                .to_rgb8();
            let size = [picture.width(), picture.height()].map(|side| side as usize);
            if film.frames.is_empty() {
                film.size = size;
            }
            anyhow::ensure!(
                size == film.size,
                "{} has another size than the pictures before it: a film has one",
                path.display()
            );
            let image = Image::new(&picture, size[0], size[1], 3 * size[0], PixelFormat::Rgb8)?;
            let scene = extractor.extract(&image);
            let seen = scene.curves.iter().filter(|c| c.status != Status::Lost);
            let truth = seen.map(|curve| TrueRope {
                identity: curve.track,
                points: dense(&curve.points),
                seen: vec![true; POINTS],
                width_px: curve.width_px.into(),
            });
            let truth = truth.collect();
            film.frames.push((picture.into_raw(), truth));
        }
        anyhow::ensure!(
            film.frames.len() > 1,
            "{} has no film in it: it takes two PNG pictures at least",
            folder.display()
        );
        Ok(film)
    }

    /// Draws a frame and returns its true ropes. The film plays forward and backward, starting at a
    /// frame that depends on the seed.
    pub(super) fn frame(&self, at: u64, seed: u64, rgb: &mut Vec<u8>) -> Vec<TrueRope> {
        let last = self.frames.len() as u64 - 1;
        let turn = (at + 37 * seed) % (2 * last);
        let (pixels, truth) = &self.frames[turn.min(2 * last - turn) as usize];
        rgb.clone_from(pixels);
        let mut truth = truth.clone();
        let size_px = self.size.map(|side| side as f64);
        let widest_px = truth.iter().map(|rope| rope.width_px).reduce(f64::max);
        let hand = widest_px.and_then(|px| Hand::visiting(at, seed, size_px, px));
        if let Some(hand) = hand {
            hand.draw(rgb, self.size[0], &mut truth);
        }
        truth
    }
}

/// Resamples a curve at equal steps to the number of points that the judge expects.
fn dense(points: &[[f32; 2]]) -> Vec<[f64; 2]> {
    let last = points.len() - 1;
    let at = |i: usize| {
        let place = i as f64 * last as f64 / (POINTS - 1) as f64;
        let k = (place as usize).min(last - 1);
        let [p, q] = [points[k], points[k + 1]].map(|p| p.map(f64::from));
        [0, 1].map(|c| p[c] + (q[c] - p[c]) * (place - k as f64))
    };
    (0..POINTS).map(at).collect()
}
