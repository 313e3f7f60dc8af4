//! Memory still available to a process: free memory of the system, within the limits on the process.

use std::path::Path;

/// Bytes that can be had without swapping and within the limits on this process and on its control
/// groups, where the system reports it.
#[must_use]
pub fn available_memory_bytes() -> Option<u64> {
    [
        system_bytes(),
        address_space_bytes(),
        control_group_bytes(Path::new("/sys/fs/cgroup")),
    ]
    .into_iter()
    .flatten()
    .min()
}

fn system_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    kibibytes_of(&text, "MemAvailable:")
}

/// Address space left within `ulimit -v`.
#[cfg(unix)]
fn address_space_bytes() -> Option<u64> {
    let limit = rustix::process::getrlimit(rustix::process::Resource::As).current?;
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    Some(limit.saturating_sub(kibibytes_of(&status, "VmSize:")?))
}

#[cfg(not(unix))]
fn address_space_bytes() -> Option<u64> {
    None
}

/// Memory left within the limits on this process' control groups, from the group itself up to the root:
/// `memory.max` of version 2, `memory.limit_in_bytes` of version 1. Pages of files that can be dropped at
/// once count as free.
fn control_group_bytes(mounted: &Path) -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    least_left_bytes(mounted, &groups)
}

fn least_left_bytes(mounted: &Path, groups: &str) -> Option<u64> {
    let left = groups.lines().flat_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let controllers = fields.next().unwrap_or_default();
        let group = fields.next().unwrap_or_default().trim_start_matches('/');
        let (root, files) = match controllers {
            "" => (mounted.to_owned(), VERSION_2),
            list if list.split(',').any(|c| c == "memory") => (mounted.join("memory"), VERSION_1),
            _ => return Vec::new(),
        };
        let innermost = root.join(group);
        innermost
            .ancestors()
            .take_while(|folder| folder.starts_with(&root))
            .filter_map(|folder| files.left_bytes(folder))
            .collect()
    });
    left.min()
}

/// Names of a control group's files.
struct GroupFiles {
    limit: &'static str,
    usage: &'static str,
    inactive: &'static str,
}

const VERSION_2: GroupFiles = GroupFiles {
    limit: "memory.max",
    usage: "memory.current",
    inactive: "inactive_file",
};

const VERSION_1: GroupFiles = GroupFiles {
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    inactive: "total_inactive_file",
};

impl GroupFiles {
    fn left_bytes(&self, folder: &Path) -> Option<u64> {
        let number = |name: &str| -> Option<u64> {
            let text = std::fs::read_to_string(folder.join(name)).ok()?;
            text.trim().parse().ok()
        };
        let limit = number(self.limit)?;
        let usage = number(self.usage)?;
        let statistics = std::fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
        let inactive = statistics
            .lines()
            .find_map(|line| line.strip_prefix(self.inactive)?.trim().parse().ok())
            .unwrap_or(0);
        Some(limit.saturating_sub(usage.saturating_sub(inactive)))
    }
}

fn kibibytes_of(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tightest_of_all_groups_counts() {
        let folder = tempfile::tempdir().unwrap();
        let put = |group: &str, name: &str, text: &str| {
            let group = folder.path().join(group);
            std::fs::create_dir_all(&group).unwrap();
            std::fs::write(group.join(name), text).unwrap();
        };
        put("user/run", "memory.max", "max\n");
        put("user/run", "memory.current", "700\n");
        put("user", "memory.max", "1000\n");
        put("user", "memory.current", "900\n");
        put("user", "memory.stat", "anon 5\ninactive_file 300\n");
        assert_eq!(
            least_left_bytes(folder.path(), "0::/user/run\n"),
            Some(1000 - 600)
        );
        put("memory/old", "memory.limit_in_bytes", "50\n");
        put("memory/old", "memory.usage_in_bytes", "70\n");
        let both = "4:cpu:/old\n5:hugetlb,memory:/old\n0::/user/run\n";
        assert_eq!(least_left_bytes(folder.path(), both), Some(0));
        assert_eq!(least_left_bytes(folder.path(), "0::/\n"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_machine_tells() {
        assert!(available_memory_bytes().is_some_and(|bytes| bytes > 1 << 20));
    }
}
