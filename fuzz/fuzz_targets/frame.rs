//! No header and no bytes behind it make extract panic or hang, or send what it may not.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::frame(data));
