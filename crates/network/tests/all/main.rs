//! All tests of the public interface in one binary, which is built and linked once.

mod allocation;
mod definition;
mod files;
mod picture;
mod same_bits;
mod sizes;
