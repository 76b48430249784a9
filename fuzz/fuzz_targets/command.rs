//! The simulated rope neither panics nor hangs on any command, and its coordinates remain finite.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::command(data));
