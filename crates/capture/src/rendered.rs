//! The rendered rope as a source of frames.

use lariat_drawn::{RenderError, RenderOptions, Rendered};
use lariat_message::{Centerlines, PixelFormat, SourceKind};

use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::Until;

/// The rope, drawn frame by frame.
#[derive(Debug)]
pub(crate) struct RenderedFrames(Rendered);

impl RenderedFrames {
    pub(crate) fn new(options: &RenderOptions) -> Result<Self, RenderError> {
        Rendered::new(options).map(Self)
    }

    fn frame(&self, sequence: u64) -> Frame {
        let RenderOptions { width, height, .. } = *self.0.options();
        Frame {
            sequence,
            width,
            height,
            stride: 3 * width,
            format: PixelFormat::Rgb8,
            exposed_ns: None,
            slot: None,
        }
    }
}

impl FrameSource for RenderedFrames {
    fn kind(&self) -> SourceKind {
        SourceKind::Rendered
    }

    fn largest_frame_bytes(&self) -> usize {
        self.frame(0).bytes()
    }

    fn has_truth(&self) -> bool {
        true
    }

    fn native_fps(&self) -> Option<f64> {
        let interval_s = self.0.options().frame_interval_s;
        (interval_s > 0.0).then(|| 1.0 / interval_s)
    }

    fn pass_over(&mut self, sequence: u64) -> Result<bool, SourceError> {
        self.0.pass_over(sequence);
        Ok(true)
    }

    fn advance(&mut self, _until: &Until) -> Result<Next, SourceError> {
        Ok(match self.0.advance() {
            Some(sequence) => Next::Frame(self.frame(sequence)),
            None => Next::End,
        })
    }

    fn write(&mut self, pixels: &mut [u8]) {
        self.0.write(pixels);
    }

    fn truth(&self, truth: &mut Centerlines) -> bool {
        self.0.truth(truth)
    }
}
