#![no_main]

libfuzzer_sys::fuzz_target!(init: penombre_fuzz::begin(), |data: &[u8]| penombre_fuzz::json(data));
