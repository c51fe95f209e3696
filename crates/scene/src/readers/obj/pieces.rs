//! Large files in pieces, one on each core.
//!
//! A piece is read as if it were a file, and its lists are put behind those of the piece before it. Whatever a piece
//! cannot know without those before it, and whatever calls for a message, leaves the file to the reader of whole
//! files: what comes out does not depend on the pieces.

use super::{Current, Reader};
use crate::diagnostic::Diagnostics;
use crate::readers::faults::{Faults, Tally};
use crate::readers::lexer::{Lexer, Token, line_end};
use crate::readers::smoothing::Group;
use crate::readers::soup::Soup;
use crate::span::Sources;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A piece has at least so many bytes: it takes some milliseconds to read.
const LEAST: usize = 1 << 20;
/// Most pieces.
const MOST: usize = 8;
/// Lines between looks at whether another piece has given up.
const LINES: usize = 4096;

/// What a piece of a file says.
pub(super) struct Piece<'a> {
    soup: Soup<'a>,
    slots: Vec<Option<Token<'a>>>,
    /// What is used behind it; `None`: as before it.
    current: Option<Token<'a>>,
    libraries: Vec<Token<'a>>,
    known: usize,
}

/// Reads a file in pieces. `None` if it is small, or must be read as a whole.
pub(super) fn read(bytes: &[u8]) -> Option<Vec<Piece<'_>>> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    read_at(bytes, &cuts(bytes, threads.min(MOST).min(bytes.len() / LEAST)))
}

/// Reads the pieces between cuts. `None` if there are not two of them, or if the file must be read as a whole.
fn read_at<'a>(bytes: &'a [u8], cuts: &[usize]) -> Option<Vec<Piece<'a>>> {
    if cuts.len() < 3 {
        return None;
    }
    let given_up = &AtomicBool::new(false);
    std::thread::scope(|scope| {
        let spawn = |w: &[usize]| {
            let (start, end) = (w[0], w[1]);
            scope.spawn(move || read_piece(&bytes[..end], start, given_up))
        };
        let threads: Vec<_> = cuts.windows(2).map(spawn).collect();
        // All are waited for before any is missed.
        let pieces: Vec<_> = threads.into_iter().map(|t| t.join().ok().flatten()).collect();
        pieces.into_iter().collect()
    })
}

/// Where pieces begin and end: at the beginnings of lines, none of which goes on from the one before it.
fn cuts(bytes: &[u8], pieces: usize) -> Vec<usize> {
    let mut cuts = vec![0];
    for k in 1..pieces {
        let near = bytes.len() / pieces * k;
        let mut end = line_end(bytes, near);
        while end > 0 && end < bytes.len() && bytes[end - 1] == b'\\' {
            end = line_end(bytes, end + 1);
        }
        let end = end + if bytes[end..].starts_with(b"\r\n") { 2 } else { 1 };
        if end < bytes.len() && cuts.last().is_some_and(|last| *last < end) {
            cuts.push(end);
        }
    }
    cuts.push(bytes.len());
    cuts
}

/// Reads what stands at `start..` of the bytes.
fn read_piece<'a>(bytes: &'a [u8], start: usize, given_up: &AtomicBool) -> Option<Piece<'a>> {
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let mut faults = Faults::new(bytes, Path::new(""), "", &mut sources, &mut out);
    let lexer = Lexer::new(bytes, true);
    let lexer = if start > 0 { lexer.at(start) } else { lexer };
    let mut reader = Reader::new(lexer, &mut faults);
    reader.soup.group = Group::INHERITED;
    while !given_up.load(Ordering::Relaxed) {
        let goes_on = (0..LINES).all(|_| reader.line());
        if !reader.is_plain() {
            given_up.store(true, Ordering::Relaxed);
        } else if !goes_on {
            let current = match reader.current {
                Current::Named(name) => name,
                Current::Slot(slot) => reader.slots[slot as usize],
            };
            let Reader { soup, slots, libraries, known, .. } = reader;
            return Some(Piece { soup, slots, current, libraries, known });
        }
    }
    None
}

impl<'a> Reader<'a, '_, '_> {
    /// True if all so far can be said without what stands before, and without a word about it.
    fn is_plain(&self) -> bool {
        let t = &self.tallies;
        let tallies = [&t.thin, &t.colors, &t.normals, &t.numbers, &t.attributes, &t.nul, &t.names];
        let is_silent = |t: &Tally<'_>| t.count() == 0;
        self.faults.is_silent()
            && tallies.into_iter().chain([&self.unknown]).all(is_silent)
            && !self.counts_back
            && self.colors.is_empty()
            && self.soup.broken.is_empty()
    }

    /// Adds a piece behind what was read.
    pub(super) fn append(&mut self, piece: Piece<'a>) {
        let before = match self.current {
            Current::Named(name) => name,
            Current::Slot(slot) => self.slots[slot as usize],
        };
        let slot = |name: &Option<Token<'a>>| {
            self.current = Current::Named(name.or(before));
            self.slot()
        };
        let slots: Vec<u32> = piece.slots.iter().map(slot).collect();
        self.soup.append(piece.soup, &slots);
        self.current = Current::Named(piece.current.or(before));
        self.libraries.extend(piece.libraries);
        self.known += piece.known;
    }
}

#[cfg(test)]
mod tests {
    use super::super::ObjFile;
    use super::*;

    /// What a file says read with or without pieces, and what is told about it.
    type Answer = Option<(crate::mesh::TriangleMesh, Vec<Option<String>>, Vec<String>)>;

    fn answer(bytes: &[u8], read: impl for<'a> Fn(&mut Reader<'a, '_, '_>, &'a [u8])) -> (Answer, String) {
        let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
        let mut faults = Faults::new(bytes, Path::new("m.obj"), "m.obj", &mut sources, &mut out);
        let mut reader = Reader::new(Lexer::new(bytes, true), &mut faults);
        read(&mut reader, bytes);
        reader.check();
        let file = reader.finish().map(|ObjFile { mesh, slots, libraries }| {
            let names = slots.iter().map(|s| s.map(|t| t.lossy())).collect();
            (mesh, names, libraries.iter().map(Token::lossy).collect())
        });
        (file, format!("{out:?}"))
    }

    /// Reads a file in so many pieces and as a whole, which must give the same. False if pieces are not for it.
    fn is_the_same(text: &[u8], pieces: usize) -> bool {
        let cuts = cuts(text, pieces);
        if read_at(text, &cuts).is_none() {
            return false;
        }
        let whole = answer(text, |reader, _| while reader.line() {});
        let in_pieces = answer(text, |reader, bytes| {
            let pieces = read_at(bytes, &cuts).expect("read before");
            pieces.into_iter().for_each(|piece| reader.append(piece));
        });
        assert_eq!(whole, in_pieces, "{}", text.escape_ascii());
        true
    }

    /// A file of random statements, most of them plain.
    fn random_file(random: &mut impl FnMut(u32) -> u32) -> String {
        let mut text = String::new();
        let (mut vertices, mut normals) = (4, 0);
        text.push_str("v 0 0 0\nv 1 0 0\nv 1 1 0.25\nv 0 1 0\n");
        for _ in 0..random(40) {
            let corner = |limit: u32, random: &mut dyn FnMut(u32) -> u32| {
                let (p, n) = (1 + random(limit), 1 + random(normals + 1));
                match random(6) {
                    0 => format!(" {p}//{n}"),
                    1 => format!(" {p}/1/{p}"),
                    2 => format!(" {p}/{p}"),
                    _ => format!(" {p}//{p}"),
                }
            };
            let line = match random(12) {
                0 => format!("usemtl {}", ["a", "b", "c", ""][random(4) as usize]),
                1 => format!("s {}", ["off", "1", "2"][random(3) as usize]),
                2 => format!("mtllib {}.mtl", random(3)),
                3 => "g x \\".to_owned(),
                4 => "# c \\".to_owned(),
                5 => "vt 0.5 0.25".to_owned(),
                6 => {
                    normals += 1;
                    "vn 0 3 4".to_owned()
                }
                7 => {
                    vertices += 1;
                    format!("v {} {} 1e-3", random(9), random(9))
                }
                8 => ["f -1 -2 -3", "p 1", "v 1 2", "f 1 2"][random(4) as usize].to_owned(),
                _ => {
                    let corners: String = (0..3 + random(2)).map(|_| corner(vertices, random)).collect();
                    format!("f{corners}")
                }
            };
            text.push_str(&line);
            text.push_str(if random(9) == 0 { "\r\n" } else { "\n" });
        }
        text
    }

    #[test]
    fn pieces_give_what_the_whole_gives() {
        let mut rng = penombre_lab::Pcg32::new(7);
        let mut random = |n: u32| rng.below(n);
        let mut apart = 0;
        for round in 0..3000 {
            let text = random_file(&mut random);
            apart += usize::from(is_the_same(text.as_bytes(), 2 + round % 6));
        }
        assert!(apart > 300, "{apart}");
    }

    #[test]
    fn cuts_stand_at_beginnings_of_lines() {
        let text = b"v 1 2 3\r\nf 1 2 \\\n 3 4\n# a \\\r\n\nf 1 2 3\rf 3 2 1";
        for pieces in 1..12 {
            let cuts = cuts(text, pieces);
            assert_eq!((cuts[0], cuts[cuts.len() - 1]), (0, text.len()));
            assert!(cuts.windows(2).all(|w| w[0] < w[1]), "{cuts:?}");
            for cut in &cuts[1..cuts.len() - 1] {
                assert!([b'\n', b'\r'].contains(&text[cut - 1]), "{cuts:?}");
                assert!(!text[cut - 1..].starts_with(b"\r\n"), "{cuts:?}");
                assert!(!text[..cut - 1].ends_with(b"\\"), "{cuts:?}");
            }
        }
    }
}
