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

mod arch;
mod operations;
mod plain;
mod simd;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use arch::{Arch, WithSimd};
pub use plain::Plain;
pub use pulp::NullaryFnOnce;
pub use simd::Simd;
#[cfg(target_arch = "x86_64")]
pub use x86::Two;

#[cfg(test)]
mod tests;
