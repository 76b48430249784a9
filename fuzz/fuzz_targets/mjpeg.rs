//! The decoder of a camera's frames neither panics nor writes out of bounds, whether a frame is
//! complete, damaged or not a frame at all.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|frames: lariat_fuzz::Frames| frames.run());
