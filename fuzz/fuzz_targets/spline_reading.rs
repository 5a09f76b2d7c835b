#![no_main]

mod memory;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = memory::bounded(bytes, |bytes| iga_core::files::read(bytes, 1e-3)) {
        drop(iga_core::nurbs::joining::join(&file.patches, &file.joined));
    }
});
