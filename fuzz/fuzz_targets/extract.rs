//! No bytes, sizes, strides, formats and options, and no sequence of frames, make the extractor panic or hang.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|session: lariat_fuzz::Session| session.run());
