//! A control loop neither panics nor hangs on any message of 3-D descriptors.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::descriptors3(data));
