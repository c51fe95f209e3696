//! Inputs that fuzzing has found worth keeping.

use std::path::Path;

/// The files of `fuzz/corpus/TARGET` with their names, by name.
///
/// # Panics
/// If the folder is missing or empty: a replay of nothing would prove nothing.
pub fn kept_corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let entries =
        std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("no corpus: {}: {e}", folder.display()));
    let read = |path: &Path| std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut files: Vec<(String, Vec<u8>)> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .map(|path| (path.file_name().unwrap_or_default().to_string_lossy().into_owned(), read(&path)))
        .collect();
    assert!(!files.is_empty(), "{}: an empty corpus", folder.display());
    files.sort();
    files
}
