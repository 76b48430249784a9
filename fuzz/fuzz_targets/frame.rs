//! Extract neither panics, nor hangs, nor sends an invalid message, whatever the header and the
//! bytes after it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::frame(data));
