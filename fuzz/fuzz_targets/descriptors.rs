//! No message of descriptors makes a control loop, in Rust or in C, or the sink panic, hang or write where it may not.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::descriptors(data));
