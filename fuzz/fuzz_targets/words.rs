//! A stage and its chain do not panic on any line, and a valid message survives a round trip
//! through text.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::words(data));
