//! Where ropes are in a picture, whatever is behind them: a small U-Net of whole numbers, the same bits on every machine.
//!
//! A picture in, two maps out, a byte a pixel, 255 for certain: how probably there is a rope, and how probably a seam between
//! ropes that lie side by side. Weights are bytes, activations have 7 bits, sums 32
//! ([`ConvolutionKernels`](lariat_portable::ConvolutionKernels) has how they are made, and how fast). Pure: no I/O, no clock, no
//! thread; once it has seen a picture of a size it allocates nothing.
//!
//! ```
//! use lariat_network::{Maps, Network, Picture, Workspace};
//!
//! let network = Network::from_bytes(&Network::random(1).to_bytes())?;
//! let mut workspace = Workspace::new();
//! let (width, height) = (40, 30);
//! let rgb = vec![90; 3 * width * height];
//! let (mut rope, mut seam) = (vec![0; width * height], vec![0; width * height]);
//! network.run(
//!     &mut workspace,
//!     Picture { rgb: &rgb, width, height, stride: 3 * width },
//!     Maps { rope: &mut rope, seam: &mut seam, stride: width },
//! )?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A rectangle of a picture is one whose `rgb` begins at its first pixel and whose stride is the picture's, and so are its
//! maps. What a rectangle costs goes with its area.
//!
//! # The network
//!
//! | layer | | channels | at | what comes of it |
//! |---|---|---|---|---|
//! | stem | 3×3, stride 2 | 3 → 16 | 1/2 | |
//! | d1 | 3×3, stride 2 | 16 → 32 | 1/4 | skip b |
//! | d2 | 3×3, stride 2 | 32 → 48 | 1/8 | |
//! | e2a, e2b | 3×3 | 48 → 48 | 1/8 | e2b + d2: skip d |
//! | d3 | 3×3, stride 2 | 48 → 64 | 1/16 | |
//! | e3a, e3b | 3×3, dilation 2 and 1 | 64 → 64 | 1/16 | e3b + d3 |
//! | e3c, e3d | 3×3, dilation 4 and 1 | 64 → 64 | 1/16 | e3d + e3b |
//! | u2 | 1×1, signed | 64 → 48 | 1/16 | each pixel four times, + skip d |
//! | f2 | 3×3 | 48 → 48 | 1/8 | |
//! | u1 | 1×1, signed | 48 → 32 | 1/8 | each pixel four times, + skip b |
//! | f1 | 3×3 | 32 → 32 | 1/4 | |
//! | out | 1×1, signed | 32 → 32 | 1/4 | channel 16·map + 4·row + column: a pixel of a map |
//!
//! **In.** The picture lies at the upper left of one whose sides are multiples of 16. Its bytes are halved: 0 to 127. What is not
//! of the picture, there and around it, is 64.
//!
//! **Between.** Activations are from 0 to 127, all of the same scale, so that a sum of two is a sum of whole numbers, clamped
//! to 0 to 127. Around them there is 0. Where a window lies: [`ConvolutionShape`](lariat_portable::ConvolutionShape). A layer
//! gives `v = round(float(sum of products + bias) · scale)`, ties to even, plus what is added, clamped to 0 to 127; where the
//! table says signed, it is clamped to −128 to 127 and added afterwards. (Whether that begins with −128 or −127 cannot be seen:
//! with a skip of 127 at most either gives 0.)
//!
//! **Out.** A signed byte is a logit in sixteenths; the maps have `round(255 / (1 + e^(−v/16)))`, cut to the picture's size.
//!
//! # What it costs
//!
//! A picture of 640×480 is 904 million multiply-adds, 2.8 ms on one core of a Sapphire Rapids at 3.0 GHz: 83 % of all that its
//! two units for `vpdpbusd` can do, 95 % in the layers within. A picture of 320×240 is 0.70 ms, a tile of 96×96 0.10 ms.
//! With AVX-VNNI it is 6.1 ms, with AVX2 11.7 ms; ONNX Runtime takes 10.0 ms for the same weights
//! (`lariat-bench network --python PYTHON`; medians, on a virtual machine that others used too).
//!
//! # The file
//!
//! Little endian, without gaps:
//!
//! | bytes | |
//! |---|---|
//! | 8 | `LARIATN1` |
//! | 4 | version, 1 |
//! | 4 | number of layers, 15 |
//! | | for each layer, in the order above: |
//! | 2, 2 | input channels, output channels |
//! | 1, 1, 1, 1 | side of the window, stride, dilation, 0 |
//! | side² · in · out | weights, −127 to 127: row, column, input channel, output channel (JAX's HWIO), the last one fastest |
//! | 4 · out | biases, i32: the sum with its bias stays below 2²⁴ whatever the activations are |
//! | 4 · out | scales, f32, from 0 to 64 |
//! | 4 | CRC-32 of all before (zlib's) |
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod file;
mod layers;
mod network;
mod output;
mod random;
mod run;
mod size;
mod workspace;

pub use file::NetworkError;
pub use layers::{LAYERS, Layer};
pub use network::{Network, Numbers};
pub use size::{Maps, Picture, SizeError};
pub use workspace::Workspace;
