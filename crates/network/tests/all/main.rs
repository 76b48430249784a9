//! All tests of the crate's public face in one program, which is built and linked once.

mod allocation;
mod definition;
mod files;
mod picture;
mod same_bits;
mod sizes;
