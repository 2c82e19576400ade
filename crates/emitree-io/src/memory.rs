//! How much memory this process may still take.

use std::fs;
use std::path::Path;

/// The memory that new allocations could get now \[bytes\], if the system reports it; known on Linux only.
///
/// It is the smallest of what the machine has left, of what a limit on the address space (`ulimit -v`)
/// leaves, and of what the control groups of a container or a batch system leave.
pub fn available_memory_bytes() -> Option<u64> {
    let machine = kibibytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:");
    [machine, address_space_left(), control_groups_left()].into_iter().flatten().min()
}

/// The largest memory that this process has had \[bytes\], if the system reports it; known on Linux only.
pub fn peak_memory_bytes() -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// The number after `key` at the start of a line, which is in KiB, in bytes.
fn kibibytes(text: &str, key: &str) -> Option<u64> {
    number(text, key)?.checked_mul(1024)
}

/// The first word after `key` at the start of a line, as a number.
fn number(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.split_whitespace().next()?.parse().ok()
}

fn address_space_left() -> Option<u64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    // A word, and no number, if there is no limit.
    let limit = number(&limits, "Max address space ")?;
    let status = fs::read_to_string("/proc/self/status").ok()?;
    Some(limit.saturating_sub(kibibytes(&status, "VmSize:")?))
}

/// What the group of this process and the groups around it leave, in version 2 of control groups.
fn control_groups_left() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let group = groups.lines().find_map(|line| line.strip_prefix("0::"))?;
    let folder = Path::new("/sys/fs/cgroup").join(group.trim_start_matches('/'));
    folder
        .ancestors()
        .take_while(|folder| folder.starts_with("/sys/fs/cgroup"))
        .filter_map(left_in)
        .min()
}

fn left_in(group: &Path) -> Option<u64> {
    let text = |name| fs::read_to_string(group.join(name)).ok();
    let limit: u64 = text("memory.max")?.trim().parse().ok()?;
    let used: u64 = text("memory.current")?.trim().parse().ok()?;
    // Cached copies of files are freed when other memory is allocated.
    let of_files = number(&text("memory.stat")?, "inactive_file ").unwrap_or(0);
    Some(limit.saturating_sub(used.saturating_sub(of_files)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_by_their_keys() {
        let text = "MemTotal:  2048 kB\nMemAvailable:     1024 kB\nMax address space  unlimited\n";
        assert_eq!(kibibytes(text, "MemAvailable:"), Some(1 << 20));
        assert_eq!(kibibytes(text, "MemFree:"), None);
        assert_eq!(number(text, "Max address space "), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_system_reports_what_is_left() {
        let left = available_memory_bytes().unwrap();
        // Less than the machine has, and enough for this test to run.
        let machine = fs::read_to_string("/proc/meminfo").unwrap();
        assert!(left <= kibibytes(&machine, "MemTotal:").unwrap());
        assert!(left > 1 << 20, "{left}");
    }
}
