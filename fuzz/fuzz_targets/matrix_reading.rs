#![no_main]

#[allow(dead_code, reason = "shared with the other targets")]
#[path = "../../tests/fuzzing/bodies.rs"]
mod bodies;
mod memory;

use fbimpact::interchange::matrix_files::{read_map, read_matrix, read_nodes};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = memory::bounded(bytes, |_| read_matrix(text, None));
        let _ = memory::bounded(bytes, |_| read_map(text));
        let _ = memory::bounded(bytes, |_| read_nodes(text));
    }
    bodies::matrix_reading(bytes);
});
