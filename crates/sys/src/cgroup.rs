//! Limits that Linux sets to groups of processes: those of containers and batch systems \[LinuxCgroup\].

use std::path::Path;

/// Memory, in bytes, that this process's groups leave it. `None` where there are no groups, or none has a limit.
pub fn available_memory() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    least(Path::new("/sys/fs/cgroup"), &groups)
}

/// The least that the groups leave. `groups`: lines `NUMBER:CONTROLLERS:PATH`; the controllers of version 2 have no
/// names. `root`: the folder in which the groups are folders.
fn least(root: &Path, groups: &str) -> Option<u64> {
    let mut least = None;
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
        let (root, names) = match controllers {
            "" => (root.to_owned(), VERSION_2),
            list if list.split(',').any(|c| c == "memory") => (root.join("memory"), VERSION_1),
            _ => continue,
        };
        // In a container the path may be that outside, of which nothing is seen: then the root is its group.
        for group in Path::new(path.trim_start_matches('/')).ancestors() {
            let left = left(&root.join(group), names);
            least = least.into_iter().chain(left).min();
        }
    }
    least
}

/// Names of the files with the limit, the use, and in the statistics what of it can be given back.
type Names = [&'static str; 3];
const VERSION_2: Names = ["memory.max", "memory.current", "inactive_file "];
const VERSION_1: Names = ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file "];

fn left(group: &Path, [limit, used, reclaimable]: Names) -> Option<u64> {
    let number = |name: &str| std::fs::read_to_string(group.join(name)).ok()?.trim().parse::<u64>().ok();
    // `max`, or a number close to 2^63: none.
    let limit = number(limit).filter(|limit| *limit < 1 << 62)?;
    let statistics = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let idle = statistics.lines().find_map(|l| l.strip_prefix(reclaimable)?.trim().parse().ok());
    Some(limit.saturating_sub(number(used)?.saturating_sub(idle.unwrap_or(0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn group(root: &Path, name: &str, files: &[(&str, &str)]) {
        fs::create_dir_all(root.join(name)).unwrap();
        for (file, text) in files {
            fs::write(root.join(name).join(file), text).unwrap();
        }
    }

    #[test]
    fn the_tightest_of_all_groups_counts() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        group(root, "a", &[("memory.max", "5000\n"), ("memory.current", "1000\n")]);
        group(root, "a/b", &[("memory.max", "max\n"), ("memory.current", "900\n")]);
        assert_eq!(least(root, "0::/a/b\n"), Some(4000));
        let statistics = ("memory.stat", "anon 7\ninactive_file 300\n");
        group(root, "a/b", &[("memory.max", "1500\n"), statistics]);
        assert_eq!(least(root, "0::/a/b\n"), Some(900));
        assert_eq!(least(root, "0::/\n"), None);
        // Seen from inside, the root is the group.
        group(root, ".", &[("memory.max", "800"), ("memory.current", "900")]);
        assert_eq!(least(root, "0::/not/there\n"), Some(0));
    }

    #[test]
    fn the_first_version_of_groups_is_read_too() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let none = "9223372036854771712";
        group(root, "memory", &[("memory.limit_in_bytes", none), ("memory.usage_in_bytes", "5")]);
        let groups = "12:cpu,cpuacct:/x\n7:memory:/x\nnonsense\n";
        assert_eq!(least(root, groups), None);
        let statistics = ("memory.stat", "total_inactive_file 50");
        let files = [("memory.limit_in_bytes", "600"), ("memory.usage_in_bytes", "150"), statistics];
        group(root, "memory/x", &files);
        assert_eq!(least(root, groups), Some(500));
    }
}
