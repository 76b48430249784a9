//! No command makes the simulated rope panic, hang or leave the numbers.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::command(data));
