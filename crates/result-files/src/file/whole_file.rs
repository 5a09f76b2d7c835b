//! Files that are written in whole or not at all.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::file::fault::{Access, FileError, FileFault};

/// What is wrong with an output that is no file.
pub const DEVICE: &str = "is a device or pipe, name a file with -o";

/// Names that are tried for a file aside.
const MOST_TRIES: u32 = 1000;

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
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    make(path, |part| File::create(part)?.write_all(bytes))
}

/// [`replace`] with errors that name the file.
///
/// # Errors
/// Those of `write` and of the file system; an earlier file then stays as it was.
pub fn make(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<(), FileError> {
    replace(path, write).map_err(|e| FileError::new(path, FileFault::system(Access::Write, e)))
}

/// Has `write` write a file aside, and gives it its name if that succeeds.
///
/// # Errors
/// Those of `write` and of the file system; an earlier file then stays as it was.
pub fn replace<E: From<io::Error>>(path: &Path, write: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
    let part = aside(path)?;
    let written = write(&part).and_then(|()| std::fs::rename(&part, path).map_err(E::from));
    if written.is_err() {
        // What cannot be written may not be there to be removed.
        let _ = std::fs::remove_file(&part);
    }
    written
}

/// Whether [`replace`] can write `path`, asked before the work: what refuses there, refuses here.
///
/// # Errors
/// What is wrong with the name, its folder or what stands there.
pub fn check(path: &Path) -> Result<(), FileFault> {
    let name = path.file_name().filter(|name| {
        // `out/` and `out/.` are folders even if they do not exist.
        path.as_os_str().as_encoded_bytes().ends_with(name.as_encoded_bytes())
    });
    if name.is_none() || path.is_dir() {
        return Err("is a directory, name a file with -o".into());
    }
    let directory = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !directory.is_dir() {
        let directory = directory.display();
        return Err(format!("directory {directory} does not exist, create it or choose another one").into());
    }
    // Links are followed, or replaced: what counts is where they lead.
    if path.exists() && !path.is_file() {
        return Err(DEVICE.into());
    }
    let fail = |e| FileFault::system(Access::Write, e);
    let standing = no_probe();
    let probe = aside(path).map_err(fail)?;
    // Who clears the path at this moment has removed it.
    std::fs::remove_file(&probe)
        .or_else(|e| if e.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(e) })
        .map_err(fail)?;
    drop(standing);
    if is_kept(path, directory) {
        return Err(fail(io::ErrorKind::PermissionDenied.into()));
    }
    Ok(())
}

/// Waits until no file stands by which [`check`] asks, and keeps others from standing: who ends the process from another thread holds it meanwhile,
/// so that none is left.
pub fn no_probe() -> MutexGuard<'static, ()> {
    static STANDING: Mutex<()> = Mutex::new(());
    STANDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the file `path` may not be replaced because it is somebody else's in a folder where each
/// keeps their own, as /tmp.
#[cfg(unix)]
fn is_kept(path: &Path, directory: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    let (Ok(file), Ok(directory)) = (path.symlink_metadata(), directory.metadata()) else { return false };
    let user = nix::unistd::geteuid().as_raw();
    directory.mode() & STICKY != 0 && ![file.uid(), directory.uid(), 0].contains(&user)
}

#[cfg(not(unix))]
fn is_kept(_: &Path, _: &Path) -> bool {
    false
}

/// Removes what killed processes left of files that they were about to write to `path`. Nobody else may write `path` meanwhile.
pub fn clear_remains(path: &Path) {
    let directory = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = directory.read_dir() else { return };
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    for entry in entries.flatten().filter(|e| is_aside(name, e.file_name().as_encoded_bytes())) {
        // What cannot be removed harms nobody.
        let _ = std::fs::remove_file(entry.path());
    }
}

/// Whether `other` is a name that [`aside`] gives for `name`.
fn is_aside(name: &[u8], other: &[u8]) -> bool {
    let numbers = || other.strip_prefix(name)?.strip_prefix(b".")?.strip_suffix(b".tmp");
    let is_number = |digits: &[u8]| !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    numbers().is_some_and(|n| {
        n.iter().filter(|c| **c == b'-').count() == 1 && n.split(|c| *c == b'-').all(is_number)
    })
}

/// A new, empty file next to `path` under a name that nobody has: none is replaced, no link followed.
fn aside(path: &Path) -> io::Result<PathBuf> {
    static MADE: AtomicU64 = AtomicU64::new(0);
    let mut tries = 0;
    loop {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}-{}.tmp", std::process::id(), MADE.fetch_add(1, Ordering::Relaxed)));
        let part = path.with_file_name(name);
        tries += 1;
        match File::create_new(&part) {
            // What a dead process of this number left stays.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && tries < MOST_TRIES => {}
            made => return made.map(|_| part),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;

    use super::*;

    #[test]
    fn failed_write_leaves_the_earlier_file_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("table.csv");
        super::write(&path, b"old").expect("written");
        let failed: io::Result<()> = replace(&path, |part| {
            std::fs::write(part, "ne")?;
            Err(io::Error::from(ErrorKind::StorageFull))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).expect("readable"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 1);
    }

    #[test]
    fn remains_of_killed_processes_are_cleared_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.h5");
        let mut others = [
            "a.h5",
            "a.h5.1-0-2.tmp",
            "a.h5.1.tmp",
            "a.h5.-0.tmp",
            "a.h5.restart.1-0.tmp",
            "a.h5.x-0.tmp",
            "b.h5.1-0.tmp",
        ];
        for name in others.iter().chain(&["a.h5.1-0.tmp", "a.h5.12345-17.tmp"]) {
            std::fs::write(folder.path().join(name), b"").expect("written");
        }
        clear_remains(&path);
        let mut left: Vec<_> = folder
            .path()
            .read_dir()
            .expect("readable")
            .flatten()
            .map(|e| e.file_name().into_string().expect("a name"))
            .collect();
        left.sort();
        others.sort_unstable();
        assert_eq!(left, others);
    }

    #[cfg(unix)]
    #[test]
    fn no_planted_link_is_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, precious) = (folder.path().join("table.csv"), folder.path().join("precious"));
        std::fs::write(&precious, b"precious").expect("written");
        // Names that this process may take next.
        for number in 0..200 {
            let name = format!("table.csv.{}-{number}.tmp", std::process::id());
            std::os::unix::fs::symlink(&precious, folder.path().join(name)).expect("linked");
        }
        check(&path).expect("writable");
        super::write(&path, b"new").expect("written");
        assert_eq!(std::fs::read(&precious).expect("readable"), b"precious");
        assert_eq!(std::fs::read(&path).expect("readable"), b"new");
    }
}
