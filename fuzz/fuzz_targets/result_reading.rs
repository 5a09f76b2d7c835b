#![no_main]

#[allow(dead_code, reason = "shared with the other targets")]
#[path = "../../tests/fuzzing/bodies.rs"]
mod bodies;

use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| bodies::result_reading(bytes, FOLDER.path()));
