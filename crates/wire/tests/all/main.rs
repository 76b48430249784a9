//! All tests of the crate's public face in one program, which is built and linked once.

mod allocation;
mod channels;
mod commands;
mod image_writer;
mod kills;
mod nearest;
mod prediction;
mod reader;
mod shape;
mod survey;
mod umask;
