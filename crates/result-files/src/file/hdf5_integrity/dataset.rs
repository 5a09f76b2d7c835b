//! Lengths that a dataset claims, compared with what the file holds before memory is taken for
//! them.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use hdf5::dataset::Layout;
use hdf5::types::{TypeDescriptor, VarLenUnicode};
use hdf5::{Dataset, Error, H5Type, Result};

/// Less than this is read without a question \[bytes\].
const HARMLESS: u64 = 1 << 24;
/// Best compression that deflate reaches, rounded up.
const LARGEST_RATIO: u64 = 1040;
/// A text in a dataset: length, address of the heap, index in the heap \[bytes\].
const REFERENCE: usize = 16;
/// What stands for it in memory.
const POINTER: usize = size_of::<*const u8>();

/// All entries of a dataset in the order of rows.
///
/// # Errors
/// Those of HDF5, and if the dataset claims more than the file holds.
pub fn rows<T: H5Type>(dataset: &Dataset) -> Result<Vec<T>> {
    check(dataset)?;
    dataset.read_raw()
}

/// The text of a dataset that holds one.
///
/// # Errors
/// As [`rows`].
pub fn text(dataset: &Dataset) -> Result<String> {
    check(dataset)?;
    Ok(dataset.read_scalar::<VarLenUnicode>()?.as_str().to_owned())
}

/// The value of a dataset that holds one.
///
/// # Errors
/// As [`rows`].
pub fn scalar<T: H5Type>(dataset: &Dataset) -> Result<T> {
    check(dataset)?;
    dataset.read_scalar()
}

/// Compares what a dataset claims with what the file holds.
///
/// # Errors
/// Those of HDF5, and if it claims more, or lies in another file.
pub fn check(dataset: &Dataset) -> Result<()> {
    check_place(dataset)?;
    let shape = dataset.shape();
    let kind = dataset.dtype()?;
    let bytes = shape.iter().try_fold(kind.size() as u64, |product, n| product.checked_mul(*n as u64));
    if !bytes.is_some_and(|bytes| bytes <= HARMLESS || is_stored(dataset, &shape, bytes)) {
        return Err(damaged(dataset, &format!("shape {shape:?}, which is more than the file holds")));
    }
    // What cannot be looked at is left to HDF5.
    match (text_offsets(&kind.to_descriptor()?), File::open(dataset.filename())) {
        (Some((offsets, size)), Ok(mut file)) => check_texts(dataset, &offsets, size, &mut file),
        _ => Ok(()),
    }
}

/// Refuses what lies in other files: nothing tells what they hold then.
fn check_place(dataset: &Dataset) -> Result<()> {
    if dataset.layout() == Layout::Virtual || !dataset.dcpl()?.get_external()?.is_empty() {
        let name = dataset.name();
        let message = "lies in other files, which are not read; copy what they hold into this file";
        return Err(Error::from(format!("{name} {message}")));
    }
    Ok(())
}

fn damaged(dataset: &Dataset, what: &str) -> Error {
    let name = dataset.name();
    Error::from(format!("{name} claims {what}; the file is damaged, copy it again or make it anew"))
}

/// Whether `bytes` of this shape may be in the file.
fn is_stored(dataset: &Dataset, shape: &[usize], bytes: u64) -> bool {
    let stored = dataset.storage_size();
    match (dataset.chunk(), dataset.num_chunks()) {
        (Some(chunk), Some(n)) => {
            let needed = shape.iter().zip(chunk).map(|(length, chunk)| length.div_ceil(chunk.max(1)));
            let is_whole = needed.fold(1, usize::saturating_mul) <= n && bytes / LARGEST_RATIO <= stored;
            is_whole || is_series(dataset, shape, bytes)
        }
        _ => bytes <= stored,
    }
}

/// Whether a dataset of this shape has a row for each stored instant, and no more than a file of this length may hold:
/// of such ones chunks of zeros are left out.
fn is_series(dataset: &Dataset, shape: &[usize], bytes: u64) -> bool {
    let Some(file) = dataset.file().ok().filter(|_| dataset.name() != "/time") else { return false };
    let time = file.dataset("time").map(|time| (time.shape(), time.num_chunks(), time.chunk()));
    let Ok((length, Some(n), Some(chunk))) = time else { return false };
    let is_known = length.first().is_some_and(|rows| rows.div_ceil(chunk[0].max(1)) <= n);
    is_known && length.first() == shape.first() && bytes / LARGEST_RATIO <= file.size()
}

/// Where the references to texts stand in an entry as it is stored, and how long an entry is;
/// `None` without texts.
fn text_offsets(kind: &TypeDescriptor) -> Option<(Vec<usize>, usize)> {
    let is_text =
        |t: &TypeDescriptor| matches!(t, TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii);
    if is_text(kind) {
        return Some((vec![0], REFERENCE));
    }
    let TypeDescriptor::Compound(compound) = kind else { return None };
    // The library tells offsets in memory; each text before takes more in the file.
    let mut texts: Vec<usize> = compound.fields.iter().filter(|f| is_text(&f.ty)).map(|f| f.offset).collect();
    texts.sort_unstable();
    let growth = REFERENCE - POINTER;
    let offsets: Vec<usize> = texts.iter().enumerate().map(|(i, offset)| offset + i * growth).collect();
    let size = compound.size + offsets.len() * growth;
    (!offsets.is_empty()).then_some((offsets, size))
}

/// HDF5 takes and clears as much memory as the length of a text says before it looks for the text.
fn check_texts(dataset: &Dataset, offsets: &[usize], size: usize, file: &mut File) -> Result<()> {
    let Ok(file_bytes) = file.metadata().map(|m| m.len()) else { return Ok(()) };
    let shape = dataset.shape();
    for (start, address, n) in pieces(dataset, size) {
        let mut bytes = Vec::new();
        let is_read = file.seek(SeekFrom::Start(address)).and_then(|_| file.take(n).read_to_end(&mut bytes));
        if is_read.is_err() {
            continue;
        }
        // Chunks go beyond the last row.
        let rows = if shape.len() == 1 { shape[0].saturating_sub(start) } else { usize::MAX };
        for entry in bytes.chunks_exact(size).take(rows) {
            for offset in offsets {
                let length = entry.get(*offset..*offset + 4).and_then(|b| b.try_into().ok());
                let length = length.map_or(0, u32::from_le_bytes);
                if u64::from(length) > file_bytes {
                    return Err(damaged(dataset, &format!("a text of {length} bytes")));
                }
            }
        }
    }
    Ok(())
}

/// First row, address and length \[bytes\] of what is stored together without a filter.
fn pieces(dataset: &Dataset, size: usize) -> Vec<(usize, u64, u64)> {
    if !dataset.is_chunked() {
        let n = dataset.storage_size();
        return dataset.offset().map(|address| (0, address, n)).into_iter().collect();
    }
    if !dataset.filters().is_empty() {
        return Vec::new();
    }
    let rows: usize = dataset.chunk().unwrap_or_default().iter().fold(1, |a, n| a.saturating_mul(*n));
    let chunks = (0..dataset.num_chunks().unwrap_or(0)).filter_map(|i| dataset.chunk_info(i));
    chunks
        .filter(|chunk| chunk.size == rows.saturating_mul(size) as u64)
        .map(|chunk| (chunk.offset.first().map_or(0, |o| *o as usize), chunk.addr, chunk.size))
        .collect()
}
