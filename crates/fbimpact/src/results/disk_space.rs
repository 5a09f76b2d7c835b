//! Space on the disk that is there before HDF5 needs it.
//!
//! HDF5 flushes its metadata piece by piece. Where the disk fills up half-way, old and new pieces
//! contradict each other and nothing can be read any more. So zeros are put behind the end of
//! the file first, as blocks that the file system keeps for them where it can: if that fails, the file is still that of the last flush, and if it succeeds, the
//! flush cannot fail for want of space.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Zeros written at a time.
const BLOCK: usize = 1 << 16;
/// What the file itself, its tables and texts may take between two flushes.
const ROOM: u64 = 1 << 17;
/// What a dataset may take besides its chunks: two nodes of the tree that finds them (2.6 kB each)
/// and its header.
pub const BYTES_OF_DATASET: u64 = 1 << 13;

/// Places of its version and of the length of the file in the superblock of HDF5's format 1.8 and later.
const VERSION: usize = 8;
const LENGTH: usize = 28;

/// Zeros behind the end of a file.
pub struct DiskSpace {
    file: File,
    /// End of what is certain to be on the disk; nothing after a flush, which may cut the file.
    until: u64,
}

impl DiskSpace {
    /// Opens `path`, which exists.
    pub fn new(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        Ok(Self { file, until: 0 })
    }

    /// Makes sure that the file can grow by `bytes` and some beyond `end`, where HDF5 puts what
    /// comes next.
    pub fn reserve(&mut self, end: u64, bytes: u64) -> io::Result<()> {
        let wanted = end + bytes + ROOM;
        let mut at = self.until.max(end);
        if at >= wanted {
            return Ok(());
        }
        if is_allocated(&self.file, at, wanted - at)? {
            self.until = wanted;
            return Ok(());
        }
        self.file.seek(SeekFrom::Start(at))?;
        let zeros = [0; BLOCK];
        while at < wanted {
            let n = usize::try_from(wanted - at).unwrap_or(BLOCK).min(BLOCK);
            self.file.write_all(&zeros[..n])?;
            at += n as u64;
        }
        self.until = wanted;
        Ok(())
    }

    /// To be called after every flush.
    pub fn renew(&mut self) {
        self.until = 0;
    }

    /// Cuts the closed file to the length that it says it has: what HDF5 gives back when it closes a file is known to it alone.
    pub fn trim(&mut self) -> io::Result<()> {
        let mut block = [0; LENGTH + 8];
        self.file.seek(SeekFrom::Start(0))?;
        self.file.read_exact(&mut block)?;
        let length = u64::from_le_bytes(block[LENGTH..].try_into().unwrap_or_default());
        let is_known = matches!(block[VERSION], 2 | 3) && length <= self.file.metadata()?.len();
        if is_known { self.file.set_len(length) } else { Ok(()) }
    }
}

/// Has the file system keep `n` bytes of zeros from `at` on; false if it does not do that.
#[cfg(target_os = "linux")]
fn is_allocated(file: &File, at: u64, n: u64) -> io::Result<bool> {
    use rustix::fs::{FallocateFlags, fallocate};
    use rustix::io::Errno;
    match fallocate(file, FallocateFlags::empty(), at, n) {
        Ok(()) => Ok(true),
        Err(Errno::OPNOTSUPP | Errno::NOSYS | Errno::INVAL) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// Has the file system keep bytes; not here.
#[cfg(not(target_os = "linux"))]
fn is_allocated(_: &File, _: u64, _: u64) -> io::Result<bool> {
    Ok(false)
}
