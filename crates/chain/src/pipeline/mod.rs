//! From a frame to the shapes of the ropes in it, wherever frames come from and wherever shapes go: what the stages, `trace`,
//! `replay`, `servo` and the benches do alike. Without transport, without a clock, without waiting.

mod extraction;
mod fitting;
mod schedule;

pub use extraction::{FrameExtractor, FrameView, Part, Past, pixel_format};
pub use fitting::{Companion, CurveFitter, SpaceFitter};
pub use schedule::{Schedule, frame_header};

/// Says a thing the first time only: a fault of every frame would fill the screen.
#[derive(Default)]
struct Warned(bool);

impl Warned {
    /// Warns, once.
    fn once(&mut self, cause: &anyhow::Error) {
        if !std::mem::replace(&mut self.0, true) {
            tracing::warn!("{cause:#}");
        }
    }
}
