//! System calls, each behind a safe function with a fallback for systems that lack it.

use std::path::Path;
use std::time::Duration;

/// Free space, in bytes, for ordinary users on the file system that holds `path` or, where `path` does not
/// exist yet, its nearest existing ancestor. `None` where the system does not tell.
#[must_use]
pub fn available_space(path: &Path) -> Option<u64> {
    let absolute = std::path::absolute(path).ok()?;
    absolute.ancestors().find(|p| p.exists()).and_then(imp::available_space)
}

/// The largest resident memory this process has had so far, in bytes. `None` where the system does not tell.
#[must_use]
pub fn peak_rss() -> Option<u64> {
    imp::peak_rss()
}

/// Memory, in bytes, that this program may still take without driving the machine into swapping, or its container
/// beyond its limit. `None` where the system does not tell.
#[must_use]
pub fn available_memory() -> Option<u64> {
    let machine = std::fs::read_to_string("/proc/meminfo").ok().and_then(|table| meminfo(&table));
    machine.into_iter().chain(crate::cgroup::available_memory()).min()
}

/// The figure in Linux's table, which has one line `MemAvailable:   N kB`.
fn meminfo(table: &str) -> Option<u64> {
    let line = table.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    line.trim().trim_end_matches(" kB").parse::<u64>().ok()?.checked_mul(1024)
}

/// Processor time of this process so far: user and system, summed over all threads, ended ones too.
/// `None` where the system does not tell.
#[must_use]
pub fn process_cpu_time() -> Option<Duration> {
    imp::process_cpu_time()
}

/// Makes the calling thread yield to all threads of ordinary priority, for as long as it lives: it gets the processor's
/// time that they leave. True if that worked; false, and nothing changed, where the system has no such thing for single
/// threads (all but Linux).
pub fn lower_thread_priority() -> bool {
    imp::lower_thread_priority()
}

/// Lets the allocator give blocks of a megabyte or more back to the system as soon as they are freed, for as long as the
/// process lives. Otherwise glibc learns to keep ever larger ones, in one heap for each thread, and the peak of memory is
/// that of all phases of a program together. Does nothing with other allocators.
pub fn return_large_blocks() {
    imp::return_large_blocks();
}

/// Makes a write beyond the largest size that a file may have (`ulimit -f`) fail, for as long as the process lives, where
/// Unix would end the program and leave half a file. Programs that this one starts inherit it.
pub fn fail_beyond_file_size_limit() {
    imp::fail_beyond_file_size_limit();
}

/// Whether a process of this number runs on this machine. `None` where the system does not tell.
pub(crate) fn process_is_alive(pid: u32) -> Option<bool> {
    imp::process_is_alive(pid)
}

/// The machine's name as it calls itself, empty if unknown: tells apart process numbers of machines that share
/// a folder.
pub(crate) fn host_name() -> Vec<u8> {
    imp::host_name()
}

#[cfg(unix)]
mod imp {
    use std::ffi::CString;
    use std::mem::MaybeUninit;
    use std::os::unix::ffi::OsStrExt;
    use std::path::Path;
    use std::time::Duration;

    #[allow(clippy::unnecessary_cast, reason = "the field types differ between Unix systems")]
    pub fn available_space(path: &Path) -> Option<u64> {
        let path = CString::new(path.as_os_str().as_bytes()).ok()?;
        let mut stat = MaybeUninit::<libc::statvfs>::uninit();
        // SAFETY: `path` is a NUL-terminated string that outlives the call, and `stat` is writable memory of
        // the type statvfs fills.
        let status = unsafe { libc::statvfs(path.as_ptr(), stat.as_mut_ptr()) };
        if status != 0 {
            return None;
        }
        // SAFETY: statvfs returned 0, so it has filled the whole structure.
        let stat = unsafe { stat.assume_init() };
        (stat.f_bavail as u64).checked_mul(stat.f_frsize as u64)
    }

    fn usage() -> Option<libc::rusage> {
        let mut usage = MaybeUninit::<libc::rusage>::uninit();
        // SAFETY: RUSAGE_SELF is a valid selector and `usage` is writable memory of the type getrusage fills.
        let status = unsafe { libc::getrusage(libc::RUSAGE_SELF, usage.as_mut_ptr()) };
        // SAFETY: getrusage returned 0, so it has filled the whole structure.
        (status == 0).then(|| unsafe { usage.assume_init() })
    }

    /// Linux keeps the exact figure of this program in /proc; getrusage there also counts what the process was
    /// before it became this program.
    pub fn peak_rss() -> Option<u64> {
        if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
            let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
            let kib = line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<u64>().ok());
            if let Some(kib) = kib {
                return Some(kib * 1024);
            }
        }
        let unit = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
        u64::try_from(usage()?.ru_maxrss).ok()?.checked_mul(unit)
    }

    #[allow(clippy::unnecessary_cast, reason = "the field types differ between Unix systems")]
    pub fn process_cpu_time() -> Option<Duration> {
        let usage = usage()?;
        let duration = |t: libc::timeval| {
            Duration::from_secs(t.tv_sec.max(0) as u64) + Duration::from_micros(t.tv_usec.max(0) as u64)
        };
        Some(duration(usage.ru_utime) + duration(usage.ru_stime))
    }

    /// Linux counts niceness by thread, other Unix systems by process.
    #[cfg(any(target_os = "linux", target_os = "android"))]
    pub fn lower_thread_priority() -> bool {
        const LOWEST: libc::c_int = 19;
        // SAFETY: setpriority takes numbers only; 0 names the caller, which to Linux is the calling thread.
        let status = unsafe { libc::setpriority(libc::PRIO_PROCESS as _, 0, LOWEST) };
        status == 0
    }

    #[cfg(not(any(target_os = "linux", target_os = "android")))]
    pub fn lower_thread_priority() -> bool {
        false
    }

    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    pub fn return_large_blocks() {
        // SAFETY: mallopt takes numbers only. That it may refuse does not matter.
        let _ = unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 20) };
    }

    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    pub fn return_large_blocks() {}

    pub fn fail_beyond_file_size_limit() {
        // SAFETY: SIG_IGN is no handler that could run, and SIGXFSZ is a signal that may be ignored.
        let _ = unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
    }

    pub fn process_is_alive(pid: u32) -> Option<bool> {
        let pid = libc::pid_t::try_from(pid).ok().filter(|p| *p > 0)?;
        // SAFETY: kill with signal 0 sends nothing, it only checks that the process exists.
        let status = unsafe { libc::kill(pid, 0) };
        // A process of another user exists too, though we may not signal it.
        Some(status == 0 || std::io::Error::last_os_error().raw_os_error() == Some(libc::EPERM))
    }

    pub fn host_name() -> Vec<u8> {
        let mut name = [0u8; 256];
        // SAFETY: the pointer and length describe a writable buffer; gethostname writes at most that many bytes.
        let status = unsafe { libc::gethostname(name.as_mut_ptr().cast(), name.len()) };
        if status != 0 {
            return Vec::new();
        }
        name.iter().copied().take_while(|b| *b != 0).collect()
    }
}

#[cfg(not(unix))]
mod imp {
    use std::path::Path;
    use std::time::Duration;

    pub fn available_space(_path: &Path) -> Option<u64> {
        None
    }

    pub fn peak_rss() -> Option<u64> {
        None
    }

    pub fn process_cpu_time() -> Option<Duration> {
        None
    }

    pub fn lower_thread_priority() -> bool {
        false
    }

    pub fn return_large_blocks() {}

    pub fn fail_beyond_file_size_limit() {}

    pub fn process_is_alive(_pid: u32) -> Option<bool> {
        None
    }

    pub fn host_name() -> Vec<u8> {
        std::env::var("COMPUTERNAME").unwrap_or_default().into_bytes()
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn available_memory_is_read_from_the_systems_table() {
        assert_eq!(meminfo("MemTotal: 9 kB\nMemAvailable:    2048 kB\n"), Some(2 << 20));
        assert_eq!(meminfo("MemTotal: 9 kB\nMemAvailable: many kB\n"), None);
        if cfg!(target_os = "linux") {
            assert!(available_memory().unwrap() > 1 << 20);
        }
    }

    #[test]
    fn space_is_told_for_a_path_that_does_not_exist_yet() {
        let folder = tempfile::tempdir().unwrap();
        let here = available_space(folder.path()).expect("statvfs works on Unix");
        let below = available_space(&folder.path().join("not/yet/there.png")).unwrap();
        assert!(here > 0);
        // Other programs may write between the two calls: equal to within a quarter.
        assert!(below > here / 4 * 3 && below / 4 * 3 < here, "{below} against {here}");
        assert_eq!(imp::available_space(Path::new("/no/such/folder")), None);
    }

    #[test]
    fn peak_memory_grows_with_what_is_touched() {
        let before = peak_rss().unwrap();
        assert!((100 << 10..1u64 << 40).contains(&before), "{before}");
        let block = vec![1u8; (before as usize) + (64 << 20)];
        assert_eq!(
            block.iter().step_by(4096).map(|b| usize::from(*b)).sum::<usize>(),
            block.len().div_ceil(4096)
        );
        assert!(peak_rss().unwrap() >= block.len() as u64);
    }

    #[test]
    fn processor_time_grows_with_work_in_another_thread() {
        let before = process_cpu_time().unwrap();
        let spin = std::thread::spawn(|| {
            let start = Instant::now();
            let mut x = 1u64;
            while start.elapsed() < Duration::from_millis(300) {
                x = std::hint::black_box(x.wrapping_mul(3));
            }
            x
        });
        spin.join().unwrap();
        let used = process_cpu_time().unwrap() - before;
        assert!(used > Duration::from_millis(20), "{used:?} for 300 ms of spinning");
    }

    /// Niceness of the calling thread: field 19 of its line in /proc, where field 2 is a name in parentheses.
    #[cfg(target_os = "linux")]
    fn niceness() -> Option<i32> {
        let line = std::fs::read_to_string("/proc/thread-self/stat").ok()?;
        line.rsplit_once(") ")?.1.split(' ').nth(16)?.parse().ok()
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_priority_of_one_thread_alone_is_lowered() {
        let before = niceness();
        let lowered = std::thread::spawn(|| (lower_thread_priority(), niceness(), lower_thread_priority()));
        assert_eq!(lowered.join().unwrap(), (true, Some(19), true));
        assert!(before.is_some() && niceness() == before);
    }

    #[test]
    fn dead_and_living_processes_are_told_apart() {
        assert_eq!(process_is_alive(std::process::id()), Some(true));
        assert_eq!(process_is_alive(1), Some(true));
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let pid = child.id();
        child.wait().unwrap();
        assert_eq!(process_is_alive(pid), Some(false));
        assert_eq!(process_is_alive(0), None, "0 would address the whole process group");
        assert_eq!(process_is_alive(u32::MAX), None);
    }

    #[test]
    fn host_name_is_text_without_nul() {
        let name = host_name();
        assert!(!name.is_empty() && !name.contains(&0));
    }
}
