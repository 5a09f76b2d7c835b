//! Memory that is left, asked before a factor is computed.

use std::path::Path;
use std::sync::OnceLock;

/// Share of the free memory that one factor may take: two bodies are built side by side, and either needs its matrix, its
/// modes and its compliance, too.
const SHARE: f64 = 0.4;
/// Share of the memory left beside a factor that a second one of the same body may take, for an inertia count.
const SHARE_BESIDE: f64 = 0.8;

/// Folder in which Linux shows the limits that a container sets.
const CONTROL_GROUP: &str = "/sys/fs/cgroup";

/// Memory that the process may take \[bytes\], if a limit was given.
static LIMIT: OnceLock<u64> = OnceLock::new();

/// Sets how much memory the process may take \[bytes\]; the first call counts. Otherwise it may take what the machine has.
pub fn limit(bytes: u64) {
    LIMIT.get_or_init(|| bytes);
}

/// Memory that the process may take \[bytes\], if a limit was given.
pub fn given_limit() -> Option<u64> {
    LIMIT.get().copied()
}

/// Free memory in bytes: of the machine, what a container leaves, or what the process has not taken of its limit; `None` where it cannot be found.
fn free() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let machine = entry(&text, "MemAvailable:").map(|kilobytes| 1024 * kilobytes);
    let container = left_by(|name| std::fs::read_to_string(Path::new(CONTROL_GROUP).join(name)).ok());
    let given = given_limit().map(|limit| {
        let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        limit.saturating_sub(entry(&text, "VmRSS:").map_or(0, |kilobytes| 1024 * kilobytes))
    });
    [machine, container, given].into_iter().flatten().min()
}

/// What a control group, of the second version or the first, leaves of its limit in bytes, files that are only kept for the
/// next reader counted as free; `None` without a limit. `read` gives the text of a file in the group's folder.
fn left_by(read: impl Fn(&str) -> Option<String>) -> Option<u64> {
    let number = |name: &str| read(name)?.trim().parse::<u64>().ok();
    let (limit, used, details) = match number("memory.max") {
        Some(limit) => (limit, "memory.current", "memory.stat"),
        None => {
            (number("memory/memory.limit_in_bytes")?, "memory/memory.usage_in_bytes", "memory/memory.stat")
        }
    };
    let kept = read(details).and_then(|text| entry(&text, "inactive_file")).unwrap_or(0);
    Some(limit.saturating_sub(number(used)?.saturating_sub(kept)))
}

/// The number after `key` in a text of lines "key number …".
fn entry(text: &str, key: &str) -> Option<u64> {
    let mut words = text.lines().map(str::split_whitespace);
    words.find_map(|mut line| (line.next() == Some(key)).then(|| line.next()?.parse().ok())?)
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

/// As [`shortage`] for a factor beside the first one of its body, when all else that the body needs is there.
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
    fn a_container_leaves_its_limit_less_what_is_used() {
        let first = [("memory/memory.limit_in_bytes", "5000\n"), ("memory/memory.usage_in_bytes", "6000\n")];
        let details = "anon 1000\ninactive_file 500\nactive_file 1500\n";
        let second = |limit| [("memory.max", limit), ("memory.current", "3000\n"), ("memory.stat", details)];
        let left = |files: &[(&str, &str)]| {
            left_by(|name| files.iter().find(|file| file.0 == name).map(|file| file.1.to_owned()))
        };
        assert_eq!(left(&[]), None);
        assert_eq!(left(&first), Some(0));
        assert_eq!(left(&second("8000\n")), Some(5500));
        assert_eq!(left(&second("max\n")), None);
    }

    #[test]
    fn a_few_bytes_fit_and_an_exabyte_does_not() {
        assert_eq!(shortage(8.0), None);
        if free().is_some() {
            assert!(shortage(1e18).is_some());
        }
    }
}
