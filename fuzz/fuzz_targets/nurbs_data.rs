#![no_main]

#[allow(dead_code, reason = "shared with the other targets")]
#[path = "../../tests/fuzzing/bodies.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| bodies::nurbs_data(bytes));
