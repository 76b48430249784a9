//! From an image to the ordered centerlines of the ropes in it.
//!
//! A pure library without I/O, clock or threads. [`Extractor::extract`] takes an [`Image`] in the
//! camera's own pixel format and returns a [`Scene`]. For each rope, the scene has N points at
//! equal steps of arc length along the middle of the rope, between pixels, and the width at each
//! point. It also has the crossings, each with the rope that is on top.
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
//! `examples/descriptor.rs` reads a picture and fits curves to its ropes, in 15 lines.
//!
//! - [`Extractor`], [`Options`], [`Image`]: run extraction
//! - [`Mask`], [`HsvRange`], [`Network`], [`MaskLevels`]: sources of the mask
//! - [`Scene`], [`Curve`], [`Crossing`], [`Status`], [`Notice`]: the result
//! - [`CrossingSequence`] (knots of a rope): crossings in order
//! - [`pick()`], [`judge_pick`]: find a rope's colors in a picture
//!
//! # The steps
//!
//! [`Extractor`] takes these steps in this order. Each is a folder of pure code, and their
//! dependencies have no cycles.
//!
//! | step | folder | from → to |
//! |---|---|---|
//! | mask | `mask` | image → one bit per pixel, and the difference from the table. `auto` fits the table as a quadratic surface in each channel, and sets the threshold between its noise and the rope (Ridler and Calvard) |
//! | network | `mask/neural`, `ribbons` | image → where a small network finds rope. Edges are then traced there, so that the mask is as sharp as the image |
//! | skeleton | `skeleton` | mask → lines one pixel wide (Guo and Hall 1989) |
//! | graph | `graph` | lines → strands. One solver decides which edge continues into which, by learned weights of bending, width, color and more |
//! | centerline | `centerline` | strands → samples in the middle of the rope's cross-sections, smoothed without shrinking (Whittaker 1923), N at equal steps of arc length |
//! | occlusion | `occlusion` | removes grippers and hands from the mask, and joins lines across occluders |
//! | tracking | `tracking` | lines → curves with numbers and directions that persist between images |
//! | crossings | `crossings` | curves → where they meet, and which is on top: the strand whose surface continues through the crossing |
//! | confidence | `confidence` | curve → the probability that it is a rope, whole and in order, by a logistic function fitted to drawn pictures |
//! | knots | `knot` | crossings → a signed Gauss code, and whether pulling straightens the rope (Reidemeister moves, Alexander polynomial) |
//!
//! With a [`Method`] other than the skeleton, the centers of a `clustering` replace skeleton and
//! points.
//!
//! **Following.** Most images of a moving rope need none of these steps, because the rope is
//! followed from the previous image. On a plain table, this takes one chord across the rope at each
//! point (`following/chords`). On other backgrounds, it takes the rope's two edges
//! (`following/contours`). A missing or changed chord, a jumping tip, a new object, or strands
//! about to cross lead to a full extraction. [`Scene::followed`] tells which of the two produced a
//! scene.
//!
//! **Doubt.** [`Scene::notice`] names the most important probable fault: a pattern, a rope too
//! similar to the table, a shadow, a pen. If the automatic mask is doubtful, the network is used.
//! [`Curve::confidence`] is calibrated: of curves at 0.9, nine in ten are right.
//! `docs/confidence.md` has the measurements.
//!
//! # Bounds
//!
//! Any bytes are accepted, without a panic and in bounded time and memory. A mask is rejected if it
//! covers more than 60 % of the image, has more than one run for each 16 pixels, or has a skeleton
//! of more than 131,072 pixels. At most [`Options::ropes`] curves and 32 crossings are reported.
//! Memory is reused, so a warm extractor allocates nothing. Results are equal bit for bit on all
//! machines and vector sets (`lariat-portable`).
//!
//! At worst, a picture without a rope takes 5 to 27 times as long as one with one rope. Eight
//! ropes, or ten crossings, take 4 to 5 times as long
//! (`cargo bench --manifest-path bench/Cargo.toml --bench extract`).
//!
//! # Known limitations
//!
//! - Coils of several turns, and ropes of one color in a heap, can be traced in the wrong order. A
//!   wrong coil may be confident.
//! - A rope has two ends or none: branches of a harness become separate ropes.
//! - Ropes thinner than 1.8 px cannot be followed, so each image gets a full extraction.
//! - A rope of the background's color needs a mask from elsewhere.
//! - On clutter, confidence is less well calibrated than on a plain table (`docs/confidence.md`).

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bitmap;
mod centerline;
mod clustering;
mod crossings;
mod extractor;
mod following;
mod graph;
mod image;
mod judge;
mod knot;
mod mask;
mod notice;
mod occlusion;
mod options;
mod past;
mod pick;
mod ribbons;
mod scene;
mod skeleton;
mod statistics;
mod tracking;
mod vec2;

pub use extractor::{Extractor, Step};
pub use graph::assignment::{Alternative, features::FEATURES};
pub use image::{Image, ImageError, PixelFormat, Region};
pub use judge::{Class, Evidence, Maker, Verdict};
pub use knot::{CrossingSequence, Pass};
pub use lariat_network::{Network, NetworkError};
pub use mask::{MaskError, MaskLevels, mask_levels, mask_of};
pub use notice::Notice;
pub use options::{HsvRange, Mask, Method, Options, OptionsError, UnknownMethod};
pub use pick::{PickDoubt, PickError, PickJudgement, Picked, judge_pick, pick};
pub use scene::{Crossing, Curve, Scene, Status};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
