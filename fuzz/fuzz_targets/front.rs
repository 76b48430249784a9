//! Whatever a client sends to the page's server, it is answered or ended.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::front(data));
