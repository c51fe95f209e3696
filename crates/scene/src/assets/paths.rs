//! Which files a scene may read.
//!
//! Only files below the folder of the scene file, or below a folder that `--asset-root` names. A scene from a
//! stranger cannot make the program read anything else.

use crate::printable::harmless;
use crate::suggest::nearest_file;
use std::path::{Component, Path, PathBuf};

/// Why a file is not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PathFault {
    /// It lies, perhaps by way of a symbolic link, outside the allowed folders, or is named by an absolute path.
    #[error("found `{name}`, which lies outside, expected a file below the scene's folder")]
    Outside {
        /// The name as the scene says it.
        name: String,
        /// The folder that would have to be allowed, if it is known.
        folder: Option<PathBuf>,
    },
    /// It is an address and not a file.
    #[error("found the address `{name}`, expected a file below the scene's folder")]
    Address {
        /// The name as the scene says it.
        name: String,
    },
    /// There is no such file.
    #[error("there is no file `{name}`")]
    Missing {
        /// The name as the scene says it.
        name: String,
        /// Where it was looked for.
        path: PathBuf,
    },
    /// It is a folder, a device or a pipe.
    #[error("`{name}`: found {found}, expected a file")]
    NotAFile {
        /// The name as the scene says it.
        name: String,
        /// What it is.
        found: &'static str,
    },
    /// No file can have this name.
    #[error("found `{name}`, expected the name of a file: {reason}")]
    Invalid {
        /// The name as the scene says it, without control characters.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The system does not let us look.
    #[error("`{name}` cannot be read: {reason}")]
    Unreadable {
        /// The name as the scene says it.
        name: String,
        /// What the system says.
        reason: String,
    },
}

impl PathFault {
    /// A stable name of the kind of fault, for diagnostics.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Outside { .. } | Self::Address { .. } => "asset::outside",
            Self::Missing { .. } => "asset::missing",
            Self::NotAFile { .. } => "asset::not-a-file",
            Self::Invalid { .. } => "asset::name",
            Self::Unreadable { .. } => "asset::unreadable",
        }
    }

    /// True if the file is not read because of where it lies: an error even where a missing file is none.
    pub fn is_refusal(&self) -> bool {
        matches!(self, Self::Outside { .. } | Self::Address { .. })
    }

    /// What to do about it; never empty.
    pub fn help(&self) -> String {
        let text = match self {
            Self::Outside { folder: Some(folder), .. } => {
                let folder = folder.display();
                return format!("copy it there or, if you trust the scene, add `--asset-root {folder}`");
            }
            Self::Outside { folder: None, .. } => {
                "copy it there, or to a folder that `--asset-root DIR` allows"
            }
            Self::Address { .. } => {
                "nothing is fetched: save the file there, or in a folder that `--asset-root DIR` allows"
            }
            Self::Missing { path, .. } => {
                let near =
                    nearest_file(path).map_or_else(String::new, |near| format!("did you mean `{near}`? "));
                return format!("{near}looked for {}", path.display());
            }
            Self::NotAFile { .. } => "give the name of a file: devices, pipes and whole folders are not read",
            Self::Invalid { .. } => {
                "give a name such as \"meshes/bunny.off\", relative to the file that says it"
            }
            Self::Unreadable { .. } => UNREADABLE_HELP,
        };
        text.to_owned()
    }
}

/// What to do where the system does not let a file be read.
pub const UNREADABLE_HELP: &str = "check that you may read the file and its folder";

/// Longest name of a file that is looked for, bytes: no system has longer ones.
const LONGEST_NAME: usize = 4096;

/// Finds the file that a scene names.
///
/// `root_folder`: the folder of the scene file, below which everything may be read. `asset_roots`: further such
/// folders; those that do not exist allow nothing. `base_folder`: the folder to which `name` is relative: that of
/// the file that says it. Returns the file's canonical path, free of symbolic links.
///
/// # Errors
/// See [`PathFault`]. Nothing outside the allowed folders is looked at before it is refused; whether a file exists
/// there is not told.
pub fn resolve(
    root_folder: &Path,
    asset_roots: &[PathBuf],
    base_folder: &Path,
    name: &str,
) -> Result<PathBuf, PathFault> {
    check_name(name)?;
    let shown = name.to_owned();
    let base = canonical_folder(base_folder, name)?;
    let root = canonical_folder(root_folder, name)?;
    let extra: Vec<PathBuf> = asset_roots.iter().filter_map(|r| r.canonicalize().ok()).collect();
    let path = lexically_normal(&base.join(name));
    // An absolute name is a matter of the machine that it was written on: only an explicit root allows it.
    let own = if is_absolute(name) { None } else { Some(&root) };
    let allowed = |p: &Path| own.into_iter().chain(&extra).any(|r| p.starts_with(r));
    let outside =
        |p: &Path| PathFault::Outside { name: shown.clone(), folder: p.parent().map(Path::to_owned) };
    if !allowed(&path) {
        return Err(outside(&path));
    }
    let real = path.canonicalize().map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory => {
            // The folder may be a link that leads out: what is there is not told.
            match path.ancestors().skip(1).find_map(|folder| folder.canonicalize().ok()) {
                Some(folder) if !allowed(&folder) => outside(&path),
                _ => PathFault::Missing { name: shown.clone(), path: path.clone() },
            }
        }
        _ => PathFault::Unreadable { name: shown.clone(), reason: e.to_string() },
    })?;
    if !allowed(&real) {
        return Err(outside(&real));
    }
    check_regular(&real, name)?;
    Ok(real)
}

/// Refuses what is not a regular file: folders, devices, pipes.
///
/// # Errors
/// [`PathFault::NotAFile`], [`PathFault::Missing`] or [`PathFault::Unreadable`], with `name` as the file's name.
pub fn check_regular(path: &Path, name: &str) -> Result<(), PathFault> {
    let name = name.to_owned();
    match path.metadata() {
        Ok(m) if m.is_file() => Ok(()),
        Ok(m) if m.is_dir() => Err(PathFault::NotAFile { name, found: "a folder" }),
        Ok(_) => Err(PathFault::NotAFile { name, found: "a device or a pipe" }),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            Err(PathFault::Missing { name, path: path.to_owned() })
        }
        Err(e) => Err(PathFault::Unreadable { name, reason: e.to_string() }),
    }
}

/// Refuses addresses, absolute network names and names that no file has.
fn check_name(name: &str) -> Result<(), PathFault> {
    if name.is_empty() {
        return Err(PathFault::Invalid { name: String::new(), reason: "it is empty" });
    }
    if name.len() > LONGEST_NAME {
        let shown = format!("{}…", name.chars().take(40).collect::<String>());
        return Err(PathFault::Invalid { name: shown, reason: "it is longer than 4096 bytes" });
    }
    if name.chars().any(char::is_control) {
        let shown = harmless(name).into_owned();
        return Err(PathFault::Invalid { name: shown, reason: "it has control characters" });
    }
    let scheme = name.split_once(':').map_or("", |(scheme, _)| scheme).to_ascii_lowercase();
    let is_scheme = ["file", "http", "https", "ftp", "data"].contains(&scheme.as_str());
    if is_scheme || name.contains("://") {
        return Err(PathFault::Address { name: name.chars().take(200).collect() });
    }
    // Drives and network shares of Windows, on every system alike. Elsewhere `a:b.obj` is a name as any other.
    let drive = match name.as_bytes() {
        [letter, b':', rest @ ..] => letter.is_ascii_alphabetic() && matches!(rest, [] | [b'/' | b'\\', ..]),
        _ => false,
    };
    if (drive && !cfg!(windows)) || name.starts_with("\\\\") || name.starts_with("//") {
        return Err(PathFault::Outside { name: name.to_owned(), folder: None });
    }
    Ok(())
}

/// True for names that begin at the root of the file system or of a drive.
fn is_absolute(name: &str) -> bool {
    let path = Path::new(name);
    path.is_absolute() || path.has_root() || matches!(path.components().next(), Some(Component::Prefix(_)))
}

fn canonical_folder(folder: &Path, name: &str) -> Result<PathBuf, PathFault> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let unreadable = |e: std::io::Error| PathFault::Unreadable {
        name: name.to_owned(),
        reason: format!("its folder {}: {e}", folder.display()),
    };
    folder.canonicalize().map_err(unreadable)
}

/// The path without `.` and `..`, without looking at the disk.
fn lexically_normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => _ = normal.pop(),
            part => normal.push(part),
        }
    }
    normal
}

#[cfg(test)]
mod tests;
