//! All tests of the crate's public face in one program, which is built and linked once.

mod depth;
mod files;
mod lens;
mod opencv;
mod sizes;
