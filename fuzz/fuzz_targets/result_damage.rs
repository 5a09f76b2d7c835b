//! Wrong datasets in a sound HDF5 file. `RESULT` names a result file that is damaged in copies.
#![no_main]

#[allow(dead_code, reason = "shared with the other targets")]
#[path = "../../tests/fuzzing/bodies.rs"]
mod bodies;

use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));
static RESULT: LazyLock<Vec<u8>> = LazyLock::new(|| {
    std::fs::read(std::env::var("RESULT").expect("RESULT names a result file")).expect("readable")
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("damaged.h5");
    std::fs::write(&path, &*RESULT).expect("written");
    bodies::damage(&path, bytes);
    bodies::read_everything(&path, FOLDER.path());
});
