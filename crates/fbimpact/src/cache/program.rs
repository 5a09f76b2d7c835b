//! Which program builds a model, on which kind of processor.

use std::time::UNIX_EPOCH;

use sha2::{Digest, Sha256};

use super::Name;
use crate::process::provenance;

/// Hash of the program and of what its arithmetic depends on.
///
/// Length and time of its file count as well, for the commit is that of the last full build; the processor does because matrix
/// products add up in another order on another kind.
pub fn fingerprint() -> Name {
    let mut hash = Sha256::new();
    hash.update(provenance::hash());
    for text in processor() {
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    if let Ok(data) = std::env::current_exe().and_then(std::fs::metadata) {
        hash.update(data.len().to_le_bytes());
        let written = data.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
        hash.update(written.map_or(0, |t| t.as_nanos()).to_le_bytes());
    }
    hash.finalize().into()
}

/// Abilities of the processor that the linear algebra chooses by.
#[cfg(target_arch = "x86_64")]
fn processor() -> impl Iterator<Item = &'static str> {
    let known = [
        ("avx", std::arch::is_x86_feature_detected!("avx")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
        ("avx512vl", std::arch::is_x86_feature_detected!("avx512vl")),
        ("avx512dq", std::arch::is_x86_feature_detected!("avx512dq")),
    ];
    known.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name)
}

/// Other targets have one instruction set.
#[cfg(not(target_arch = "x86_64"))]
fn processor() -> impl Iterator<Item = &'static str> {
    std::iter::empty()
}
