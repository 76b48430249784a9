//! On any message of descriptors, a control loop in Rust or in C and the sink neither panic, nor
//! hang, nor write out of bounds.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::descriptors(data));
