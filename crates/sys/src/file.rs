//! Files that appear whole or not at all.
//!
//! The new content goes to a hidden file beside the target, is forced to the disk, and takes the target's name in
//! one step of the file system. A crash, a full disk or a kill at any moment leaves either the old file or the new
//! one. What a killed process leaves behind is removed by the next save to the same target.

use crate::machine::{host_name, process_is_alive};
use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// The end of the name of every temporary file that [`write_atomic`] makes.
pub const TEMPORARY_SUFFIX: &str = ".penombre-tmp";

/// A temporary file older than this is removed even if its process seems to live: the number was given to another
/// process, or the file came from another machine.
const STALE_AFTER: Duration = Duration::from_secs(24 * 3600);

/// Longest chain of symbolic links that is followed, as in Linux.
const MAX_LINKS: usize = 40;

/// Writes the file `path` through `write` so that it appears whole or not at all.
///
/// `write` gets a buffered writer. If it fails, or anything else does, the temporary file is removed and an
/// existing file stays as it was. An existing file's permission bits are kept; a symbolic link stays and the file it
/// points to is replaced; devices, pipes and other targets that are no regular files (`/dev/null`, `/dev/stdout`)
/// are appended to directly.
///
/// # Errors
///
/// The first error of `write` or of the file system, with the path in the message where the system's own message
/// lacks it; `PermissionDenied` if the existing file is write-protected, `IsADirectory` if it is a folder.
pub fn write_atomic(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    match resolve(path)? {
        Target::Direct(path) => {
            let mut out = BufWriter::new(OpenOptions::new().append(true).open(path)?);
            write(&mut out)?;
            out.flush()
        }
        Target::File { path, existing } => {
            remove_stale(&path);
            let temporary = Temporary::create(&path)?;
            if let Some(existing) = existing {
                fs::set_permissions(&temporary.path, existing.permissions())?;
            }
            let mut out = BufWriter::with_capacity(1 << 16, &temporary.file);
            write(&mut out)?;
            out.flush()?;
            drop(out);
            temporary.file.sync_all()?;
            temporary.rename_to(&path)
        }
    }
}

/// Checks, before any long work, that [`write_atomic`] to `path` can begin: the folder exists, the target is no
/// folder and not write-protected, and a temporary file can be made beside it (it is made and removed).
///
/// # Errors
///
/// What is in the way, naming the path.
pub fn check_writable(path: &Path) -> io::Result<()> {
    match resolve(path)? {
        Target::Direct(path) => OpenOptions::new().append(true).open(path).map(drop),
        Target::File { path, .. } => Temporary::create(&path).map(drop),
    }
}

/// Where the bytes for a path really go.
enum Target {
    /// A device, pipe or open descriptor: written in place.
    Direct(PathBuf),
    /// A regular file, existing or new, with all links followed.
    File { path: PathBuf, existing: Option<Metadata> },
}

fn resolve(path: &Path) -> io::Result<Target> {
    let fault = |kind, what: &str| Err(io::Error::new(kind, format!("{}: {what}", path.display())));
    if path.file_name().is_none() {
        return fault(io::ErrorKind::IsADirectory, "is no file name");
    }
    let existing = match fs::metadata(path) {
        Ok(metadata) => Some(metadata),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        Err(e) => return Err(with_path(path, &e)),
    };
    match &existing {
        Some(m) if m.is_dir() => return fault(io::ErrorKind::IsADirectory, "is a folder, not a file"),
        Some(m) if !m.is_file() => return Ok(Target::Direct(path.to_path_buf())),
        Some(m) if m.permissions().readonly() => {
            return fault(io::ErrorKind::PermissionDenied, "the existing file is write-protected");
        }
        _ => {}
    }
    let Some(file) = follow_links(path)? else { return Ok(Target::Direct(path.to_path_buf())) };
    let folder = folder_of(&file);
    match fs::metadata(folder) {
        Ok(m) if m.is_dir() => Ok(Target::File { path: file, existing }),
        Ok(_) => fault(io::ErrorKind::NotADirectory, "the folder it should be in is a file"),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let what = format!("the folder {} does not exist", folder.display());
            fault(io::ErrorKind::NotFound, &what)
        }
        Err(e) => Err(with_path(folder, &e)),
    }
}

/// The path behind all symbolic links, which need not exist; `None` if the way leads through an open descriptor
/// of a process (`/dev/stdout` redirected to a file), whose name must not be replaced under it.
fn follow_links(path: &Path) -> io::Result<Option<PathBuf>> {
    let mut file = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        if cfg!(unix) && (file.starts_with("/proc") || file.starts_with("/dev/fd")) {
            return Ok(None);
        }
        match fs::read_link(&file) {
            Ok(next) => file = folder_of(&file).join(next),
            Err(_) => return Ok(Some(file)),
        }
    }
    Err(io::Error::other(format!("{}: more than {MAX_LINKS} symbolic links", path.display())))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn with_path(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

/// A temporary file beside its target, removed when dropped unless it took the target's name.
struct Temporary {
    path: PathBuf,
    file: File,
    armed: bool,
}

impl Temporary {
    fn create(target: &Path) -> io::Result<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let names = TemporaryNames::of(target);
        loop {
            let count = COUNT.fetch_add(1, Ordering::Relaxed);
            let path = folder_of(target).join(names.name(std::process::id(), count));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Self { path, file, armed: true }),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(with_path(target, &e)),
            }
        }
    }

    fn rename_to(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target).map_err(|e| with_path(target, &e))?;
        self.armed = false;
        // The new name is there; forcing the folder to the disk makes it survive a power cut. Some file systems
        // cannot do that for folders, which is no reason to call a complete file a failure.
        if cfg!(unix)
            && let Ok(folder) = File::open(folder_of(target))
        {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if self.armed {
            // Nothing can be done about a failure here; the next save tries again.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// The names of temporary files of one target on this machine: `.NAME.HASH.HOST-PID-COUNT.penombre-tmp`.
struct TemporaryNames {
    prefix: String,
    host: String,
}

impl TemporaryNames {
    fn of(target: &Path) -> Self {
        let name = target.file_name().unwrap_or(OsStr::new("file"));
        // Long names are cut so that the temporary name fits the usual 255 bytes; the hash keeps them apart.
        let shown: String = name.to_string_lossy().chars().take(40).collect();
        let prefix = format!(".{shown}.{:016x}.", fnv1a(name.as_encoded_bytes()));
        Self { prefix, host: format!("{:08x}", fnv1a(&host_name()) as u32) }
    }

    fn name(&self, pid: u32, count: u32) -> String {
        format!("{}{}-{pid}-{count}{TEMPORARY_SUFFIX}", self.prefix, self.host)
    }

    /// What a file name says, if it is one of these: whether it is from this machine, and the process number.
    fn parse(&self, name: &str) -> Option<Origin> {
        let middle = name.strip_prefix(&self.prefix)?.strip_suffix(TEMPORARY_SUFFIX)?;
        let (host, rest) = middle.split_once('-')?;
        let (pid, _) = rest.split_once('-')?;
        Some(Origin { here: host == self.host, pid: pid.parse().ok()? })
    }
}

struct Origin {
    here: bool,
    pid: u32,
}

/// Removes what dead processes left of earlier saves to `target`. Best effort: a failure is no reason not to save.
fn remove_stale(target: &Path) {
    let names = TemporaryNames::of(target);
    let Ok(entries) = fs::read_dir(folder_of(target)) else { return };
    for entry in entries.flatten() {
        let Some(origin) = entry.file_name().to_str().and_then(|n| names.parse(n)) else { continue };
        let dead = origin.here && process_is_alive(origin.pid) == Some(false);
        let age = entry.metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
        if dead || age.is_some_and(|age| age > STALE_AFTER) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// 64-bit FNV-1a: keeps names apart, nothing more.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}
