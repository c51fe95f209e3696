//! Files of the same bytes under different names.

use super::pool;
use std::collections::HashMap;
use std::fs::File;
use std::hash::Hash;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes at each of three places of a file that tell it from most others.
const SAMPLE: u64 = 4096;

/// A file as far as it is known before it is read.
pub(super) struct Candidate<'a, K> {
    pub path: &'a Path,
    /// Length, bytes.
    pub length: u64,
    /// Files are alike only if this is the same.
    pub kind: K,
}

/// For each file the first that is alike: itself, or another one with the same bytes and kind. Only files that share
/// their length and some bytes of their beginning, middle and end are read for that.
pub(super) fn first_alike<K: Hash + Eq + Sync>(files: &[Candidate<'_, K>]) -> Vec<usize> {
    let all: Vec<usize> = (0..files.len()).collect();
    let same_length = shared(&all, |i| (files[i].length, &files[i].kind));
    let samples = hashes(files, &same_length, |_| 3 * SAMPLE, sample);
    let asked = shared(&same_length, |i| (files[i].length, &files[i].kind, samples.get(&i)));
    let wholes = hashes(files, &asked, |file| file.length, whole);
    let mut known = HashMap::new();
    let first = |i| match wholes.get(&i) {
        Some(hash) => *known.entry((hash, &files[i].kind)).or_insert(i),
        None => i,
    };
    all.iter().copied().map(first).collect()
}

/// Those files of which there is another one with the same key, in their order.
fn shared<K: Hash + Eq>(files: &[usize], key: impl Fn(usize) -> K) -> Vec<usize> {
    let mut count: HashMap<K, usize> = HashMap::new();
    for i in files {
        *count.entry(key(*i)).or_default() += 1;
    }
    files.iter().copied().filter(|i| count[&key(*i)] > 1).collect()
}

/// Hashes of those files that can be read. `bytes`: how much of a file is read.
fn hashes<K: Sync>(
    files: &[Candidate<'_, K>],
    wanted: &[usize],
    bytes: impl Fn(&Candidate<'_, K>) -> u64,
    hash: impl Fn(&Candidate<'_, K>) -> io::Result<blake3::Hash> + Sync,
) -> HashMap<usize, blake3::Hash> {
    let weights: Vec<u64> = wanted.iter().map(|i| bytes(&files[*i])).collect();
    let found = pool::each(&weights, |i| hash(&files[wanted[i]]).ok());
    wanted.iter().zip(found).filter_map(|(i, hash)| Some((*i, hash?))).collect()
}

/// The hash of the first, middle and last bytes of a file.
fn sample<K>(file: &Candidate<'_, K>) -> io::Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    let mut source = File::open(file.path)?;
    let last = file.length.saturating_sub(SAMPLE);
    for at in [0, last / 2, last] {
        source.seek(SeekFrom::Start(at))?;
        io::copy(&mut Read::by_ref(&mut source).take(SAMPLE), &mut hasher)?;
    }
    Ok(hasher.finalize())
}

/// The hash of all bytes of a file.
fn whole<K>(file: &Candidate<'_, K>) -> io::Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    io::copy(&mut File::open(file.path)?, &mut hasher)?;
    Ok(hasher.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_the_same_bytes_and_kind_are_alike() {
        let folder = tempfile::tempdir().unwrap();
        let bytes: Vec<u8> = (0..40_000).map(|i| (i % 253) as u8).collect();
        let changed = |at: usize| {
            let mut changed = bytes.clone();
            changed[at] ^= 1;
            changed
        };
        let contents = [
            (bytes.clone(), 'm'),
            // Not among the bytes that are looked at first.
            (changed(6000), 'm'),
            (bytes.clone(), 'm'),
            (changed(39_999), 'm'),
            (bytes.clone(), 'i'),
            (bytes[1..].to_vec(), 'm'),
            (changed(6000), 'm'),
            (bytes.clone(), 'm'),
        ];
        let name = |i: usize| folder.path().join(i.to_string());
        for (i, (content, _)) in contents.iter().enumerate() {
            std::fs::write(name(i), content).unwrap();
        }
        let paths: Vec<_> = (0..=contents.len()).map(name).collect();
        let missing = (bytes.clone(), 'm');
        let all = contents.iter().chain([&missing]);
        let files: Vec<_> = all
            .zip(&paths)
            .map(|((content, kind), path)| Candidate { path, length: content.len() as u64, kind })
            .collect();
        assert_eq!(first_alike(&files), [0, 1, 0, 3, 4, 5, 1, 0, 8]);
    }
}
