//! Why a file could not be read or written, in words that say what to do.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The cause of an HDF5 error without the library's addresses and call names, and a remedy where there is one.
pub fn of_hdf5(error: &hdf5::Error) -> String {
    let text = error.to_string();
    // System errors stand in the text as `errno = 28, error message = 'No space left on device'`.
    let number = text.split("errno = ").nth(1).and_then(|t| t.split(',').next()).and_then(|n| n.parse().ok());
    if let Some(number) = number {
        return of_io(&io::Error::from_raw_os_error(number));
    }
    // `H5Fopen(): unable to synchronously open file: file signature not found`: the end says it best.
    let cause = match text.split_once("(): ") {
        Some((call, cause)) if call.starts_with("H5") => cause,
        _ => text.as_str(),
    };
    if cause.contains("truncated file") {
        return "truncated file, it was cut off while it was copied or written; copy it again or repeat the run".into();
    }
    if cause.contains("file signature not found") {
        return "file signature not found, it is empty or of another format".into();
    }
    cause.to_owned()
}

/// A system error, and a remedy where there is one.
pub fn of_io(error: &io::Error) -> String {
    let remedy = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => ", free some space or name another folder",
        ErrorKind::FileTooLarge => ", raise the limit of file sizes (ulimit -f) or name another folder",
        ErrorKind::PermissionDenied => ", change its permissions or name another folder",
        ErrorKind::ReadOnlyFilesystem => ", name another folder",
        _ => "",
    };
    format!("{error}{remedy}")
}

/// Flushes and closes `file`, so that a full disk is an error and not a broken file.
///
/// # Errors
/// Those of the library.
pub fn close(file: hdf5::File) -> hdf5::Result<()> {
    file.flush()?;
    file.close()
}

/// Writes `bytes` to `path` in whole or not at all: aside first, under a name of this process.
///
/// # Errors
/// Those of the file system; an earlier file then stays as it was.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    whole(path, |part| std::fs::File::create(part)?.write_all(bytes))
}

/// Has `write` write a file aside, and gives it its name if that succeeds.
///
/// # Errors
/// Those of `write` and of the file system; an earlier file then stays as it was.
pub fn whole<E: From<io::Error>>(path: &Path, write: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
    let part = aside(path);
    let written = write(&part).and_then(|()| std::fs::rename(&part, path).map_err(E::from));
    if written.is_err() {
        // What cannot be written may not be there to be removed.
        let _ = std::fs::remove_file(&part);
    }
    written
}

/// A name next to `path` that no other process uses.
fn aside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_name_the_cause_and_a_remedy_without_addresses() {
        let full = "H5Dwrite(): can't write: file write failed: time = Sat, filename = 'a.h5', errno = 28, \
            error message = 'No space left on device', buf = 0x55ca";
        let reason = of_hdf5(&hdf5::Error::from(full));
        assert!(
            reason.starts_with("No space left on device") && reason.contains("free some space"),
            "{reason}"
        );
        let cut = of_hdf5(&hdf5::Error::from("H5Fopen(): unable to open file: truncated file: eof = 1"));
        assert!(cut.contains("copy it again"), "{cut}");
        assert_eq!(of_hdf5(&hdf5::Error::from("H5Gopen2(): no such group")), "no such group");
        assert_eq!(of_hdf5(&hdf5::Error::from("shapes differ")), "shapes differ");
    }

    #[test]
    fn failed_write_leaves_the_earlier_file_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("table.csv");
        write_whole(&path, b"old").expect("written");
        let failed: io::Result<()> = whole(&path, |part| {
            std::fs::write(part, "ne")?;
            Err(io::Error::from(ErrorKind::StorageFull))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).expect("readable"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 1);
    }
}
