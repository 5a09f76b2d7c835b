//! What a command may write: never over what it reads, over other files only if this program wrote them, or with `--force`.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use hdf5::types::VarLenUnicode;

use super::fault::FileError;
use super::{hdf5_integrity, plain_file, whole_file};

/// Bytes at the beginning and at the end of a file in which its mark stands.
const SEARCHED: u64 = 4096;

/// How a file of this program is recognised.
#[derive(Debug, Clone, Copy)]
enum Mark {
    /// Value of the root attribute `format`.
    Hdf5(&'static str),
    /// Bytes near its beginning or its end.
    Bytes(&'static [u8]),
    /// Not at all.
    None,
}

/// What is written.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    name: &'static str,
    mark: Mark,
}

impl Kind {
    /// HDF5 with this root attribute `format`.
    pub const fn hdf5(name: &'static str, format: &'static str) -> Self {
        Self { name, mark: Mark::Hdf5(format) }
    }

    /// A file in which these bytes stand.
    pub const fn marked(name: &'static str, mark: &'static str) -> Self {
        Self { name, mark: Mark::Bytes(mark.as_bytes()) }
    }

    /// A file that could be anybody's.
    pub const fn unmarked(name: &'static str) -> Self {
        Self { name, mark: Mark::None }
    }

    /// Whether `path` is such a file of this program.
    pub fn is_own(&self, path: &Path) -> bool {
        match self.mark {
            Mark::Hdf5(format) => hdf5_format(path).as_deref() == Some(format),
            Mark::Bytes(mark) => ends(path).is_ok_and(|bytes| bytes.windows(mark.len()).any(|w| w == mark)),
            Mark::None => false,
        }
    }
}

/// The root attribute `format` of a file of HDF5.
fn hdf5_format(path: &Path) -> Option<String> {
    let file = hdf5_integrity::open(path).ok()?;
    let format: VarLenUnicode = file.attr("format").ok()?.read_scalar().ok()?;
    Some(format.as_str().to_owned())
}

/// The first and the last bytes of a file.
fn ends(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = plain_file::open(path)?;
    let mut bytes = Vec::new();
    (&mut file).take(SEARCHED).read_to_end(&mut bytes)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(SEARCHED).max(bytes.len() as u64)))?;
    file.take(SEARCHED).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The gate that every output of a command goes through.
#[derive(Debug, Clone, Default)]
pub struct Gate {
    inputs: Vec<(PathBuf, String)>,
    force: bool,
}

impl Gate {
    /// The gate of a command that reads `inputs`, each with what it is, and may replace files of others if `force` is set.
    pub fn new(inputs: impl IntoIterator<Item = (PathBuf, String)>, force: bool) -> Self {
        Self { inputs: inputs.into_iter().collect(), force }
    }

    /// The gate of a command that reads `files`.
    pub fn of_files<'a>(files: impl IntoIterator<Item = &'a PathBuf>, force: bool) -> Self {
        Self::new(files.into_iter().map(|file| (file.clone(), "read by this command".to_owned())), force)
    }

    /// Whether `output` may be written as a file of `kind`; asked before the work.
    ///
    /// # Errors
    /// What forbids it, and what to do.
    pub fn check(&self, output: &Path, kind: Kind) -> Result<(), FileError> {
        let refuse = |reason: String| Err(FileError::new(output, reason.into()));
        if let Some((_, what)) = self.inputs.iter().find(|(input, _)| is_same(input, output)) {
            return refuse(format!("is {what}, name another output"));
        }
        whole_file::check(output).map_err(|fault| FileError::new(output, fault))?;
        if !self.force && output.exists() && !kind.is_own(output) {
            let name = kind.name;
            return refuse(format!("exists and is not {name}, choose another name or add --force"));
        }
        Ok(())
    }

    /// Has `write` write `output` as a file of `kind`, in whole or not at all.
    ///
    /// # Errors
    /// What forbids it, and those of the file system.
    pub fn write(
        &self,
        output: &Path,
        kind: Kind,
        write: impl FnOnce(&Path) -> io::Result<()>,
    ) -> Result<(), FileError> {
        self.check(output, kind)?;
        whole_file::make(output, write)
    }
}

/// Whether two names lead to the same file, by links of either kind as well.
pub fn is_same(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    let id = |path: &Path| {
        use std::os::unix::fs::MetadataExt;
        path.metadata().map(|m| (m.dev(), m.ino()))
    };
    #[cfg(not(unix))]
    let id = |path: &Path| path.canonicalize();
    matches!((id(a), id(b)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_is_found_at_either_end() {
        let folder = tempfile::tempdir().expect("a folder");
        let kind = Kind::marked("a page", "<made>");
        let path = folder.path().join("a");
        for (text, is_own) in [
            ("<made>".to_owned(), true),
            (String::new(), false),
            ("x".repeat(10_000) + "<made>", true),
            ("x".repeat(4090) + "<made>" + &"x".repeat(4090), true),
            ("x".repeat(9000) + "<made>" + &"x".repeat(9000), false),
        ] {
            std::fs::write(&path, text).expect("written");
            assert_eq!(kind.is_own(&path), is_own);
        }
        assert!(!Kind::unmarked("a film").is_own(&path) && !Kind::hdf5("a result", "fbimpact").is_own(&path));
    }
}
