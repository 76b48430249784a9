//! No frame of a camera, whole, damaged or none at all, makes its decoder panic or write beyond the memory it is lent.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|frames: lariat_fuzz::Frames| frames.run());
