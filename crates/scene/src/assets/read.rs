//! Files into memory.

use std::fs::File;
use std::io;
use std::path::Path;

/// A thread reads at least so many bytes: most of the time goes into giving the memory to the program.
const LEAST: usize = 4 << 20;
/// Most threads that read one file.
const MOST_THREADS: usize = 8;

/// All bytes of a file; those of a large one are read on several threads.
///
/// # Errors
/// As [`std::fs::read`]; also where there is no memory for so much.
pub(super) fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let length = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let threads = threads.min(MOST_THREADS).min(length / LEAST);
    if threads < 2 || cfg!(not(unix)) { std::fs::read(path) } else { in_parts(&file, length, threads) }
}

/// Reads so many bytes from the beginning of a file. Fewer are no fault: another program may have cut it meanwhile.
#[cfg(unix)]
fn in_parts(file: &File, length: usize, threads: usize) -> io::Result<Vec<u8>> {
    // Asked for first: where there is no room for so much, that is an error and not the end of the program.
    Vec::<u8>::new().try_reserve_exact(length)?;
    let mut bytes = vec![0; length];
    let size = length.div_ceil(threads);
    let found: io::Result<Vec<usize>> = std::thread::scope(|scope| {
        let parts = bytes.chunks_mut(size).enumerate();
        let threads: Vec<_> =
            parts.map(|(i, part)| scope.spawn(move || fill(file, i * size, part))).collect();
        threads.into_iter().map(|t| t.join().unwrap_or_else(|_| Err(io::ErrorKind::Other.into()))).collect()
    });
    // What follows the first part that is not full is not there.
    let found = found?;
    let full = found.iter().take_while(|n| **n == size).count();
    bytes.truncate(full * size + found.get(full).unwrap_or(&0));
    Ok(bytes)
}

#[cfg(not(unix))]
fn in_parts(_: &File, _: usize, _: usize) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Fills a part with what stands at an offset; returns how much there was.
#[cfg(unix)]
fn fill(file: &File, offset: usize, part: &mut [u8]) -> io::Result<usize> {
    use std::os::unix::fs::FileExt;
    let mut done = 0;
    while done < part.len() {
        match file.read_at(&mut part[done..], (offset + done) as u64) {
            Ok(0) => break,
            Ok(n) => done += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for length in [0, 1, LEAST, 2 * LEAST, 3 * LEAST + 12_345] {
            let bytes: Vec<u8> = (0..length).map(|i| (i * 7 % 251) as u8).collect();
            std::fs::write(&path, &bytes).unwrap();
            assert!(read_file(&path).unwrap() == bytes, "{length}");
        }
        assert!(read_file(&folder.path().join("b")).is_err());
        assert!(read_file(folder.path()).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn parts_fit_together_and_a_file_may_be_shorter_than_was_thought() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let bytes: Vec<u8> = (0..1000).map(|i| (i % 251) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        let file = File::open(&path).unwrap();
        for threads in 1..9 {
            for length in [1, 7, 1000, 1001, 1200, 5000] {
                let found = in_parts(&file, length, threads).unwrap();
                assert!(found == bytes[..length.min(1000)], "{length} bytes, {threads} threads");
            }
        }
    }
}
