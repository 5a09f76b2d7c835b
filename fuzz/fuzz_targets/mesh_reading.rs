#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = fe_mesh::read::read(bytes, 1e-3);
});
