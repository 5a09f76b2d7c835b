//! Memory that the machine has left, asked before a factor is computed.

/// Share of the free memory that one factor may take: eigenmodes, compliance and a second body need some, too.
const SHARE: f64 = 0.8;

/// Free memory of the machine in bytes; `None` where the system does not tell.
fn free() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    kilobytes(&text, "MemAvailable:").map(|kilobytes| 1024 * kilobytes)
}

/// The value of `key` in the format of `/proc/meminfo` \[kB\].
fn kilobytes(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find(|line| line.starts_with(key))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// Gigabytes that are free, if `bytes` do not fit into them.
pub fn shortage(bytes: f64) -> Option<f64> {
    free().map(|free| free as f64).filter(|free| bytes > SHARE * free).map(|free| 1e-9 * free)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_by_its_name() {
        let text = "MemTotal:       24000000 kB\nMemFree:         1000000 kB\nMemAvailable:   12000000 kB\n";
        assert_eq!(kilobytes(text, "MemAvailable:"), Some(12_000_000));
        assert_eq!(kilobytes(text, "SwapFree:"), None);
        assert_eq!(kilobytes("MemAvailable: many", "MemAvailable:"), None);
    }

    #[test]
    fn a_few_bytes_fit_and_an_exabyte_does_not() {
        assert_eq!(shortage(8.0), None);
        if free().is_some() {
            assert!(shortage(1e18).is_some());
        }
    }
}
