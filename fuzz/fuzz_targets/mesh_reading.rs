#![no_main]

mod memory;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = memory::bounded(bytes, |bytes| fe_mesh::read::read(bytes, 1e-3));
});
