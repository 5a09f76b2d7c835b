//! Which file a run writes: `<output>.part` while it goes on, the final name when it is done.
//!
//! The part file is held by an advisory lock, so that two runs never write one file, and so that the part file of a
//! process that died is recognised. An existing output is replaced only by a complete run, or with `--force`.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use crate::error::AppError;
use crate::reasons;

use super::FORMAT;

/// A claimed output path.
#[derive(Debug)]
pub struct OutputFile {
    target: PathBuf,
    part: PathBuf,
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
        check_target(target, force)?;
        let mut name = target.file_name().unwrap_or_default().to_owned();
        name.push(".part");
        let part = target.with_file_name(name);
        let lock = lock(&part)?;
        let output = Self { target: target.to_owned(), part, force, lock };
        if output.lock.metadata().is_ok_and(|m| m.len() > 0) {
            tracing::warn!("{} of a run that did not end is replaced", output.part.display());
        }
        Ok(output)
    }

    /// The file to write to.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Gives the file its final name, unless it is incomplete and would replace an earlier result without force.
    /// Returns where the data are.
    ///
    /// # Errors
    /// [`AppError::Io`] if the file cannot be renamed.
    pub fn finish(self, complete: bool) -> Result<PathBuf, AppError> {
        if !complete && !self.force && self.target.exists() {
            return Ok(self.part);
        }
        std::fs::rename(&self.part, &self.target).map_err(|e| {
            let reason = format!("cannot be given its final name {}: {e}", self.target.display());
            AppError::io(&self.part, reason)
        })?;
        Ok(self.target)
    }

    /// Removes the part file of a run that stored nothing.
    pub fn discard(self) {
        // A part file that cannot be removed is empty and is replaced by the next run.
        let _ = std::fs::remove_file(&self.part);
    }
}

fn check_target(target: &Path, force: bool) -> Result<(), AppError> {
    let fail = |reason: String| Err(AppError::io(target, reason));
    if target.file_name().is_none() || target.is_dir() {
        return fail("is a directory, name a file with -o".into());
    }
    let directory = match target.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    if !directory.is_dir() {
        return fail(format!("directory {} does not exist", directory.display()));
    }
    if target.exists() && !force && !is_result(target) {
        return fail("exists and is not a result file, choose another name or add --force".into());
    }
    Ok(())
}

/// Whether `path` is an HDF5 file that this program wrote.
fn is_result(path: &Path) -> bool {
    let open = || {
        let file = hdf5::File::with_options().with_fapl(|p| p.file_locking(false)).open(path)?;
        file.attr("format")?.read_scalar::<hdf5::types::VarLenUnicode>()
    };
    open().is_ok_and(|format| format.as_str() == FORMAT)
}

fn lock(part: &Path) -> Result<File, AppError> {
    let fail = |e: std::io::Error| AppError::io(part, format!("cannot be written: {}", reasons::of_io(&e)));
    // Another run may rename its part file between our opening and locking it: then we hold the wrong file, try again.
    for _ in 0..10 {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(part)
            .map_err(fail)?;
        match file.try_lock() {
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
