//! No message of descriptors in space makes a control loop panic or hang.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::descriptors3(data));
