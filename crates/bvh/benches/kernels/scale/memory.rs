//! Memory of this process, as Linux counts it.

use std::fs;

/// Forgets the peak so far, so that [`peak`] is that of what follows.
pub fn forget_peak() {
    // Where this fails the peak is that of all that was done, which is said too much, never too little.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// The most physical memory that was used at once, bytes; `None` where the system does not tell.
pub fn peak() -> Option<u64> {
    entry("VmHWM:")
}

fn entry(name: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes * 1024)
}
