//! Memory that is left, asked before a factor is computed.

mod control_groups;

use std::path::Path;
use std::sync::OnceLock;

/// Share of the free memory that one factor may take: two bodies are built side by side, and either
/// needs its matrix, its modes and its compliance, too.
const SHARE: f64 = 0.4;
/// Share of the memory left beside a factor that a second one of the same body may take, for an
/// inertia count.
const SHARE_BESIDE: f64 = 0.8;

/// Limits that the system sets a process, and what they count: `ulimit -v` and `ulimit -d`.
const PROCESS_LIMITS: [(&str, &str); 2] = [("Max address space", "VmSize:"), ("Max data size", "VmData:")];

/// Memory that the process may take \[bytes\], if a limit was given.
static LIMIT: OnceLock<u64> = OnceLock::new();

/// Sets how much memory the process may take \[bytes\]; the first call counts. Otherwise it may
/// take what the machine has.
pub fn limit(bytes: u64) {
    LIMIT.get_or_init(|| bytes);
}

/// A limit of the memory, and what is left of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Room {
    /// \[bytes\]
    limit: u64,
    /// \[bytes\]
    free: u64,
}

/// Everything that limits the memory of the process: the machine, control groups, limits of the
/// process, the limit given.
fn rooms() -> Vec<Room> {
    let read = |path: &Path| std::fs::read_to_string(path).ok();
    let text = |path: &str| read(Path::new(path)).unwrap_or_default();
    let (machine, status, limits) =
        (text("/proc/meminfo"), text("/proc/self/status"), text("/proc/self/limits"));
    let bytes = |text: &str, key| entry(text, key).map(|kilobytes| 1024 * kilobytes);
    let mut rooms = control_groups::rooms(&read);
    if let (Some(limit), Some(free)) = (bytes(&machine, "MemTotal:"), bytes(&machine, "MemAvailable:")) {
        rooms.push(Room { limit, free });
    }
    let of_process = |limit: u64, used| {
        let used = bytes(&status, used).unwrap_or(0);
        Room { limit, free: limit.saturating_sub(used) }
    };
    rooms.extend(LIMIT.get().map(|&limit| of_process(limit, "VmRSS:")));
    let set = PROCESS_LIMITS.iter().filter_map(|(name, used)| Some((process_limit(&limits, name)?, *used)));
    rooms.extend(set.map(|(limit, used)| of_process(limit, used)));
    rooms
}

/// Memory that the process may take at most \[bytes\]; `None` where it cannot be found.
pub fn most() -> Option<u64> {
    rooms().iter().map(|room| room.limit).min()
}

/// Memory that the process may take beside what it has \[bytes\]; `None` where it cannot be found.
pub fn free() -> Option<u64> {
    rooms().iter().map(|room| room.free).min()
}

/// The number after `key` in a text of lines "key number …".
fn entry(text: &str, key: &str) -> Option<u64> {
    let mut words = text.lines().map(str::split_whitespace);
    words.find_map(|mut line| (line.next() == Some(key)).then(|| line.next()?.parse().ok())?)
}

/// The limit in force after `name` in a text of lines "name soft hard unit"; `None` without a
/// limit.
fn process_limit(text: &str, name: &str) -> Option<u64> {
    let values = text.lines().find_map(|line| line.strip_prefix(name))?;
    values.split_whitespace().next()?.parse().ok()
}

/// Gigabytes for people, with digits above zero.
pub fn gigabytes(number: f64) -> String {
    match number {
        n if n >= 10.0 => format!("{n:.0}"),
        n if n >= 1.0 => format!("{n:.1}"),
        n if n >= 0.1 => format!("{n:.2}"),
        n if n >= 0.01 => format!("{n:.3}"),
        n if n >= 1e-9 => format!("{n:.1e}"),
        _ => "0".into(),
    }
}

/// Memory that does not suffice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shortage {
    /// What is free \[GB\].
    pub free: f64,
    /// The share of it that one factor may take \[GB\].
    pub room: f64,
}

/// What there is, if `bytes` do not fit into the share of the free memory that one factor may take.
pub fn shortage(bytes: f64) -> Option<Shortage> {
    shortage_of(SHARE, bytes)
}

/// As [`shortage`] for a factor beside the first one of its body, when all else that the body needs
/// is there.
pub fn shortage_beside(bytes: f64) -> Option<Shortage> {
    shortage_of(SHARE_BESIDE, bytes)
}

fn shortage_of(share: f64, bytes: f64) -> Option<Shortage> {
    let free = free()? as f64;
    (bytes > share * free).then_some(Shortage { free: 1e-9 * free, room: 1e-9 * share * free })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_by_its_name() {
        let text = "MemTotal:       24000000 kB\nMemFree:         1000000 kB\nMemAvailable:   12000000 kB\n";
        assert_eq!(entry(text, "MemAvailable:"), Some(12_000_000));
        assert_eq!(entry(text, "SwapFree:"), None);
        assert_eq!(entry("MemAvailable: many", "MemAvailable:"), None);
    }

    #[test]
    fn limit_of_the_process_is_read_by_its_name() {
        let text = "Limit             Soft Limit  Hard Limit  Units\nMax data size     unlimited   unlimited   bytes\n\
            Max address space 204800000   unlimited   bytes\n";
        assert_eq!(process_limit(text, "Max address space"), Some(204_800_000));
        assert_eq!(process_limit(text, "Max data size"), None);
        assert_eq!(process_limit(text, "Max stack size"), None);
    }

    #[test]
    fn gigabytes_have_digits_above_zero() {
        let told = [123.4, 12.3, 3.21, 0.25, 0.0123, 0.0012, 0.0].map(gigabytes);
        assert_eq!(told, ["123", "12", "3.2", "0.25", "0.012", "1.2e-3", "0"]);
    }

    #[test]
    fn a_few_bytes_fit_and_an_exabyte_does_not() {
        assert_eq!(shortage(8.0), None);
        if free().is_some() {
            assert!(shortage(1e18).is_some());
        }
    }
}
