//! No bytes of a video file make its reader panic or hang, and a part of it has the frames that the whole has.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::video::run(data));
