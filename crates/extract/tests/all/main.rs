//! All tests of the crate's public API in one binary, which is built and linked once.

#[path = "../drawing/mod.rs"]
mod drawing;

mod allocation;
mod any_ground;
mod byte_order;
mod classes;
mod confidence;
mod false_ropes;
mod follow;
mod follow_any;
mod hard;
mod hostile;
mod libraries;
mod masks;
mod meant;
mod methods;
mod network;
mod notices;
mod over_under;
mod pick;
mod pick_points;
mod random;
mod region;
mod ropes;
mod scored;
mod seams;
mod time;
mod time_films;
mod time_hidden;
