//! The extractor neither panics nor hangs, whatever the bytes, sizes, strides, formats, options and
//! sequences of frames.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|session: lariat_fuzz::Session| session.run());
