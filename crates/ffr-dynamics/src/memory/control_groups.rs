//! Limits of memory that control groups of Linux set, those of batch systems, services and
//! containers among them.

use std::path::{Path, PathBuf};

use super::{Room, entry};

/// Limit and use in files of a group, versions 2 and 1, and the files that say what of the use is
/// only kept.
const FILES: [Files; 2] = [
    Files { limits: &["memory.max", "memory.high"], used: "memory.current", kept: "inactive_file" },
    Files { limits: &["memory.limit_in_bytes"], used: "memory.usage_in_bytes", kept: "total_inactive_file" },
];

struct Files {
    limits: &'static [&'static str],
    used: &'static str,
    kept: &'static str,
}

/// What the groups of this process and those above them leave, the narrowest of either version;
/// `read` gives the text of a file.
pub fn rooms(read: &impl Fn(&Path) -> Option<String>) -> Vec<Room> {
    let groups = read(Path::new("/proc/self/cgroup")).unwrap_or_default();
    let mounts = read(Path::new("/proc/self/mountinfo")).unwrap_or_default();
    folders(&groups, &mounts)
        .iter()
        .flat_map(|(version, folder)| of_group(&FILES[*version], folder, read))
        .collect()
}

/// Version (0: the second, 1: the first) and folder of the groups that count memory, up to the root
/// that is mounted.
fn folders(groups: &str, mounts: &str) -> Vec<(usize, PathBuf)> {
    let mut found = Vec::new();
    for mount in mounts.lines().filter_map(Mount::read) {
        let group = groups.lines().find_map(|line| {
            let (_, rest) = line.split_once(':')?;
            let (controllers, path) = rest.split_once(':')?;
            let is_meant = match mount.version {
                0 => controllers.is_empty(),
                _ => controllers.split(',').any(|name| name == "memory"),
            };
            is_meant.then_some(path)
        });
        let Some(group) = group else { continue };
        // A container sees its own group as the root; what lies outside of it has no folder here.
        let below = Path::new(group).strip_prefix(mount.root).unwrap_or(Path::new(""));
        let is_inside = below.components().all(|part| matches!(part, std::path::Component::Normal(_)));
        let below = if is_inside { below } else { Path::new("") };
        found.extend(below.ancestors().map(|part| (mount.version, Path::new(mount.at).join(part))));
    }
    found
}

/// A place where groups are mounted.
struct Mount<'a> {
    version: usize,
    /// Group that is mounted.
    root: &'a str,
    at: &'a str,
}

impl<'a> Mount<'a> {
    /// `36 25 0:32 ROOT AT OPTIONS … - KIND SOURCE OPTIONS`, if groups that count memory are
    /// mounted there.
    fn read(line: &'a str) -> Option<Self> {
        let (mount, system) = line.split_once(" - ")?;
        let mut words = mount.split(' ').skip(3);
        let (root, at) = (words.next()?, words.next()?);
        let mut words = system.split(' ');
        let version = match words.next()? {
            "cgroup2" => 0,
            "cgroup" if words.nth(1)?.split(',').any(|name| name == "memory") => 1,
            _ => return None,
        };
        Some(Self { version, root, at })
    }
}

/// What one group leaves of its limit, files that are only kept for the next reader counted as
/// free; `None` without a limit.
fn of_group(files: &Files, folder: &Path, read: &impl Fn(&Path) -> Option<String>) -> Option<Room> {
    let text = |name: &str| read(&folder.join(name));
    let number = |name: &str| text(name)?.trim().parse::<u64>().ok();
    let limit = files.limits.iter().filter_map(|name| number(name)).min()?;
    let used = number(files.used).unwrap_or(0);
    let kept = text("memory.stat").and_then(|text| entry(&text, files.kept)).unwrap_or(0);
    Some(Room { limit, free: limit.saturating_sub(used.saturating_sub(kept)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: &str = "30 23 0:26 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw\n";
    const FIRST: &str = "31 23 0:28 / /sys/fs/cgroup rw - tmpfs tmpfs rw\n\
        32 31 0:29 / /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu\n\
        35 31 0:32 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n";

    fn left(files: &[(&str, &str)]) -> Option<u64> {
        let read =
            |path: &Path| files.iter().find(|file| path == Path::new(file.0)).map(|file| file.1.to_owned());
        rooms(&read).iter().map(|room| room.free).min()
    }

    #[test]
    fn group_of_the_process_and_those_above_leave_their_limits_less_what_is_used() {
        let groups = ("/proc/self/cgroup", "0::/job_7/step_0\n");
        let mounts = ("/proc/self/mountinfo", SECOND);
        assert_eq!(left(&[groups, mounts]), None);
        let step = ("/sys/fs/cgroup/job_7/step_0/memory.max", "max\n");
        let job = [
            ("/sys/fs/cgroup/job_7/memory.max", "8000\n"),
            ("/sys/fs/cgroup/job_7/memory.current", "3000\n"),
            ("/sys/fs/cgroup/job_7/memory.stat", "anon 1000\ninactive_file 500\nactive_file 1500\n"),
        ];
        assert_eq!(left(&[groups, mounts, step, job[0], job[1], job[2]]), Some(5500));
        let root = ("/sys/fs/cgroup/memory.max", "100\n");
        assert_eq!(left(&[groups, mounts, step, job[0], job[1], job[2], root]), Some(100));
        let throttled = ("/sys/fs/cgroup/job_7/memory.high", "2600\n");
        assert_eq!(left(&[groups, mounts, job[0], throttled, job[1], job[2]]), Some(100));
    }

    #[test]
    fn groups_of_the_first_version_are_found_where_memory_is_mounted() {
        let groups = ("/proc/self/cgroup", "9:cpu,cpuacct:/\n4:memory:/slurm/job_7\n0::/\n");
        let mounts = ("/proc/self/mountinfo", FIRST);
        let files = [
            ("/sys/fs/cgroup/memory/slurm/memory.limit_in_bytes", "5000\n"),
            ("/sys/fs/cgroup/memory/slurm/memory.usage_in_bytes", "6000\n"),
            ("/sys/fs/cgroup/memory/slurm/memory.stat", "inactive_file 0\ntotal_inactive_file 1500\n"),
            ("/sys/fs/cgroup/memory/slurm/job_7/memory.limit_in_bytes", "9223372036854771712\n"),
        ];
        assert_eq!(left(&[groups, mounts, files[0], files[1], files[2], files[3]]), Some(500));
    }

    #[test]
    fn container_that_sees_its_own_group_as_root_has_its_limit() {
        let limit = ("/sys/fs/cgroup/memory.max", "700\n");
        let used = ("/sys/fs/cgroup/memory.current", "100\n");
        for group in ["0::/\n", "0::/../../other\n", "0::/elsewhere/else\n"] {
            let of_container = SECOND.replace(" / ", " /docker/7 ");
            for mounts in [SECOND, &of_container] {
                let files = [("/proc/self/cgroup", group), ("/proc/self/mountinfo", mounts), limit, used];
                assert_eq!(left(&files), Some(600), "{group}{mounts}");
            }
        }
    }
}
