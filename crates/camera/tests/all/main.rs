//! All tests of the public interface in one program, which is built and linked once.

mod depth;
mod drawn;
mod files;
mod lens;
mod opencv;
mod sizes;
mod tools;
mod views;
