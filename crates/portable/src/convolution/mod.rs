//! Integer convolutions: 7-bit activations, 8-bit weights, 32-bit sums, with the same bits on every
//! machine.
//!
//! An activation is a byte from 0 to 127, and a weight is one from −127 to 127. The sum of two
//! products fits 16 bits (2·127·127 = 32,258). Instructions that add in pairs therefore never
//! saturate, and every sum is exact in any order. Only requantization remains, one IEEE float
//! product per sum: [`Finish`].
//!
//! Pixels are stored with channels last, row by row, inside a border of zeros as wide as the
//! windows' reach ([`Plane`]). An output row is computed from the three input rows that contain its
//! windows:
//!
//! ```text
//! for each block of P output pixels and 16·C output channels       their sums stay in P·C registers
//!     sums = bias
//!     for each of the three rows, for each of the window's bytes along it, four at a time
//!         C registers = the next weights: 4 bytes for each of 16 channels, in the order they are read
//!         for each of the P pixels: 4 bytes of input to all lanes; C times sums += the four products, added
//!     out = sums requantized, four registers to 64 bytes; plus the residual; at least 0
//! ```
//!
//! [`ConvolutionKernels`] implements this in the registers of the machine: `vpdpbusd` of AVX-512
//! VNNI or AVX-VNNI, `vpmaddubsw` of AVX-512BW or AVX2, `sdot` or `smull` of NEON. `plain` is the
//! definition, and a property test compares all others with it.

mod kernels;
#[cfg(target_arch = "aarch64")]
mod neon;
mod plain;
mod plane;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod registers;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use kernels::{Block, Job, Line, Sixteen};
pub use kernels::{ConvolutionKernels, Spin};
pub use plane::Plane;

use thiserror::Error;

/// Channels and window geometry of a convolution.
///
/// If `stride` is 1, the window of output pixel (x, y) is centered on the input pixel at the same
/// place. If it is 2, the window *begins* at (2x, 2y), as with `SAME` of TensorFlow and JAX for
/// even sizes: one row and one column of padding follow the image, and none precedes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConvolutionShape {
    /// Channels of the input. A pixel's channels are padded to a multiple of four bytes.
    pub in_channels: usize,
    /// Channels of the output, a multiple of 16.
    pub out_channels: usize,
    /// Side of a window in pixels, 1 or 3.
    pub side: usize,
    /// Input pixels from one window to the next, 1 or 2.
    pub stride: usize,
    /// Input pixels from one of a window's pixels to the next.
    pub dilation: usize,
}

/// Final step of an output: `v = round(float(sum + bias) · scale)`, ties to even, and then one of
/// these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// `clamp(v + residual, 0, 127)`, an activation. The residual is that of the same pixel and
    /// channel, or 0.
    Relu,
    /// `clamp(v, −128, 127)`, a signed byte.
    Signed,
}

/// Reason why numbers do not define a convolution.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ConvolutionError {
    /// A shape that no kernel supports.
    #[error(
        "No kernel takes {0:?}: use 1 × 1 or 3 × 3 pixels, a stride of 1 or 2, a dilation from 1 to 16 (1 where the stride is 2) and a multiple of 16 output channels."
    )]
    Shape(ConvolutionShape),
    /// A count that does not match the shape.
    #[error("{found} {what} for a convolution of {needed}: give as many as its shape has.")]
    Count {
        /// `weights`, `biases` or `scales`.
        what: &'static str,
        /// Required count.
        needed: usize,
        /// Actual count.
        found: usize,
    },
    /// A weight of −128, whose products can overflow in pairs.
    #[error("A weight of −128: weights lie from −127 to 127.")]
    Weight,
    /// Sums that a float cannot represent exactly.
    #[error(
        "The sums of output channel {channel} reach {most}, and no more than 16777215 (2²⁴ − 1) is exact: lower its bias or its weights."
    )]
    Sum {
        /// The output channel.
        channel: usize,
        /// The largest magnitude of a sum with its bias.
        most: u64,
    },
    /// A scale that is negative, not finite, or too large.
    #[error("A scale of {scale} for output channel {channel}: scales lie from 0 to 64.")]
    Scale {
        /// The output channel.
        channel: usize,
        /// Its scale.
        scale: f32,
    },
}

/// Weights in the order in which the kernels read them, with the other parameters of a row.
#[derive(Clone, Debug)]
pub struct Convolution {
    shape: ConvolutionShape,
    finish: Finish,
    blocks: Vec<Block>,
}

impl Convolution {
    /// Creates a convolution from `weights[((ky · side + kx) · in_channels + i) · out_channels +
    /// o]` (JAX's HWIO), and a bias and a scale for each output channel.
    ///
    /// # Errors
    ///
    /// The shape is not supported, a count does not match it, or numbers exceed the bounds within
    /// which every kind of registers gives the same bits.
    pub fn new(
        shape: ConvolutionShape,
        weights: &[i8],
        bias: &[i32],
        scale: &[f32],
        finish: Finish,
    ) -> Result<Self, ConvolutionError> {
        check(shape, weights, bias, scale)?;
        let blocks = (0..shape.out_channels).step_by(16 * Block::GROUPS);
        let blocks = blocks.map(|first| {
            let groups = ((shape.out_channels - first) / 16).min(Block::GROUPS);
            let of = |group: usize| first + 16 * group;
            Block {
                first,
                weights: pack(shape, weights, first, groups),
                bias: Vec::from_iter((0..groups).map(|g| Sixteen::from_slice(&bias[of(g)..]))),
                scale: Vec::from_iter((0..groups).map(|g| Sixteen::from_slice(&scale[of(g)..]))),
            }
        });
        Ok(Self {
            shape,
            finish,
            blocks: blocks.collect(),
        })
    }

    /// Shape of the convolution.
    pub fn shape(&self) -> ConvolutionShape {
        self.shape
    }

    /// Number of a window's input pixels before the one at the place of its output. The input rows
    /// of [`row`](Self::row) begin this many pixels further left, and the first row is this many
    /// rows above.
    pub fn reach(&self) -> usize {
        self.shape.reach()
    }

    /// Bytes that [`row`](Self::row) needs in each input row for `width` output pixels. Blocks of
    /// 16 pixels are read, even if there are fewer.
    pub fn input_bytes(&self, width: usize) -> usize {
        let shape = self.shape;
        let window = (shape.side - 1) * shape.dilation + 1;
        let pixels = (width.max(Job::PIXELS) - 1) * shape.stride + window;
        pixels * shape.in_bytes()
    }

    /// Computes a row of `out.len() / out_channels` output pixels from the `side` input rows that
    /// contain their windows. An input row begins with the first window: [`reach`](Self::reach)
    /// pixels left of the image.
    ///
    /// # Panics
    ///
    /// If `out` is not a whole number of pixels, an input row is shorter than
    /// [`input_bytes`](Self::input_bytes), the residual is not as long as `out`, or a signed output
    /// has a residual.
    pub fn row(
        &self,
        kernels: ConvolutionKernels,
        rows: &[&[u8]],
        residual: Option<&[u8]>,
        out: &mut [u8],
    ) {
        let shape = self.shape;
        assert!(out.len().is_multiple_of(shape.out_channels));
        assert_eq!(rows.len(), shape.side);
        let width = out.len() / shape.out_channels;
        if width == 0 {
            return;
        }
        let needed = self.input_bytes(width);
        assert!(rows.iter().all(|row| row.len() >= needed));
        assert!(residual.is_none_or(|r| r.len() == out.len() && self.finish == Finish::Relu));
        let mut job = Job {
            shape,
            rows,
            residual,
            finish: self.finish,
            out,
            width,
        };
        for block in &self.blocks {
            kernels.row(&mut job, block);
        }
    }
}

impl ConvolutionShape {
    /// Bytes of an input pixel.
    pub(crate) fn in_bytes(&self) -> usize {
        self.in_channels.next_multiple_of(4)
    }

    fn reach(&self) -> usize {
        if self.side == 3 && self.stride == 1 {
            self.dilation
        } else {
            0
        }
    }

    fn is_known(&self) -> bool {
        let dilations = if self.stride == 1 { 1..=16 } else { 1..=1 };
        matches!(self.side, 1 | 3)
            && matches!(self.stride, 1 | 2)
            && dilations.contains(&self.dilation)
            && (1..=1 << 12).contains(&self.in_channels)
            && (16..=1 << 12).contains(&self.out_channels)
            && self.out_channels.is_multiple_of(16)
    }
}

fn check(
    shape: ConvolutionShape,
    weights: &[i8],
    bias: &[i32],
    scale: &[f32],
) -> Result<(), ConvolutionError> {
    if !shape.is_known() {
        return Err(ConvolutionError::Shape(shape));
    }
    let outs = shape.out_channels;
    let counts = [
        (
            "weights",
            shape.side * shape.side * shape.in_channels * outs,
            weights.len(),
        ),
        ("biases", outs, bias.len()),
        ("scales", outs, scale.len()),
    ];
    for (what, needed, found) in counts {
        if needed != found {
            return Err(ConvolutionError::Count {
                what,
                needed,
                found,
            });
        }
    }
    if weights.contains(&i8::MIN) {
        return Err(ConvolutionError::Weight);
    }
    for channel in 0..outs {
        let of_channel = weights[channel..].iter().step_by(outs);
        let most: u64 = of_channel.map(|w| 127 * u64::from(w.unsigned_abs())).sum();
        let most = most + u64::from(bias[channel].unsigned_abs());
        if most >= 1 << 24 {
            return Err(ConvolutionError::Sum { channel, most });
        }
        let scale = scale[channel];
        // The largest sum times the largest scale is below 2³⁰, so it fits in 32 bits.
        if !(0.0..=64.0).contains(&scale) {
            return Err(ConvolutionError::Scale { channel, scale });
        }
    }
    Ok(())
}

/// The weights of a block of output channels, starting at `first`, in the order in which they are
/// read.
fn pack(shape: ConvolutionShape, weights: &[i8], first: usize, groups: usize) -> Vec<Line> {
    let mut packed = Vec::new();
    for tap in 0..shape.side * shape.side {
        for four in 0..shape.in_bytes() / 4 {
            for group in 0..groups {
                packed.push(Line(std::array::from_fn(|k| {
                    let (i, o) = (4 * four + k % 4, first + 16 * group + k / 4);
                    let at = (tap * shape.in_channels + i) * shape.out_channels + o;
                    if i < shape.in_channels {
                        weights[at]
                    } else {
                        0
                    }
                })));
            }
        }
    }
    packed
}
