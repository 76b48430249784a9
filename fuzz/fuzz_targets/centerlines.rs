//! No message of centerlines makes fit or the sink panic or hang, or fit send what makes its readers do so.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::centerlines(data));
