//! Mesh files that were packed with gzip \[RFC1952\].

use flate2::bufread::GzDecoder;
use std::fmt;
use std::io::{Cursor, Read};
use std::path::Path;

/// An unpacked file may have this many bytes whatever the packed one has …
const ALWAYS: u64 = 16 << 20;
/// … and this many times those of the packed one. Meshes shrink to a half, texts to a fifth; only files made for it,
/// or of almost nothing but zeros, to less than a thirtieth.
const MOST_RATIO: u64 = 32;

/// Why a file cannot be unpacked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GzipFault {
    /// The packed data end too early, at this byte.
    Truncated(u64),
    /// The packed data are damaged, at about this byte.
    Damaged(u64),
    /// What follows a member, from this byte on, is none.
    Trailing(u64),
    /// More bytes than the limit come out.
    TooLarge {
        /// The most bytes that may come out.
        limit: u64,
    },
}

impl fmt::Display for GzipFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated(at) => write!(f, "byte {at}: found the end of the gzip data, expected more"),
            Self::Damaged(at) => write!(f, "about byte {at}: found damaged gzip data, expected sound ones"),
            Self::Trailing(at) => {
                write!(
                    f,
                    "byte {at}: found bytes that are no gzip data behind those that are, expected the end of the file"
                )
            }
            Self::TooLarge { limit } => {
                write!(f, "byte 0: found gzip data that unpack to more than {limit} bytes, expected fewer")
            }
        }
    }
}

impl GzipFault {
    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Truncated(_) => "the file was cut: copy it anew",
            Self::Damaged(_) => "copy or pack the file anew",
            Self::Trailing(_) => "copy or pack the file anew, or cut off what follows the data",
            Self::TooLarge { .. } => "if the file is what it should be, unpack it with gunzip",
        }
    }
}

/// True if the bytes begin as gzip files do.
pub fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x1f\x8b")
}

/// The path without the ending `.gz`, in upper or lower case, if it has that.
pub fn without_gz(path: &Path) -> &Path {
    match (path.extension(), path.file_stem()) {
        (Some(ending), Some(stem)) if ending.eq_ignore_ascii_case("gz") => Path::new(stem),
        _ => path,
    }
}

/// Most bytes that may come out of a packed file of that length.
pub(super) fn limit(packed: u64) -> u64 {
    ALWAYS.max(MOST_RATIO.saturating_mul(packed))
}

/// Unpacks all members of a gzip file; zeros may follow them, as on tapes. No more than 16 MiB, or 32 times the packed
/// bytes, come out.
///
/// # Errors
/// If the data are cut or damaged, if something else follows them, or if they would unpack to more.
pub fn unpack(packed: &[u8]) -> Result<Vec<u8>, GzipFault> {
    let limit = limit(packed.len() as u64);
    let mut bytes = Vec::with_capacity(packed.len());
    let mut start = 0;
    while start == 0 || packed[start..].iter().any(|b| *b != 0) {
        if start > 0 && !is_packed(&packed[start..]) {
            return Err(GzipFault::Trailing(start as u64));
        }
        let mut decoder = GzDecoder::new(Cursor::new(&packed[start..]));
        let room = limit + 1 - bytes.len() as u64;
        let result = decoder.by_ref().take(room).read_to_end(&mut bytes);
        let at = start as u64 + decoder.get_ref().position();
        match result {
            Ok(_) if bytes.len() as u64 > limit => return Err(GzipFault::TooLarge { limit }),
            Ok(_) => start = at as usize,
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => return Err(GzipFault::Truncated(at)),
            Err(_) => return Err(GzipFault::Damaged(at)),
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).expect("packed");
        encoder.finish().expect("packed")
    }

    #[test]
    fn members_are_joined() {
        let two = [packed(b"ply\n"), packed(b"format")].concat();
        assert!(is_packed(&two));
        assert_eq!(unpack(&two), Ok(b"ply\nformat".to_vec()));
    }

    #[test]
    fn zeros_may_follow_and_nothing_else() {
        let whole = packed(b"OFF\n");
        for zeros in [1, 9, 10, 100, 5000] {
            assert_eq!(unpack(&[whole.clone(), vec![0; zeros]].concat()), Ok(b"OFF\n".to_vec()), "{zeros}");
        }
        let two = [whole.clone(), whole.clone()].concat();
        for garbage in [&b"x"[..], b"garbage, garbage, garbage", b"\0\0x", b"\x1f", b"\x1fx"] {
            for members in [&whole, &two] {
                let fault = unpack(&[members, garbage].concat());
                assert_eq!(fault, Err(GzipFault::Trailing(members.len() as u64)), "{garbage:?}");
            }
        }
        // The beginning of a member is one that was cut.
        let fault = unpack(&[&whole[..], &whole[..8]].concat());
        assert_eq!(fault, Err(GzipFault::Truncated(whole.len() as u64 + 8)));
    }

    #[test]
    fn many_small_members_take_little_time() {
        let begin = std::time::Instant::now();
        let many = packed(b"").repeat(50_000);
        assert_eq!(unpack(&many), Ok(Vec::new()));
        assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
    }

    #[test]
    fn every_cut_and_every_changed_byte_is_seen() {
        let text: Vec<u8> =
            (0..2000u32).flat_map(|i| format!("v {} 0 0\n", i * i % 97).into_bytes()).collect();
        let whole = packed(&text);
        for length in 0..whole.len() {
            match unpack(&whole[..length]) {
                Err(GzipFault::Truncated(at)) => assert!(at <= length as u64),
                // What is left of the header may be no header.
                other => assert!(length < 10, "{length}: {other:?}"),
            }
        }
        // Bytes 3 to 9 are flags, a time and a system, which change nothing that comes out.
        for at in (0..3).chain(10..whole.len()) {
            let mut changed = whole.clone();
            changed[at] ^= 0x55;
            match unpack(&changed) {
                Err(GzipFault::Damaged(place) | GzipFault::Truncated(place)) => {
                    assert!(place <= whole.len() as u64);
                }
                other => panic!("{at}: {}", other.is_ok()),
            }
        }
    }

    #[test]
    fn bombs_are_refused() {
        let zeros = vec![0; 1 << 20];
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        for _ in 0..20 {
            encoder.write_all(&zeros).expect("packed");
        }
        let bomb = encoder.finish().expect("packed");
        assert_eq!(unpack(&bomb), Err(GzipFault::TooLarge { limit: ALWAYS }));
    }

    #[test]
    fn the_ending_is_found_in_any_case() {
        for (name, inner) in
            [("a.ply.gz", "a.ply"), ("d/b.OBJ.GZ", "b.OBJ"), ("c.off", "c.off"), (".gz", ".gz")]
        {
            assert_eq!(without_gz(Path::new(name)), Path::new(inner));
        }
    }
}
