//! No bytes of a recording make its reader or the source of its frames panic or hang.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::recording::run(data));
