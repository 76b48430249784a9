//! Computes the shapes of the ropes in a frame. The stages, `trace`, `replay`, `servo` and the
//! benchmarks share this code. It never uses a transport or a clock, and never waits.

mod extraction;
mod fitting;
mod schedule;

pub use extraction::{FrameExtractor, FrameView, Part, Past, pixel_format};
pub use fitting::{Companion, CurveFitter, SpaceFitter};
pub use schedule::{Schedule, frame_header};

/// Warns only once, because a fault in every frame would fill the screen.
#[derive(Default)]
struct Warned(bool);

impl Warned {
    /// Warns at the first call.
    fn once(&mut self, cause: &anyhow::Error) {
        if !std::mem::replace(&mut self.0, true) {
            tracing::warn!("{cause:#}");
        }
    }
}
