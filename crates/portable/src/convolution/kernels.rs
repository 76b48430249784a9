//! The kernels of a machine, and their inputs.

use super::{ConvolutionShape, Finish, plain};
use crate::arch::Arch;

/// Four weights for each of 16 output channels.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Line(pub(super) [i8; 64]);

/// A number for each of 16 output channels.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Sixteen<T>(pub(super) [T; 16]);

impl<T: Copy> Sixteen<T> {
    pub(super) fn from_slice(numbers: &[T]) -> Self {
        Self(std::array::from_fn(|i| numbers[i]))
    }
}

/// Output channels whose sums are in registers at the same time, and their parameters.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// The first channel.
    pub(super) first: usize,
    /// For each pixel of a window and each four of its bytes, a line per group of 16 channels.
    pub(super) weights: Vec<Line>,
    /// One entry per group.
    pub(super) bias: Vec<Sixteen<i32>>,
    /// One entry per group.
    pub(super) scale: Vec<Sixteen<f32>>,
}

impl Block {
    /// Maximum number of groups of 16 channels in a block.
    pub(super) const GROUPS: usize = 4;
}

/// A row to be computed.
pub(super) struct Job<'a> {
    pub(super) shape: ConvolutionShape,
    /// `side` rows, each starting at the first window's first byte, of at least
    /// [`Convolution::input_bytes`].
    ///
    /// [`Convolution::input_bytes`]: super::Convolution::input_bytes
    pub(super) rows: &'a [&'a [u8]],
    /// Residuals, of the length of `out`.
    pub(super) residual: Option<&'a [u8]>,
    pub(super) finish: Finish,
    /// `width` pixels of `shape.out_channels` bytes.
    pub(super) out: &'a mut [u8],
    pub(super) width: usize,
}

impl Job<'_> {
    /// Maximum number of pixels that a kernel processes at the same time.
    pub(super) const PIXELS: usize = 16;

    /// Bytes from one window to the next.
    pub(super) fn step(&self) -> usize {
        self.shape.stride * self.shape.in_bytes()
    }

    /// The contiguous runs of a window along a row: their number, the bytes from one to the next,
    /// and the bytes of each.
    pub(super) fn runs(&self) -> (usize, usize, usize) {
        let bytes = self.shape.in_bytes();
        match self.shape.dilation {
            1 => (1, 0, self.shape.side * bytes),
            apart => (self.shape.side, apart * bytes, bytes),
        }
    }
}

/// The instructions used for convolutions. Results do not depend on them.
#[derive(Clone, Copy, Debug)]
pub struct ConvolutionKernels {
    pub(super) name: &'static str,
    pub(super) row: fn(&mut Job, &Block),
    pub(super) widen: fn(&[u8], &mut [u8]),
    pub(super) look_up: fn(&[u8; 256], &mut [u8]),
    pub(super) spin: fn(u64) -> Spin,
}

/// Result of [`ConvolutionKernels::spin`].
#[derive(Clone, Copy, Debug)]
pub struct Spin {
    /// Number of multiply-adds.
    pub multiply_adds: u64,
    /// Their sum, so that they are not optimized away.
    pub sum: i32,
}

impl ConvolutionKernels {
    /// The fastest kernels for the registers that [`Arch::new`] returns.
    pub fn new() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(kernels) = super::x86::of(Arch::new()) {
            return kernels;
        }
        // Every 64-bit ARM has NEON, in its plain registers.
        #[cfg(target_arch = "aarch64")]
        return match Arch::new() {
            Arch::Plain => super::neon::fastest(),
        };
        #[cfg(not(target_arch = "aarch64"))]
        Self::plain()
    }

    /// All kernels that this machine can run, the plain loop first, for tests that compare them.
    pub fn all() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        let fast = super::x86::all();
        #[cfg(target_arch = "aarch64")]
        let fast = super::neon::all();
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let fast = [];
        std::iter::once(Self::plain()).chain(fast).collect()
    }

    fn plain() -> Self {
        Self {
            name: "plain",
            row: plain::row,
            widen: plain::widen,
            look_up: plain::look_up,
            spin: plain::spin,
        }
    }

    /// Name of the instructions.
    pub fn name(&self) -> &'static str {
        self.name
    }

    #[inline]
    pub(super) fn row(&self, job: &mut Job, block: &Block) {
        (self.row)(job, block);
    }

    /// Converts pixels of three bytes to pixels of four. Each byte is halved, so that 255 becomes
    /// 127, and the fourth is 0. Stops at the end of the shorter slice.
    pub fn widen(&self, rgb: &[u8], out: &mut [u8]) {
        (self.widen)(rgb, out);
    }

    /// Replaces each byte by the table's entry at its value.
    pub fn look_up(&self, table: &[u8; 256], bytes: &mut [u8]) {
        (self.look_up)(table, bytes);
    }

    /// Does multiply-adds as fast as the machine can, in registers alone: a few for each of
    /// `rounds`. This is the upper bound to which a kernel's time is compared.
    pub fn spin(&self, rounds: u64) -> Spin {
        (self.spin)(rounds)
    }
}

impl Default for ConvolutionKernels {
    fn default() -> Self {
        Self::new()
    }
}
