//! Vector arithmetic with the same bits on every machine, at the speed of its widest registers.
//!
//! A recorded frame, computed again, gives the recorded descriptor bit for bit: with AVX-512, with
//! AVX2, with neither, or on an ARM. `lariat replay --check` relies on this. IEEE 754 fixes the
//! results of additions, products, quotients and roots; this crate fixes the rest:
//!
//! | differs between machines | remedy |
//! |---|---|
//! | the order of sums, if each lane of a register keeps a partial sum | a vector has 512 bits everywhere ([`Simd`]): one register of AVX-512, two of AVX2, or an array that the compiler turns into SSE2 or NEON. The lanes are added in halves, in one order |
//! | `a·b + c`, rounded once on machines with such an instruction, otherwise twice | always rounded twice ([`Simd::mul_add_f64s`]) |
//! | library code that selects vector instructions at run time | faer factorizes a scalar type without vectors (`scalar` in fit) |
//! | sines and logarithms of the C library, which has several versions for different processors | the crate `libm`, in `extract`, `fit`, `camera`, `simulation` and the rendered scenes; Clippy's `disallowed_methods` rejects the others there |
//!
//! Rust never reorders floating-point sums or fuses products into them, at any optimization level.
//! Code compiled for AVX-512 therefore gives the same results as code compiled for other machines.
//! Kernels written for one machine (`std::arch`), such as those of [`Convolution`], use integers,
//! or are compared bit for bit with their plain versions.
//!
//! All vector operations are in one list (`operations`), whose entries define them; a property test
//! compares every kind of registers with it. `crates/extract/tests/same_bits.rs` compares results
//! with a file of hashes, once for each kind of registers (`Arch::keep_to`). It covers films in
//! every pixel format, all clusterings, images of every class, every kind of fit, the filter, and
//! curves on a plane. `tests/simd/run` does so on other processors, by emulation.
//!
//! The names are those of pulp, which selects the registers: code written for pulp runs here with a
//! different `use`.

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
