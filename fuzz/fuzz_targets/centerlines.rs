//! Fit and the sink neither panic nor hang on any message of centerlines, and fit's answers do not
//! make its readers do so.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| lariat_fuzz::hostile::centerlines(data));
