//! From an image to the ordered centerlines of the ropes in it.
//!
//! A pure library: no input or output, no clock, no threads, and once warm no allocation per frame.
//! [`Extractor::extract`] takes an [`Image`] in the camera's own pixel format and returns a
//! [`Scene`]: for each rope N points at equal steps of arc length through the middle of the rope,
//! between pixels, with its width at each point; and the crossings, with which rope is on top.
//!
//! ```
//! use lariat_extract::{Extractor, Image, Options, PixelFormat};
//!
//! // A dark bar, 9 pixels wide, on a light table.
//! let (width, height) = (200, 100);
//! let mut bytes = vec![220u8; width * height];
//! for row in bytes.chunks_exact_mut(width).skip(40).take(9) {
//!     row[30..170].fill(40);
//! }
//! let image = Image::new(&bytes, width, height, width, PixelFormat::Gray8)?;
//! let mut extractor = Extractor::new(Options::default())?;
//! let scene = extractor.extract(&image);
//! let rope = &scene.curves[0];
//! assert_eq!(rope.points.len(), 120);
//! assert!((rope.width_px - 9.0).abs() < 0.2);
//! assert!((rope.points[60][1] - 44.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The steps
//!
//! | step | folder | from → to |
//! |---|---|---|
//! | mask | `mask`: `background`, `difference`, `threshold`, or `hsv`; then `hysteresis`, `cast`, `diagnosis` | image, or a mask made elsewhere → one bit a pixel, and how unlike the table each pixel is |
//! | skeleton | `skeleton`: `thin`, `pixels` | mask → lines one pixel wide |
//! | graph | `graph`: `edges`, `zones`, `overlaps`, `pairing`, `strands` | lines → strands, each rope's edges in order through its crossings |
//! | points | `centerline`: `path`, `section`, `smooth`, `extender` | strands → samples along the middle of each rope |
//! | | `occlusion`: `occluder`, `bridge` | what hides a rope leaves the mask; lines → lines joined across it |
//! | | `tracking`: `refit`, `part`, `tips`, `track`, `plausible` | lines → curves with numbers that last |
//! | | `crossings`: `meet`, `over` | curves → where they cross, and which is on top |
//!
//! [`Extractor`] takes the steps in this order (`extractor`), as the `options` say; `past` is what they know of the last
//! image. Out comes a `scene`, with a `notice` where it is unsure. All read pictures by `image` (formats, colors, loops
//! over all pixels) and bits by `bitmap` (strips, components, morphology); `statistics` and `vec2` are arithmetic. No two
//! folders use each other.
//!
//! With another [`Method`] than the skeleton, the centers of a `clustering` stand in its place (in order by its `nerve`),
//! and the points are theirs (`ordering`).
//!
//! Most frames of a moving rope need none of them: it is followed from the last one by reading a chord
//! at each of its points (`chords`), as long as nothing else happens; [`Scene::followed`] says so.
//!
//! What comes of the crossings: [`CrossingSequence`], a rope's passes over and under itself, and whether
//! it is knotted (`knot`). Color ranges for a picture's ropes are proposed by `pick`.
//!
//! # Bounds
//!
//! Any bytes are taken, without a panic, in bounded time: the mask step reads each pixel a fixed
//! number of times; a mask that covers more than 60% of the image, or that breaks into more than one
//! run for each 16 pixels, is no picture of ropes and gives none; thinning makes at most 128 passes,
//! over the rows that still change; a skeleton of more than 131,072 pixels or 4096 strands is noise
//! and gives none; crossings of more than ten arms are resolved pair by pair; 64 rings are opened; all lines
//! together are laid with some 6,000 samples; at most [`Options::ropes`] curves and 32 crossings are reported.
//!
//! What strands and crossings cost is by their number, not by that of their pairs. The slowest pictures found, of nets
//! from border to border of 640×480 pixels with hundreds of crossings, take some 25 times as long as one rope; stripes 8
//! times; eight real ropes, or one that crosses itself ten times, 4 to 5 times.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bitmap;
mod centerline;
mod chords;
mod clustering;
mod crossings;
mod extractor;
mod graph;
mod image;
mod knot;
mod mask;
mod notice;
mod occlusion;
mod options;
mod past;
mod pick;
mod scene;
mod skeleton;
mod statistics;
mod tracking;
mod vec2;

pub use clustering::{FuzzyMeans, KMeans, Mixture, Outcome, Pixels, Run, Som, Start, seed_centers};
pub use extractor::{Extractor, Step};
pub use image::{Image, ImageError, PixelFormat, Region};
pub use knot::{CrossingSequence, Pass};
pub use mask::{MaskError, mask_of};
pub use notice::Notice;
pub use options::{HsvRange, Mask, Method, Options, OptionsError, UnknownMethod};
pub use pick::{PickDoubt, PickError, Picked, doubt_pick, pick};
pub use scene::{Crossing, Curve, Scene, Status};
