//! How much memory there is to work with: what the machine has, and what the process's group of processes may have
//! (Linux control groups, versions 1 and 2).

use std::{
    fs,
    path::{Path, PathBuf},
};

/// Bytes of memory that this process may use; 4 GiB where the system does not tell.
pub fn available() -> u64 {
    let machine = proc_kib("/proc/meminfo", "MemTotal:").unwrap_or(4 << 30);
    limit(Path::new("/proc/self"), Path::new("/")).map_or(machine, |limit| limit.min(machine))
}

/// A line `NAME 123 kB` of a file below /proc, in bytes.
pub fn proc_kib(file: &str, name: &str) -> Option<u64> {
    let text = fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(name))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? << 10)
}

/// The lowest limit of the process's memory groups and of all groups above them. `root` is `/`, but in tests.
fn limit(process: &Path, root: &Path) -> Option<u64> {
    let groups = fs::read_to_string(process.join("cgroup")).ok()?;
    let mounts = fs::read_to_string(process.join("mountinfo")).ok()?;
    let mut lowest: Option<u64> = None;
    // `hierarchy:controllers:path`; version 2 has no controllers.
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let (kind, file) = match controllers {
            "" => ("cgroup2", "memory.max"),
            c if c.split(',').any(|c| c == "memory") => ("cgroup", "memory.limit_in_bytes"),
            _ => continue,
        };
        let found = mounts.lines().filter_map(|mount| folder(mount, kind, path));
        for (mount, group) in found {
            // A limit of any group above holds too.
            let below = group.ancestors().filter_map(|at| number(&root.join(&mount).join(at).join(file)));
            lowest = below.chain(lowest).min();
        }
    }
    lowest
}

/// The mount point (below `/`) and the group's folder below it, if a line of `mountinfo` is a mount of the group's tree.
fn folder(mount: &str, kind: &str, group: &str) -> Option<(PathBuf, PathBuf)> {
    // `id parent device root point options … - type source super-options`
    let (left, right) = mount.split_once(" - ")?;
    let mut left = left.split(' ').skip(3);
    let (tree, point) = (left.next()?, left.next()?);
    let mut right = right.split(' ');
    if right.next()? != kind || kind == "cgroup" && !right.nth(1)?.split(',').any(|c| c == "memory") {
        return None;
    }
    // In a container the mount shows a part of the tree; a group outside it counts from the mount's top.
    let inside = Path::new(group).strip_prefix(tree).unwrap_or(Path::new(""));
    Some((Path::new(point).strip_prefix("/").ok()?.to_owned(), inside.to_owned()))
}

/// A limit that is a number; version 2 writes `max`, version 1 almost 2⁶³, where there is none.
fn number(file: &Path) -> Option<u64> {
    let value: u64 = fs::read_to_string(file).ok()?.trim().parse().ok()?;
    (value > 0 && value < 1 << 62).then_some(value)
}

/// Highest resident memory of this process so far, in bytes.
pub fn peak() -> Option<u64> {
    proc_kib("/proc/self/status", "VmHWM:")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes files below a root and reads the limit of the process in `proc/`.
    fn check(files: &[(&str, &str)], expect: Option<u64>) {
        let dir = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = dir.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        assert_eq!(limit(&dir.path().join("proc"), dir.path()), expect, "{files:?}");
    }

    const V2: &str = "30 24 0:26 / /sys/fs/cgroup rw,nosuid - cgroup2 cgroup2 rw\n";
    const V1: &str = "36 32 0:31 / /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu\n\
                      37 32 0:32 /docker/abc /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n";

    #[test]
    fn the_nearest_limit_holds() {
        check(&[], None);
        check(&[("proc/cgroup", "0::/a/b\n"), ("proc/mountinfo", V2)], None);
        let v2 = [("proc/cgroup", "0::/a/b\n"), ("proc/mountinfo", V2)];
        let with = |more: &[(&'static str, &'static str)]| v2.iter().chain(more).copied().collect::<Vec<_>>();
        check(&with(&[("sys/fs/cgroup/a/b/memory.max", "1000\n")]), Some(1000));
        check(
            &with(&[("sys/fs/cgroup/a/b/memory.max", "max\n"), ("sys/fs/cgroup/a/memory.max", "2000\n")]),
            Some(2000),
        );
        let both = [("sys/fs/cgroup/a/b/memory.max", "3000"), ("sys/fs/cgroup/a/memory.max", "2000")];
        check(&with(&both), Some(2000));
        check(&with(&[("sys/fs/cgroup/a/b/memory.max", "max")]), None);
    }

    #[test]
    fn version_1_and_containers() {
        let groups = "5:cpu,cpuacct:/x\n4:memory:/docker/abc/inner\n";
        let v1 = [("proc/cgroup", groups), ("proc/mountinfo", V1)];
        let with = |more: &[(&'static str, &'static str)]| v1.iter().chain(more).copied().collect::<Vec<_>>();
        let (own, above) =
            ("sys/fs/cgroup/memory/inner/memory.limit_in_bytes", "sys/fs/cgroup/memory/memory.limit_in_bytes");
        check(&with(&[(own, "9223372036854771712"), (above, "4096")]), Some(4096));
        check(&with(&[(own, "9223372036854771712")]), None);
        check(&with(&[(own, "100"), (above, "4096")]), Some(100));
    }
}
