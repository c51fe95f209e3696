//! Files of the same bytes under different names.

use super::pool;
use std::collections::HashMap;
use std::hash::Hash;
use std::path::Path;

/// A file as far as it is known before it is read.
pub(super) struct Candidate<'a, K> {
    pub path: &'a Path,
    /// Length, bytes.
    pub length: u64,
    /// Files are alike only if this is the same.
    pub kind: K,
}

/// For each file the first that is alike: itself, or another one with the same bytes and kind. Only files that share
/// their length are read for that.
pub(super) fn first_alike<K: Hash + Eq + Sync>(files: &[Candidate<'_, K>]) -> Vec<usize> {
    let mut by_length: HashMap<(u64, &K), Vec<usize>> = HashMap::new();
    for (i, file) in files.iter().enumerate() {
        by_length.entry((file.length, &file.kind)).or_default().push(i);
    }
    let mut asked: Vec<usize> = by_length.into_values().filter(|group| group.len() > 1).flatten().collect();
    asked.sort_unstable();
    let weights: Vec<u64> = asked.iter().map(|i| files[*i].length).collect();
    let hashes = pool::each(&weights, |i| hash(files[asked[i]].path));
    let mut first: Vec<usize> = (0..files.len()).collect();
    let mut known = HashMap::new();
    for (i, hash) in asked.into_iter().zip(hashes) {
        if let Some(hash) = hash {
            first[i] = *known.entry((hash, &files[i].kind)).or_insert(i);
        }
    }
    first
}

/// The hash of a file's bytes, if it can be read.
fn hash(path: &Path) -> Option<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    std::io::copy(&mut std::fs::File::open(path).ok()?, &mut hasher).ok()?;
    Some(hasher.finalize())
}
