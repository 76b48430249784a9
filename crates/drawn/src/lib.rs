//! Drawn ropes with known centerlines: the reference for testing an extraction, and what lariat
//! shows without a camera.
//!
//! - [`Rendered`]: a film of one rope on a table. Its heading is a function of arc length and is
//!   integrated, so the rope's length never changes and the truth is equally spaced by
//!   construction. It is drawn with round shading, shadow and sensor noise.
//! - [`Scene`]: the picture of a [simulated rope](lariat_simulation) with its grippers.
//! - [`scenes`]: still pictures, class by class (widths, noise, blur, light, crossings, touching
//!   strands, ends, …), and a function that scores curves against the truth. Random curves are
//!   tried until a picture has only the difficulty of its class. Each pixel has 16 samples, so an
//!   edge is unbiased to 1/32 px. The nearest crossing decides which strand covers a sample, so
//!   strands can cross in any order.
//! - [`space`]: ropes in 3-D, lifted off the table and over themselves, as color and depth cameras
//!   see them.
//! - [`moving`]: films of writhing ropes, by story, and a judge of an extractor's answers.
//!
//! Pictures use IEEE basic operations in a fixed order and their own sine, so they are the same
//! on every machine; digests in the tests check this. No I/O, no clock.

pub mod moving;
mod rendered;
pub mod scenes;
mod simulated;
pub mod space;

pub use rendered::{RenderError, RenderOptions, Rendered};
pub use simulated::{HandOptions, Scene, SpaceCameras, SpaceScene};
