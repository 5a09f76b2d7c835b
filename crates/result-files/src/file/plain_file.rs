//! Files that are read: files and nothing else. A pipe has no end until somebody closes it, a
//! device may have none at all.

use std::fs::{File, FileType, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Opens the file `path` for reading.
///
/// # Errors
/// Those of the system, and if it is a folder, a pipe, a device or a link to one.
pub fn open(path: &Path) -> io::Result<File> {
    check(std::fs::metadata(path)?.file_type())?;
    let mut options = OpenOptions::new();
    options.read(true);
    // What was a file a moment ago may be a pipe now: opening that waits for a writer.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, nix::libc::O_NONBLOCK);
    let file = options.open(path)?;
    check(file.metadata()?.file_type())?;
    Ok(file)
}

/// The bytes of the file `path`.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = open(path)?;
    let mut bytes = Vec::with_capacity(file.metadata().map_or(0, |m| m.len() as usize));
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of the file `path`.
///
/// # Errors
/// As [`open`], and if it is no UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    let bytes = read(path)?;
    String::from_utf8(bytes).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is no UTF-8 text"))
}

fn check(kind: FileType) -> io::Result<()> {
    let (error, what) = match kind {
        kind if kind.is_file() => return Ok(()),
        kind if kind.is_dir() => (ErrorKind::IsADirectory, "it is a folder, name a file"),
        _ => (ErrorKind::InvalidInput, "it is a pipe or device, name a file"),
    };
    Err(io::Error::new(error, what))
}
