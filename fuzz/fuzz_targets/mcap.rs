//! The reader of recordings and the source of their frames neither panic nor hang on any bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::recording::run(data));
