//! What a build and a run are: version, commit, compiler, target, time.

use std::fs::File;
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

use sha2::{Digest, Sha256};

/// Version of the program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Where an executable comes from, which it says of itself when it starts ([`crate::main_with`]): so the library does not change with every commit.
#[derive(Debug, Clone, Copy)]
pub struct Build {
    /// The commit its sources are of, as `git describe --always --dirty` says it.
    pub commit: &'static str,
    /// The compiler, as `rustc --version` says it.
    pub compiler: &'static str,
    /// The kind of machine it is for, as a target triple.
    pub target: &'static str,
}

static BUILD: OnceLock<Build> = OnceLock::new();

impl Build {
    /// Says once where the executable comes from; what said it first stays.
    pub(crate) fn tell(self) {
        BUILD.get_or_init(|| self);
    }
}

/// Where the executable comes from; "unknown" for one that has not said it.
pub fn build() -> Build {
    *BUILD.get_or_init(|| Build { commit: "unknown", compiler: "unknown", target: "unknown" })
}

/// Several lines for `--version`.
pub fn long_version() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let Build { commit, compiler, target } = build();
        format!("{VERSION}\ncommit:   {commit}\ncompiler: {compiler}\ntarget:   {target}")
    })
}

/// Hash of the program: of version, commit, compiler and target, and of every byte of a build that no commit describes.
pub fn hash() -> [u8; 32] {
    static HASH: OnceLock<[u8; 32]> = OnceLock::new();
    *HASH.get_or_init(|| {
        let mut hash = Sha256::new();
        let Build { commit, compiler, target } = build();
        for text in [VERSION, commit, compiler, target] {
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text);
        }
        if commit == "unknown" || commit.ends_with("-dirty") {
            let read = std::env::current_exe()
                .and_then(File::open)
                .and_then(|mut file| std::io::copy(&mut file, &mut hash));
            if let Err(error) = read {
                tracing::debug!("the program's own file cannot be read: {error}");
            }
        }
        hash.finalize().into()
    })
}

/// Attributes that every result file carries.
pub fn attributes() -> [(&'static str, String); 5] {
    let Build { commit, compiler, target } = build();
    [
        ("program_version", VERSION.to_owned()),
        ("commit", commit.to_owned()),
        ("compiler", compiler.to_owned()),
        ("target", target.to_owned()),
        ("created", now()),
    ]
}

/// The present time, UTC, as in ISO 8601; 1970 if the clock stands before. Nothing else reads the
/// wall clock (clippy.toml): durations come from monotonic clocks and do not jump with it.
#[expect(clippy::disallowed_methods, reason = "the date of a result is wall time")]
fn now() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    iso(seconds)
}

/// Seconds since 1970 as a date (proleptic Gregorian calendar in eras of 400 years, which have
/// 146,097 days).
fn iso(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    // Days since 1 March of year 0: leap days then stand at the end of a year.
    let z = days + 719_468;
    let (era, day_of_era) = (z / 146_097, z % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::iso;

    #[test]
    fn dates_agree_with_the_calendar() {
        assert_eq!(iso(0), "1970-01-01T00:00:00Z");
        assert_eq!(iso(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(iso(1_709_251_199), "2024-02-29T23:59:59Z");
        assert_eq!(iso(4_107_542_400), "2100-03-01T00:00:00Z");
    }
}
