//! All tests of the crate's public interface, in one program that is linked only once.

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
