//! The reader of videos neither panics nor hangs on any bytes, and a part of a file has the same
//! frames as the whole.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::video::run(data));
