//! The files of a cache: read whole, written beside and renamed, the least recently used removed.
//!
//! Nobody ever sees a file half written, and processes need no lock: whoever writes a model last
//! replaces it by an equal one.

#![expect(clippy::disallowed_methods, reason = "ages of files are wall time")]

use std::fs::{self, Metadata, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

use ffr_dynamics::memory;
use result_files::file::plain_file;

use super::Name;

/// Ending of models.
const MODEL: &str = "model";
/// Ending of files that are being written.
const PART: &str = "part";
/// Age from which a file that is being written belongs to a process that has died.
const STALE: Duration = Duration::from_secs(3600);
/// Marks folders that need no backup (<https://bford.info/cachedir/>).
const TAG: (&str, &str) = (
    "CACHEDIR.TAG",
    "Signature: 8a477f597d28d172789f06886806bc55\n# Models kept by fbimpact; may be deleted at any time.\n",
);

/// A folder of models.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
    limit: u64,
}

/// What is in a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Contents {
    /// Number of models.
    pub models: usize,
    /// Their size \[bytes\].
    pub bytes: u64,
}

struct Entry {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
    is_model: bool,
}

impl Folder {
    /// The folder at `path`, whose models may take `limit` bytes.
    pub fn new(path: PathBuf, limit: u64) -> Self {
        Self { path, limit }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file of the model called `name`.
    pub fn file(&self, name: &Name) -> PathBuf {
        self.path.join(hexadecimal(name)).with_extension(MODEL)
    }

    /// The bytes of a model, which counts as used now; nothing if it is not there.
    ///
    /// # Errors
    /// If it is there and cannot be read.
    pub fn read(&self, name: &Name) -> io::Result<Option<Vec<u8>>> {
        let path = self.file(name);
        if path.is_symlink() {
            return Err(io::Error::other("it is a link"));
        }
        let mut file = match plain_file::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        let data = file.metadata()?;
        if !is_own(&data) || is_writable(&data) {
            return Err(io::Error::other("others may have written it"));
        }
        if data.len() > self.limit.min(memory::free().unwrap_or(u64::MAX)) {
            return Err(io::Error::other("it is larger than the cache, or than the memory that is left"));
        }
        let mut bytes = Vec::with_capacity(data.len() as usize);
        file.read_to_end(&mut bytes)?;
        // In a folder that may only be read, the order of use stays as it is.
        if let Err(error) = file.set_modified(SystemTime::now()) {
            tracing::debug!("{}: {error}", path.display());
        }
        Ok(Some(bytes))
    }

    /// Writes a model and makes room for it. One that is larger than the limit is not kept.
    ///
    /// # Errors
    /// If the folder cannot be made or the file not be written.
    pub fn write(&self, name: &Name, bytes: &[u8]) -> io::Result<()> {
        if bytes.len() as u64 > self.limit {
            tracing::debug!("a model of {} bytes is larger than the cache may be", bytes.len());
            return Ok(());
        }
        self.create()?;
        let path = self.file(name);
        let part = self.part(name);
        let written = write_new(&part, bytes).and_then(|()| fs::rename(&part, &path));
        if let Err(error) = written {
            // What is left of it is removed later if it cannot be now.
            let _ = fs::remove_file(&part);
            return Err(error);
        }
        self.make_room(&path)
    }

    fn create(&self) -> io::Result<()> {
        fs::create_dir_all(&self.path)?;
        match OpenOptions::new().write(true).create_new(true).open(self.path.join(TAG.0)) {
            Ok(mut tag) => tag.write_all(TAG.1.as_bytes()),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// A name that no other writer takes.
    fn part(&self, name: &Name) -> PathBuf {
        static WRITTEN: AtomicU64 = AtomicU64::new(0);
        let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
        // Process numbers repeat on the machines of a cluster.
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |t| t.as_nanos());
        let file = format!("{}-{}-{number}-{now:x}", hexadecimal(name), std::process::id());
        self.path.join(file).with_extension(PART)
    }

    /// Removes the least recently used models above the limit, `newest` last, and what dead
    /// processes left.
    fn make_room(&self, newest: &Path) -> io::Result<()> {
        let mut entries = self.entries()?;
        let now = SystemTime::now();
        for dead in entries.iter().filter(|e| !e.is_model) {
            if now.duration_since(dead.used).is_ok_and(|age| age > STALE) {
                remove(&dead.path)?;
            }
        }
        entries.retain(|e| e.is_model);
        entries.sort_by_key(|e| (e.path == newest, e.used));
        let mut total: u64 = entries.iter().map(|e| e.bytes).sum();
        for entry in &entries {
            if total <= self.limit {
                break;
            }
            remove(&entry.path)?;
            total -= entry.bytes;
        }
        Ok(())
    }

    /// How many models there are, and their size.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn contents(&self) -> io::Result<Contents> {
        let entries = self.entries()?;
        let models = || entries.iter().filter(|e| e.is_model);
        Ok(Contents { models: models().count(), bytes: models().map(|e| e.bytes).sum() })
    }

    /// Removes all models, and nothing else that may be in the folder; returns what there was.
    ///
    /// # Errors
    /// If the folder cannot be read or a file not be removed.
    pub fn clear(&self) -> io::Result<Contents> {
        let mut removed = Contents::default();
        for entry in self.entries()? {
            remove(&entry.path)?;
            if entry.is_model {
                removed.models += 1;
                removed.bytes += entry.bytes;
            }
        }
        Ok(removed)
    }

    /// Files of models, and those that are being written. Without a folder there are none.
    fn entries(&self) -> io::Result<Vec<Entry>> {
        let listing = match fs::read_dir(&self.path) {
            Ok(listing) => listing,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(error),
        };
        let mut entries = Vec::new();
        for file in listing {
            let file = file?;
            let path = file.path();
            let Some(is_model) = kind(&path) else { continue };
            match file.metadata() {
                // In a folder that several people use, each looks after their own.
                Ok(data) if !is_own(&data) => {}
                Ok(data) => {
                    let used = data.modified()?;
                    entries.push(Entry { path, bytes: data.len(), used, is_model });
                }
                // Another process was faster.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Ok(entries)
    }
}

/// Whether a file belongs to the user of this process.
#[cfg(unix)]
fn is_own(data: &Metadata) -> bool {
    std::os::unix::fs::MetadataExt::uid(data) == nix::unistd::geteuid().as_raw()
}

#[cfg(not(unix))]
fn is_own(_: &Metadata) -> bool {
    true
}

/// Whether others than its owner may write a file, or it is no file.
fn is_writable(data: &Metadata) -> bool {
    #[cfg(unix)]
    let others = std::os::unix::fs::MetadataExt::mode(data) & 0o022 != 0;
    #[cfg(not(unix))]
    let others = false;
    others || !data.is_file()
}

/// Whether a file is a model or one that is being written; none for files of others.
fn kind(path: &Path) -> Option<bool> {
    let stem = path.file_stem()?.to_str()?;
    let (name, rest) = stem.split_at_checked(64)?;
    let is_name = name.bytes().all(|b| b.is_ascii_hexdigit());
    match path.extension()?.to_str()? {
        MODEL if is_name && rest.is_empty() => Some(true),
        PART if is_name && rest.starts_with('-') => Some(false),
        _ => None,
    }
}

fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    // Whatever the user's usual mode is: what others may write is not read again.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o644);
    let mut file = options.open(path)?;
    file.write_all(bytes)?;
    // Otherwise a crash of the machine may leave a name without its contents; the checksum would
    // find that, too.
    file.sync_all()
}

/// Removes a file that another process may have removed already.
fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn hexadecimal(name: &Name) -> String {
    name.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(limit: u64) -> (tempfile::TempDir, Folder) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("models");
        (directory, Folder::new(path, limit))
    }

    fn age(folder: &Folder, name: &Name, seconds: u64) {
        let file = OpenOptions::new().append(true).open(folder.file(name)).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
    }

    #[test]
    fn what_is_written_is_read_and_what_is_not_is_missing() {
        let (_directory, folder) = folder(100);
        assert_eq!(folder.read(&[1; 32]).unwrap(), None);
        assert_eq!(folder.contents().unwrap(), Contents::default());
        folder.write(&[1; 32], b"abc").unwrap();
        assert_eq!(folder.read(&[1; 32]).unwrap().as_deref(), Some(&b"abc"[..]));
        assert_eq!(folder.contents().unwrap(), Contents { models: 1, bytes: 3 });
    }

    #[test]
    fn the_least_recently_used_models_go_first() {
        let (_directory, folder) = folder(100);
        for (n, seconds) in [(1, 30), (2, 20), (3, 10)] {
            folder.write(&[n; 32], &[0; 30]).unwrap();
            age(&folder, &[n; 32], seconds);
        }
        folder.read(&[1; 32]).unwrap(); // the oldest one is used
        folder.write(&[4; 32], &[0; 30]).unwrap();
        let is_there = |n: u8| folder.file(&[n; 32]).exists();
        assert_eq!([1, 2, 3, 4].map(is_there), [true, false, true, true]);
    }

    #[test]
    fn a_model_above_the_limit_removes_nothing() {
        let (_directory, folder) = folder(100);
        folder.write(&[1; 32], &[0; 60]).unwrap();
        folder.write(&[2; 32], &[0; 101]).unwrap();
        assert_eq!(folder.contents().unwrap(), Contents { models: 1, bytes: 60 });
    }

    #[test]
    fn files_of_others_are_left_alone() {
        let (_directory, folder) = folder(100);
        folder.write(&[1; 32], &[0; 60]).unwrap();
        let others = ["notes.txt", "a.model", "CACHEDIR.TAG"].map(|name| folder.path().join(name));
        others.iter().for_each(|path| fs::write(path, "mine").unwrap());
        folder.write(&[2; 32], &[0; 60]).unwrap();
        assert_eq!(folder.clear().unwrap(), Contents { models: 1, bytes: 60 });
        assert!(others.iter().all(|path| path.exists()));
    }

    /// What others may have written is not read, and links are left as they are.
    #[cfg(unix)]
    #[test]
    fn entries_that_others_may_have_written_are_not_read() {
        use std::os::unix::fs::{PermissionsExt, chown, symlink};
        let (_directory, folder) = folder(100);
        let name = [1; 32];
        folder.write(&name, b"abc").unwrap();
        let path = folder.file(&name);
        for mode in [0o666, 0o664, 0o646] {
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            assert!(folder.read(&name).is_err(), "{mode:o}");
        }
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
        assert!(folder.read(&name).unwrap().is_some());
        // A hole takes no room on the disk, and all of the memory when it is read.
        let set_length = |n| OpenOptions::new().write(true).open(&path).unwrap().set_len(n).unwrap();
        set_length(101);
        assert!(folder.read(&name).is_err());
        set_length(3);
        assert!(folder.read(&name).unwrap().is_some());
        // Only root may give files away.
        if chown(&path, Some(65534), None).is_ok() {
            assert!(folder.read(&name).is_err());
            assert_eq!(folder.contents().unwrap(), Contents::default());
            folder.clear().unwrap();
            assert!(path.exists(), "what belongs to others stays");
        }
        fs::remove_file(&path).unwrap();
        let target = folder.path().join("precious");
        fs::write(&target, b"abc").unwrap();
        let before = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
        OpenOptions::new().append(true).open(&target).unwrap().set_modified(before).unwrap();
        symlink(&target, &path).unwrap();
        assert!(folder.read(&name).is_err());
        assert_eq!(target.metadata().unwrap().modified().unwrap(), before);
        folder.write(&name, b"new").unwrap();
        assert_eq!(
            (fs::read(&target).unwrap(), folder.read(&name).unwrap()),
            (b"abc".to_vec(), Some(b"new".to_vec()))
        );
    }

    #[test]
    fn what_dead_processes_left_is_removed_after_an_hour() {
        let (_directory, folder) = folder(100);
        folder.write(&[1; 32], b"abc").unwrap();
        let (old, new) = (folder.part(&[2; 32]), folder.part(&[2; 32]));
        assert_ne!(old, new);
        write_new(&old, b"a").unwrap();
        write_new(&new, b"b").unwrap();
        let before = SystemTime::now() - Duration::from_secs(7200);
        OpenOptions::new().append(true).open(&old).unwrap().set_modified(before).unwrap();
        folder.write(&[3; 32], b"abc").unwrap();
        assert!(!old.exists() && new.exists());
        assert_eq!(folder.contents().unwrap().models, 2);
    }

    #[test]
    fn writers_and_readers_at_once_see_whole_files() {
        let (_directory, folder) = folder(10_000);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..50 {
                        folder.write(&[1; 32], &[5; 1000]).unwrap();
                        let read = folder.read(&[1; 32]).unwrap();
                        assert!(read.is_none_or(|bytes| bytes == [5; 1000]));
                    }
                });
            }
        });
        assert_eq!(folder.contents().unwrap(), Contents { models: 1, bytes: 1000 });
    }
}
