//! Why a file could not be read or written, in words that say what to do.

use std::io::{self, ErrorKind};

/// The cause of an HDF5 error without the library's addresses and call names, and a remedy where
/// there is one.
pub fn of_hdf5(error: &hdf5::Error) -> String {
    let text = error.to_string();
    // System errors stand in the text as `errno = 28, error message = 'No space left on device'`.
    let number = text.split("errno = ").nth(1).and_then(|t| t.split(',').next()).and_then(|n| n.parse().ok());
    if let Some(number) = number {
        return of_io(&io::Error::from_raw_os_error(number));
    }
    // `H5Fopen(): unable to synchronously open file: file signature not found`: the end says it
    // best.
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
}
