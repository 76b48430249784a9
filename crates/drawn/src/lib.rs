//! Ropes that are drawn, so that where they lie is known: what an extraction is held against, and what lariat shows without a camera.
//!
//! - [`Rendered`]: a film of one rope on a table. Heading as a function of arc length, integrated, so that the rope's length never changes
//!   and the truth is equally spaced by construction; drawn with round shading, shadow and sensor noise.
//! - [`Scene`]: the picture of a [simulated rope](lariat_simulation) with its grippers.
//! - [`scenes`]: still pictures, class by class (widths, noise, blur, light, crossings, touching strands, ends, …), and a score of curves against
//!   their truth. Curves are random and drawn again until a picture is hard in its class's way and in no other. 16 points a pixel, so that
//!   an edge is unbiased to 1/32 px; which strand covers a point is known from the nearest crossing, so any order of crossings can be drawn.
//! - [`space`]: ropes in space, lifted off the table and over themselves, as colour and depth cameras see them.
//! - [`moving`]: films of writhing ropes, story by story, and a judge of what is said of them.
//!
//! Pictures are made by IEEE basic operations in a fixed order and a sine of their own: the same on every machine, held by digests in the tests. No
//! I/O, no clock.

pub mod moving;
mod rendered;
pub mod scenes;
mod simulated;
pub mod space;

pub use rendered::{RenderError, RenderOptions, Rendered};
pub use simulated::{HandOptions, Scene, SpaceCameras, SpaceScene};
