//! No line makes a stage or its chain panic; what is a word is said again as it was meant.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::words(data));
