//! Which kernels a machine has, and what they are given.

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

/// Output channels whose sums are kept in registers at the same time, and what makes them.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// The first of them.
    pub(super) first: usize,
    /// For each of a window's pixels, for each four bytes of it, a line for each group of 16 channels.
    pub(super) weights: Vec<Line>,
    /// For each group.
    pub(super) bias: Vec<Sixteen<i32>>,
    /// For each group.
    pub(super) scale: Vec<Sixteen<f32>>,
}

impl Block {
    /// The most groups of 16 channels in a block.
    pub(super) const GROUPS: usize = 4;
}

/// A row to be made.
pub(super) struct Job<'a> {
    pub(super) shape: ConvolutionShape,
    /// `side` rows, each from the first window's first byte on, and at least as long as [`Convolution::input_bytes`] says.
    ///
    /// [`Convolution::input_bytes`]: super::Convolution::input_bytes
    pub(super) rows: &'a [&'a [u8]],
    /// As long as `out`.
    pub(super) residual: Option<&'a [u8]>,
    pub(super) finish: Finish,
    /// `width` pixels of `shape.out_channels` bytes.
    pub(super) out: &'a mut [u8],
    pub(super) width: usize,
}

impl Job<'_> {
    /// The most pixels that a kernel works on at the same time.
    pub(super) const PIXELS: usize = 16;

    /// Bytes from one window to the next.
    pub(super) fn step(&self) -> usize {
        self.shape.stride * self.shape.in_bytes()
    }

    /// The stretches of a window that are in one piece along a row: how many, bytes from one to the next, and bytes of each.
    pub(super) fn runs(&self) -> (usize, usize, usize) {
        let bytes = self.shape.in_bytes();
        match self.shape.dilation {
            1 => (1, 0, self.shape.side * bytes),
            apart => (self.shape.side, apart * bytes, bytes),
        }
    }
}

/// The instructions that convolutions run in. What they give does not depend on it.
#[derive(Clone, Copy, Debug)]
pub struct ConvolutionKernels {
    pub(super) name: &'static str,
    pub(super) row: fn(&mut Job, &Block),
    pub(super) widen: fn(&[u8], &mut [u8]),
    pub(super) look_up: fn(&[u8; 256], &mut [u8]),
    pub(super) spin: fn(u64) -> Spin,
}

/// What [`ConvolutionKernels::spin`] did.
#[derive(Clone, Copy, Debug)]
pub struct Spin {
    /// Multiply-adds.
    pub multiply_adds: u64,
    /// What came of them, so that they are not left out.
    pub sum: i32,
}

impl ConvolutionKernels {
    /// The fastest of the registers that [`Arch::new`] gives.
    pub fn new() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(kernels) = super::x86::of(Arch::new()) {
            return kernels;
        }
        // Every 64-bit ARM has NEON: its plain registers are those.
        #[cfg(target_arch = "aarch64")]
        return match Arch::new() {
            Arch::Plain => super::neon::fastest(),
        };
        #[cfg(not(target_arch = "aarch64"))]
        Self::plain()
    }

    /// All that this machine can run, the plain loop first: for tests that hold them equal.
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

    /// What the instructions are called.
    pub fn name(&self) -> &'static str {
        self.name
    }

    #[inline]
    pub(super) fn row(&self, job: &mut Job, block: &Block) {
        (self.row)(job, block);
    }

    /// Pixels of three bytes as ones of four, each byte halved (so that 255 becomes 127), the fourth 0. As many as both have.
    pub fn widen(&self, rgb: &[u8], out: &mut [u8]) {
        (self.widen)(rgb, out);
    }

    /// Each byte becomes that of the table in its place.
    pub fn look_up(&self, table: &[u8; 256], bytes: &mut [u8]) {
        (self.look_up)(table, bytes);
    }

    /// As many multiply-adds as the machine can do, `rounds` times a few, in registers alone: the limit that a kernel's time is
    /// held against.
    pub fn spin(&self, rounds: u64) -> Spin {
        (self.spin)(rounds)
    }
}

impl Default for ConvolutionKernels {
    fn default() -> Self {
        Self::new()
    }
}
