//! Global heaps, where HDF5 keeps texts. HDF5 2.2 reads one whose free space has size zero for ever
//! (`H5HG__cache_heap_deserialize` then stays where it is).

use crate::file::plain_file;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Larger files are searched up to here: what a text search of the file costs must not be felt.
const SEARCHED: u64 = 1 << 26;
/// Bytes searched at a time.
const BLOCK: usize = 1 << 18;
/// Begin of a heap: signature, version and reserved bytes.
const SIGNATURE: [u8; 8] = *b"GCOL\x01\0\0\0";
/// Bytes of the header of a heap, and of one of its objects.
const HEADER: usize = 16;
/// Least size of a heap; the library refuses smaller ones.
const LEAST: usize = 4096;

/// Address of a heap that cannot be read to its end and that something refers to.
///
/// # Errors
/// Those of reading the file.
pub fn unreadable(path: &Path) -> io::Result<Option<u64>> {
    let mut file = plain_file::open(path)?;
    for at in find(&mut file, SIGNATURE)? {
        // What was a heap once may be left in unused space: harmless as long as nothing refers to
        // it.
        if is_endless(&heap(&mut file, at)?) && is_referred_to(&mut file, at)? {
            return Ok(Some(at));
        }
    }
    Ok(None)
}

/// Positions of `pattern`.
fn find(file: &mut File, pattern: [u8; 8]) -> io::Result<Vec<u64>> {
    let mut found = Vec::new();
    let mut block = Vec::with_capacity(BLOCK + pattern.len());
    let mut start = 0;
    file.seek(SeekFrom::Start(0))?;
    while start < SEARCHED && file.take(BLOCK as u64).read_to_end(&mut block)? > 0 {
        let windows = block.windows(pattern.len()).enumerate();
        found.extend(windows.filter(|(_, w)| **w == pattern).map(|(i, _)| start + i as u64));
        // The pattern may lie across the end of the block.
        let rest = block.len().saturating_sub(pattern.len() - 1);
        block.drain(..rest);
        start += rest as u64;
    }
    Ok(found)
}

/// Bytes of the heap at `at`; fewer than it claims where the file ends.
fn heap(file: &mut File, at: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(at))?;
    file.take(HEADER as u64).read_to_end(&mut bytes)?;
    let size = word(&bytes, 8).unwrap_or(0);
    file.take(size.saturating_sub(HEADER as u64).min(SEARCHED)).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Whether the library goes through the objects of a heap without end.
fn is_endless(heap: &[u8]) -> bool {
    let size = word(heap, 8).unwrap_or(0);
    if size < LEAST as u64 || size != heap.len() as u64 {
        return false;
    }
    let mut at = HEADER;
    while let (Some(index), Some(n)) = (heap.get(at..at + 2), word(heap, at + 8)) {
        // Object 0 is the free space, which counts its header.
        let step = match index {
            [0, 0] => n,
            _ => n.div_ceil(8).saturating_mul(8).saturating_add(HEADER as u64),
        };
        match usize::try_from(step) {
            Ok(0) => return true,
            Ok(step) if step <= heap.len() - at => at += step,
            // The library notices what leads beyond the end.
            _ => return false,
        }
    }
    false
}

/// Whether the file holds a reference (length, address, index) to something in the heap at `at`.
fn is_referred_to(file: &mut File, at: u64) -> io::Result<bool> {
    for address in find(file, at.to_le_bytes())? {
        let Some(start) = address.checked_sub(4) else { continue };
        let mut bytes = [0; 16];
        file.seek(SeekFrom::Start(start))?;
        if file.read_exact(&mut bytes).is_ok() && bytes[..4] != [0; 4] && bytes[12..] != [0; 4] {
            return Ok(true);
        }
    }
    Ok(false)
}

fn word(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..at + 8)?.try_into().ok().map(u64::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A heap with one text and free space of `free` bytes, and a reference to the text.
    fn file_with(free: u64, is_used: bool) -> tempfile::NamedTempFile {
        let start = BLOCK - 5;
        let mut bytes = vec![7; start];
        bytes.extend(SIGNATURE);
        bytes.extend(4096_u64.to_le_bytes());
        for (index, size) in [(1_u64, 5_u64), (0, free)] {
            bytes.extend(index.to_le_bytes());
            bytes.extend(size.to_le_bytes());
            bytes.extend([0; 8]);
        }
        bytes.resize(start + 4096, 0);
        bytes.extend(5_u32.to_le_bytes());
        bytes.extend(if is_used { start as u64 } else { 1 }.to_le_bytes());
        bytes.extend(1_u32.to_le_bytes());
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), bytes).expect("written");
        file
    }

    #[test]
    fn heap_without_end_is_found_where_something_refers_to_it() {
        let found = |free, is_used| unreadable(file_with(free, is_used).path()).expect("readable");
        assert_eq!(found(0, true), Some(BLOCK as u64 - 5));
        assert_eq!(found(0, false), None);
        assert_eq!(found(4096 - 40, true), None);
        assert_eq!(found(u64::MAX, true), None);
    }
}
