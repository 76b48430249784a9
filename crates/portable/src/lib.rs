//! Arithmetic whose every bit is the same whatever vectors the machine has, at the speed of those that it has.
//!
//! A frame that is computed again gives the same numbers, to the last bit: on a machine with AVX-512, with AVX2, with neither,
//! on an ARM. IEEE 754 fixes what an addition, a product, a quotient, a root give; three things are left that differ from one
//! machine to another, and each has its remedy:
//!
//! | what differs | remedy |
//! |---|---|
//! | the order of a sum, where as many partial sums are kept as a register has lanes | a vector is 512 bits on every machine ([`Simd`]): one register or two, or an array that the compiler makes registers of |
//! | `a·b + c`, rounded once by some machines and twice by others | always twice ([`Simd::mul_add_f64s`]) |
//! | sines, logarithms: the C library has several, and takes the one for the machine | the crate `libm`, which is the same code everywhere; clippy's `disallowed_methods` says so in the crates that this matters to |
//!
//! The names are pulp's, which does the choosing: what is written for it runs here with another `use`.
//!
//! # The same bits
//!
//! A recorded frame, computed again, gives the recorded descriptor to the last bit, on whatever machine: that is what
//! `lariat replay --check` stands on. IEEE 754 fixes additions, products, quotients and roots; what it leaves open is closed in
//! `crates/portable`:
//!
//! | what differs from machine to machine | what is done |
//! |---|---|
//! | the order of sums, where each lane of a register keeps a partial sum | a vector is 512 bits everywhere: one register of AVX-512, two of AVX2, or an array that the compiler makes SSE2 or NEON of. The lanes are added in halves, in one order |
//! | `a·b + c`, rounded once where the machine has such an instruction | rounded twice, everywhere |
//! | what a library does with the vectors that it finds | faer factorizes a scalar type without vectors (`scalar` in fit) |
//! | the C library's sines and logarithms, of which it too has several for the processor to choose from | the crate `libm`, in `extract`, `fit`, `camera`, `simulation` and the drawn scenes. Clippy refuses the others there (`disallowed_methods`) |
//!
//! Rust never reorders floating-point sums and never fuses products into them, whatever it optimizes; what it compiles for
//! AVX-512 gives what it compiles for anything. Kernels that are written for one machine (`std::arch`), as those of [`Convolution`],
//! are on whole numbers, or held to their plain twins bit for bit. All operations of a vector are one list (`operations`), whose entries define them; a property
//! test holds every kind of registers to it. `crates/extract/tests/same_bits.rs` holds films in every pixel format, all
//! clusterings, pictures of every class, every kind of fit, the filter and curves on a plane against a file of hashes, once for each
//! kind of registers (`Arch::keep_to`); `tests/simd/run` does so on other processors, by emulation.

mod arch;
mod convolution;
mod operations;
mod plain;
mod random;
mod simd;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use arch::{Arch, WithSimd};
pub use convolution::{
    Convolution, ConvolutionError, ConvolutionKernels, ConvolutionShape, Finish, Plane, Spin,
};
pub use plain::Plain;
pub use pulp::NullaryFnOnce;
pub use random::SplitMix64;
pub use simd::Simd;
#[cfg(target_arch = "x86_64")]
pub use x86::Two;

#[cfg(test)]
mod tests;
