//! Which file a run writes: `<output>.part` while it goes on, the final name when it is done.
//!
//! The part file is held by an advisory lock, so that two runs never write one file, and so that
//! the part file of a process that died is recognised. An existing output is replaced only by a
//! complete run, or with `--force`.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::Read;
use std::path::{Path, PathBuf};

use result_files::file::fault::Access;
use result_files::file::hdf5_integrity;
use result_files::file::output::{Gate, Kind};
use result_files::file::plain_file;
use result_files::file::whole_file;
use result_files::stored::open::FORMAT;

use crate::error::AppError;

use super::{Status, journal};

/// A result.
pub const RESULT: Kind = Kind::hdf5("a result file", FORMAT);
/// Links that lead from one to the next at most, as in Linux.
const MOST_LINKS: usize = 40;

/// A claimed output path.
#[derive(Debug)]
pub struct OutputFile {
    target: PathBuf,
    part: PathBuf,
    restart: PathBuf,
    force: bool,
    /// Holds the lock until the file has its final name.
    lock: File,
}

impl OutputFile {
    /// Checks that `target` can be written and claims it.
    ///
    /// # Errors
    /// [`AppError::Io`] if the directory does not exist or cannot be written, if another run writes the file, or if the
    /// target exists, is no result file and `force` is not set.
    pub fn claim(target: &Path, force: bool) -> Result<Self, AppError> {
        let restart = restart_path(&linked(target)?);
        if !force && restart.is_file() && !restart.is_symlink() && !journal::is_own(&restart) {
            return Err(AppError::io(
                restart,
                "exists and is no restart file, choose another name or add --force",
            ));
        }
        let output = Self::claim_again(target, force)?;
        if !output.is_fresh() {
            tracing::warn!("{} of a run that did not end is replaced", output.part.display());
        }
        Ok(output)
    }

    /// As [`OutputFile::claim`], for a run that is taken up and replaces its own part file.
    ///
    /// # Errors
    /// As [`OutputFile::claim`].
    pub fn claim_again(target: &Path, force: bool) -> Result<Self, AppError> {
        let target = linked(target)?;
        check_target(&target, force)?;
        let part = part_path(&target);
        let lock = lock(&part)?;
        let restart = restart_path(&target);
        whole_file::clear_remains(&target);
        whole_file::clear_remains(&restart);
        Ok(Self { target, part, restart, force, lock })
    }

    /// Whether there was no part file before.
    fn is_fresh(&self) -> bool {
        self.lock.metadata().is_ok_and(|m| m.len() == 0)
    }

    /// The restart file, see [`super::journal`].
    pub fn restart(&self) -> &Path {
        &self.restart
    }

    /// Removes the restart file of a run that needs it no more.
    pub fn remove_restart(&self) {
        // Left behind it would be replaced by the next run.
        if journal::is_own(&self.restart) {
            let _ = std::fs::remove_file(&self.restart);
        }
    }

    /// Gives the claim up and leaves everything as it was.
    pub fn release(self) {
        if self.is_fresh() {
            self.discard();
        }
    }

    /// The file to write to.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Gives the file its final name, unless it is incomplete and would replace an earlier result
    /// without force; only interrupted runs keep their restart file. Returns where the data are.
    ///
    /// # Errors
    /// [`AppError::Io`] if the file cannot be renamed.
    pub fn finish(self, status: Status) -> Result<PathBuf, AppError> {
        let stays = status != Status::Complete && !self.force && self.target.exists();
        if stays && status == Status::Failed {
            self.remove_restart();
        }
        if stays {
            return Ok(self.part);
        }
        std::fs::rename(&self.part, &self.target).map_err(|source| {
            let target = self.target.display();
            AppError::io(&self.part, format!("cannot be given its final name {target}: {source}"))
        })?;
        // Not before: a process that dies here leaves a result with its name. What failed once
        // would fail again.
        if status != Status::Interrupted {
            self.remove_restart();
        }
        Ok(self.target)
    }

    /// Removes the part file of a run that stored nothing.
    pub fn discard(self) {
        // A part file that cannot be removed is empty and is replaced by the next run.
        let _ = std::fs::remove_file(&self.part);
    }
}

/// The file that a run writes while it goes on.
pub fn part_path(target: &Path) -> PathBuf {
    beside(target, ".part")
}

/// The restart file of a run.
pub fn restart_path(target: &Path) -> PathBuf {
    beside(target, ".restart")
}

fn beside(target: &Path, ending: &str) -> PathBuf {
    let mut name = target.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    target.with_file_name(name)
}

/// The file that `target` is a link to, also one that does not exist yet; `target` itself if it is
/// none.
///
/// # Errors
/// [`AppError::Io`] if links lead in a circle.
pub fn linked(target: &Path) -> Result<PathBuf, AppError> {
    let mut path = target.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&path) {
            Ok(next) => path = path.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(AppError::io(target, "is a link to itself, name a file with -o"))
}

fn check_target(target: &Path, force: bool) -> Result<(), AppError> {
    if target.to_str().is_none() {
        return Err(AppError::io(
            target,
            "is no name in UTF-8, which HDF5 needs; choose another name with -o",
        ));
    }
    // They are written as well; what stands there is a file of this program or nothing.
    let (part, restart) = (part_path(target), restart_path(target));
    for beside in [&part, &restart] {
        if beside.is_symlink() {
            return Err(AppError::io(
                beside,
                "is a link, which is not followed: remove it or choose another name with -o",
            ));
        }
        if beside.exists() && !beside.is_file() {
            return Err(AppError::io(beside, whole_file::DEVICE));
        }
    }
    if !force && part.exists() && !journal::is_own(&restart) && !is_part(&part) {
        return Err(AppError::io(part, "exists and is not of a run, choose another name or add --force"));
    }
    Ok(Gate::new([], force).check(target, RESULT)?)
}

/// Whether `path` is what a run has written so far: nothing, a result, or what is left of one that was killed.
fn is_part(path: &Path) -> bool {
    const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
    let mut begin = [0; 8];
    let read = plain_file::open(path).and_then(|mut file| file.read(&mut begin));
    let is_broken = || hdf5_integrity::open(path).is_err();
    read.is_ok() && (begin == [0; 8] || begin == SIGNATURE && (RESULT.is_own(path) || is_broken()))
}

/// How often a lock that is taken is tried, 20 ms apart: a process that another thread is about to
/// start holds copies of all open files, and so of their locks, until it runs its own program.
const LOCK_TRIES: u32 = 10;

fn try_lock(file: &File) -> Result<(), TryLockError> {
    for _ in 1..LOCK_TRIES {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(std::time::Duration::from_millis(20)),
            answer => return answer,
        }
    }
    file.try_lock()
}

fn lock(part: &Path) -> Result<File, AppError> {
    let fail = |e: std::io::Error| AppError::system(part, Access::Write, e);
    // Another run may rename its part file between our opening and locking it: then we hold the
    // wrong file, try again.
    for _ in 0..10 {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, nix::libc::O_NOFOLLOW);
        let file = options.open(part).map_err(fail)?;
        if has_other_names(&file) {
            return Err(AppError::io(
                part,
                "has another name as well, remove it or choose another name with -o",
            ));
        }
        match try_lock(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(AppError::io(
                    part,
                    "another run is writing this file, choose another name with -o",
                ));
            }
            // Some network disks have no locks; there the user is on their own.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
        if is_same(&file, part) {
            return Ok(file);
        }
    }
    Err(AppError::io(part, "other runs keep replacing this file, choose another name with -o"))
}

/// Whether a hard link leads to the file from elsewhere.
fn has_other_names(file: &File) -> bool {
    #[cfg(unix)]
    return file.metadata().is_ok_and(|m| std::os::unix::fs::MetadataExt::nlink(&m) > 1);
    #[cfg(not(unix))]
    return false;
}

#[cfg(unix)]
fn is_same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |m: std::fs::Metadata| (m.dev(), m.ino());
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => id(a) == id(b),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_same(_: &File, path: &Path) -> bool {
    path.exists()
}
