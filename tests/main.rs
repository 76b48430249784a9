//! All tests of the real binary from outside in one program, which is built and linked once.

#[path = "../examples/message_of_offsets.rs"]
mod message_of_offsets;
mod rig;

#[cfg(feature = "lab")]
mod bench;
mod c;
mod calibrate;
mod chain;
mod config;
mod devices;
mod doctor;
mod fit_lines;
#[cfg(feature = "lab")]
mod paper;
mod pick;
mod readers;
mod record;
mod replay;
mod ros2;
mod service;
#[cfg(feature = "lab")]
mod servo;
mod shell;
mod snapshot;
mod terminal;
mod trace;
mod view;
