//! Whether and where models are kept.

use std::ffi::OsString;
use std::path::PathBuf;

use super::{DEFAULT_LIMIT, Folder};

/// Bytes of a GiB.
const GIB: f64 = (1u64 << 30) as f64;
/// Names the folder, or `off`.
const VARIABLE: &str = "FBIMPACT_CACHE";

/// Whether and where models are kept, and how much of them.
#[derive(Debug, Clone, PartialEq)]
pub struct CacheSettings {
    /// The folder; none if nothing is kept.
    pub path: Option<PathBuf>,
    /// Size that the folder may have \[bytes\].
    pub limit: u64,
}

impl CacheSettings {
    /// Models kept in `folder`, without one in that of the environment, `gib` GiB of them.
    pub fn kept(folder: Option<PathBuf>, gib: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the limit is not negative; more than 2^64 bytes are cut to that"
        )]
        let limit = (gib * GIB) as u64;
        Self { path: folder.or_else(default_folder), limit }
    }

    /// Nothing is kept.
    pub const NONE: Self = Self { path: None, limit: 0 };

    /// What the environment says, with the usual limit.
    pub fn of_environment() -> Self {
        Self::kept(None, DEFAULT_LIMIT)
    }

    /// The folder with its limit; none if nothing is kept.
    pub fn folder(&self) -> Option<Folder> {
        self.path.as_ref().map(|path| Folder::new(path.clone(), self.limit))
    }
}

/// The folder of the environment: `FBIMPACT_CACHE`, or the usual place of the system; none if it
/// says `off` or names none.
pub fn default_folder() -> Option<PathBuf> {
    folder_from(|name| std::env::var_os(name).filter(|value| !value.is_empty()))
}

fn folder_from(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(given) = variable(VARIABLE) {
        return (given != "off").then(|| PathBuf::from(given));
    }
    // The base directory specification says that relative paths are to be ignored.
    let absolute = |name: &str| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = if cfg!(windows) {
        absolute("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        absolute("HOME").map(|home| home.join("Library/Caches"))
    } else {
        absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")))
    };
    base.map(|base| base.join("fbimpact"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(variables: &[(&str, &str)]) -> Option<PathBuf> {
        folder_from(|name| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| OsString::from(v)))
    }

    #[test]
    fn the_variable_names_the_folder_or_switches_it_off() {
        assert_eq!(folder(&[(VARIABLE, "there"), ("HOME", "/home/a")]), Some(PathBuf::from("there")));
        assert_eq!(folder(&[(VARIABLE, "off"), ("HOME", "/home/a")]), None);
        assert_eq!(folder(&[]), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_usual_place_follows_the_base_directory_specification() {
        let home = ("HOME", "/home/a");
        assert_eq!(folder(&[home]), Some(PathBuf::from("/home/a/.cache/fbimpact")));
        assert_eq!(folder(&[home, ("XDG_CACHE_HOME", "/c")]), Some(PathBuf::from("/c/fbimpact")));
        assert_eq!(folder(&[home, ("XDG_CACHE_HOME", "c")]), Some(PathBuf::from("/home/a/.cache/fbimpact")));
    }
}
