//! Finds ropes in a picture on any background with a small U-Net. It computes with integers, so its
//! results have the same bits on every machine.
//!
//! The input is a picture. The output is two maps, one byte per pixel, where 255 is certain: the
//! probability of a rope, and the probability of a seam between adjacent ropes. Weights have 8
//! bits, activations 7 bits and sums 32 bits. For the kernels and their speed, see
//! [`ConvolutionKernels`](lariat_portable::ConvolutionKernels). The crate does no I/O, reads no
//! clock and starts no thread. It does not allocate after the first picture of a size.
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
//! To process a rectangle of a picture, let `rgb` begin at the rectangle's first pixel and keep the
//! picture's stride. The maps work the same way. The cost is proportional to the rectangle's area.
//!
//! # The network
//!
//! | layer | | channels | at | result |
//! |---|---|---|---|---|
//! | stem | 3×3, stride 2 | 3 → 16 | 1/2 | |
//! | d1 | 3×3, stride 2 | 16 → 32 | 1/4 | skip b |
//! | d2 | 3×3, stride 2 | 32 → 48 | 1/8 | |
//! | e2a, e2b | 3×3 | 48 → 48 | 1/8 | e2b + d2: skip d |
//! | d3 | 3×3, stride 2 | 48 → 64 | 1/16 | |
//! | e3a, e3b | 3×3, dilation 2 and 1 | 64 → 64 | 1/16 | e3b + d3 |
//! | e3c, e3d | 3×3, dilation 4 and 1 | 64 → 64 | 1/16 | e3d + e3b |
//! | u2 | 1×1, signed | 64 → 48 | 1/16 | each pixel repeated 2×2, + skip d |
//! | f2 | 3×3 | 48 → 48 | 1/8 | |
//! | u1 | 1×1, signed | 48 → 32 | 1/8 | each pixel repeated 2×2, + skip b |
//! | f1 | 3×3 | 32 → 32 | 1/4 | |
//! | out | 1×1, signed | 32 → 32 | 1/4 | channel 16·map + 4·row + column: a pixel of a map |
//!
//! **Input.** The picture is padded on the right and at the bottom until both sides are
//! multiples of 16. Bytes are halved to 0 to 127. Padding and everything outside is 64.
//!
//! **Layers.** Activations range from 0 to 127 and share one scale, so a skip is an integer sum,
//! clamped to 0 to 127. Outside the picture, activations are 0. For the position of a window, see
//! [`ConvolutionShape`](lariat_portable::ConvolutionShape). A layer computes
//! `v = round(float(sum of products + bias) · scale)`, ties to even, adds the residual and clamps
//! to 0 to 127. A signed layer clamps to −128 to 127 first and adds afterwards. (The lower limit
//! may be −128 or −127: a skip is at most 127, so either gives 0.)
//!
//! **Output.** A signed byte is a logit in sixteenths. The maps contain
//! `round(255 / (1 + e^(−v/16)))`, cropped to the picture's size.
//!
//! # Cost
//!
//! A picture of 640×480 needs 904 million multiply-adds. On one core of a Sapphire Rapids at 3.0
//! GHz, that takes 2.8 ms: 83 % of the peak of its two `vpdpbusd` units, and 95 % in the inner
//! layers. A picture of 320×240 takes 0.70 ms, and a tile of 96×96 takes 0.10 ms. At 640×480,
//! AVX-VNNI takes 6.1 ms and AVX2 takes 11.7 ms. ONNX Runtime takes 10.0 ms for the same weights.
//! These are medians of `lariat-bench network --python PYTHON` on a shared virtual machine.
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
//! | 4 · out | biases, i32: the sum with its bias stays below 2²⁴ for any activations |
//! | 4 · out | scales, f32, from 0 to 64 |
//! | 4 | CRC-32 of all bytes before it (zlib's) |
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
