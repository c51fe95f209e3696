//! Texts whose characters take two or four bytes: no reader knows them, and all say so.

use super::faults::Faults;
use super::lexer::Token;

/// Bytes at the beginning of a file that tell its encoding.
const HEAD: usize = 64;

/// Byte order marks and the encodings that they tell, the longer ones first.
const MARKS: [(&[u8], &str); 4] = [
    (b"\xff\xfe\0\0", "UTF-32"),
    (b"\0\0\xfe\xff", "UTF-32"),
    (b"\xff\xfe", "UTF-16"),
    (b"\xfe\xff", "UTF-16"),
];

/// The encoding of a text with wide characters that begins with a byte order mark.
pub(crate) fn by_mark(bytes: &[u8]) -> Option<&'static str> {
    MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)).map(|(_, name)| *name)
}

/// The encoding of such a text, by its byte order mark or by the zero bytes beside its letters.
fn of_bytes(bytes: &[u8]) -> Option<&'static str> {
    if let Some(name) = by_mark(bytes) {
        return Some(name);
    }
    let head = &bytes[..bytes.len().min(HEAD)];
    let spelt = |unit: usize, letter: usize| {
        let is_letter = |b: u8| matches!(b, 9..=13 | 32..=126);
        let units = head.chunks_exact(unit);
        units.len() >= 4
            && units
                .clone()
                .all(|u| u.iter().enumerate().all(|(i, b)| if i == letter { is_letter(*b) } else { *b == 0 }))
    };
    let is_either = |unit: usize| spelt(unit, 0) || spelt(unit, unit - 1);
    [(2, "UTF-16"), (4, "UTF-32")].into_iter().find(|(unit, _)| is_either(*unit)).map(|(_, name)| name)
}

/// True, and an error, if a file is a text of that kind.
pub(super) fn is_refused(bytes: &[u8], faults: &mut Faults<'_>) -> bool {
    let found = of_bytes(bytes);
    if let Some(name) = found {
        let message = format!("found text in {name}, expected UTF-8");
        faults.error("mesh::encoding", Token { text: &bytes[..0], at: 0 }, message, "save it as UTF-8");
    }
    found.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(text: &str, unit: usize, big: bool) -> Vec<u8> {
        let each = |c: char| {
            let bytes = u32::from(c).to_le_bytes()[..unit].to_vec();
            if big { bytes.into_iter().rev().collect() } else { bytes }
        };
        text.chars().flat_map(each).collect()
    }

    #[test]
    fn wide_texts_are_known_with_and_without_mark() {
        for (unit, name) in [(2, "UTF-16"), (4, "UTF-32")] {
            for text in ["solid a\n", "\u{feff}OFF\n", "\u{feff}ü", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"] {
                for big in [false, true] {
                    assert_eq!(of_bytes(&encoded(text, unit, big)), Some(name), "{text:?} {big}");
                }
            }
        }
        for bytes in [
            &b"solid a\n"[..],
            b"",
            b"\0",
            b"a\0b\0",
            b"\xef\xbb\xbfOFF",
            &[0; 100],
            &[1, 0, 2, 0, 3, 0, 4, 0],
        ] {
            assert_eq!(of_bytes(bytes), None, "{bytes:?}");
        }
    }
}
