//! Frames of the rope that the chain renders, with their ground truth.

use anyhow::{Context, Result};
use lariat_capture::{RenderOptions, Source, open};
use lariat_drawn::scenes::{TrueRope, Truth};
use lariat_extract::PixelFormat;
use lariat_wire::Centerlines;

use crate::Picture;

/// A frame and its ground truth.
#[derive(Debug)]
pub struct TrueFrame {
    /// The frame, `Rgb8`.
    pub picture: Picture,
    /// Position of its rope. Crossings are not included.
    pub truth: Truth,
}

/// Renders the first frames of the rope that `lariat run` shows without a camera. The options
/// determine their number.
///
/// # Errors
/// The options do not describe a picture of a rope, or give no number of frames.
pub fn rendered(options: &RenderOptions) -> Result<Vec<TrueFrame>> {
    anyhow::ensure!(
        options.frames.is_some(),
        "the rendered rope has no end: say how many frames are wanted"
    );
    let mut source = open(&Source::Rendered(*options))?;
    let mut told = Box::new(Centerlines::EMPTY);
    let mut frames = Vec::new();
    while let Some(frame) = source.next()? {
        let size = [frame.width as usize, frame.height as usize];
        let write = |bytes: &mut [u8]| source.write(bytes);
        let picture = Picture::new(size, PixelFormat::Rgb8, frame.bytes(), write)
            .context("the rendered rope's frame is not the image that it says it is")?;
        source.truth(&mut told);
        frames.push(TrueFrame {
            picture,
            truth: truth(&told),
        });
    }
    Ok(frames)
}

fn truth(told: &Centerlines) -> Truth {
    let ropes = told.curves().iter().map(|curve| TrueRope {
        points: curve.points().iter().map(|p| p.map(f64::from)).collect(),
        length_px: f64::from(curve.length_px),
        width_px: f64::from(curve.width_px),
        closed: curve.closed != 0,
        border: [curve.border & 1 != 0, curve.border & 2 != 0],
    });
    Truth {
        ropes: ropes.collect(),
        ..Truth::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_belongs_to_the_frame() {
        let options = RenderOptions {
            width: 320,
            height: 240,
            frames: Some(3),
            ..RenderOptions::default()
        };
        let frames = rendered(&options).unwrap();
        assert_eq!(frames.len(), 3);
        for frame in &frames {
            let rope = &frame.truth.ropes[0];
            assert_eq!(rope.width_px, 12.0);
            let [x, y] = rope.points[60].map(|c| c.round() as usize);
            let pixel = &frame.picture.bytes()[3 * (y * 320 + x)..][..3];
            // The rope is blue, the table is not.
            assert!(pixel[2] > 40 + pixel[0], "{pixel:?} at ({x}, {y})");
        }
    }
}
