//! OFF, the Object File Format of Geomview \[Geomview\].
//!
//! Read: the prefixes `ST`, `C`, `N` in any combination; counts on the first line or the next; comments; polygons;
//! face colours of 3 or 4 values, 0–255 or 0–1. One vertex and one face per line; several vertices per line are
//! read if the first line of vertices holds three or more. Colours are taken as sRGB and made linear; alpha and
//! colour map indices are passed over. Not read: `4OFF`, `nOFF`, `OFF BINARY`.

use super::colors::{ColorScale, linear};
use super::encoding;
use super::faults::{Faults, Tally};
use super::lexer::{Lexer, Number, Token, integer, number};
use super::soup::{Corner, Soup};
use crate::mesh::TriangleMesh;
use penombre_math::{Vec2, Vec3};

const HEADER_HELP: &str = "an OFF file begins with `OFF`, then the numbers of vertices, faces and edges";
const FACE_HELP: &str =
    "a face is a line `n i1 … in`: the number of its corners, then their vertices, counted from 0";
const LAYOUT_HELP: &str = "vertices have what the first word says: `OFF` x y z, `NOFF` a normal too, `COFF` a colour, \
                           `STOFF` texture coordinates";

/// What the first word says about vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Layout {
    uvs: bool,
    colors: bool,
    normals: bool,
}

impl Layout {
    /// Numbers of a vertex, colours not counted: those may be three or four.
    fn plain_numbers(self) -> usize {
        3 + if self.normals { 3 } else { 0 } + if self.uvs { 2 } else { 0 }
    }

    /// What a vertex line must hold, for messages.
    fn describe(self) -> String {
        let mut text = "x y z".to_owned();
        text.push_str(if self.normals { " nx ny nz" } else { "" });
        text.push_str(if self.colors { " r g b a" } else { "" });
        text.push_str(if self.uvs { " s t" } else { "" });
        text
    }
}

/// Colours as a file has them, and their range.
#[derive(Default)]
struct RawColors {
    values: Vec<[f32; 3]>,
    scale: ColorScale,
}

struct Reader<'a, 'f, 's> {
    lexer: Lexer<'a>,
    faults: &'f mut Faults<'s>,
    layout: Layout,
    soup: Soup<'a>,
    vertex_colors: RawColors,
    face_colors: RawColors,
    extra: Tally<'a>,
    thin: Tally<'a>,
    odd_colors: Tally<'a>,
    /// Numbers behind the position that are not finite.
    odd_numbers: Tally<'a>,
}

/// Reads an OFF file. `None` after errors.
pub(super) fn parse<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<TriangleMesh> {
    if encoding::is_refused(bytes, faults) {
        return None;
    }
    let mut reader = Reader {
        lexer: Lexer::new(bytes, false),
        faults,
        layout: Layout::default(),
        soup: Soup::default(),
        vertex_colors: RawColors::default(),
        face_colors: RawColors::default(),
        extra: Tally::default(),
        thin: Tally::default(),
        odd_colors: Tally::default(),
        odd_numbers: Tally::default(),
    };
    reader.header()?;
    let [vertices, faces] = reader.counts()?;
    reader.vertices(vertices)?;
    reader.faces(faces)?;
    if reader.faults.failed() {
        return None;
    }
    reader.trailing();
    Some(reader.finish(bytes))
}

impl<'a> Reader<'a, '_, 'a> {
    /// Reads the first word. A file that begins with its counts is read with a warning.
    fn header(&mut self) -> Option<()> {
        if !self.lexer.next_word_line() {
            let end = self.faults.end();
            let message = "found an empty file, expected `OFF`, the counts and the vertices";
            self.faults.error("off::empty", end, message, HEADER_HELP);
            return None;
        }
        let start = self.lexer.offset();
        let word = self.lexer.token()?;
        let Some((prefix, rest)) = split_magic(word.text) else {
            return self.no_magic(word, start);
        };
        if rest > 0 {
            // `OFF8 6 12`: the counts follow without a blank.
            self.lexer = self.lexer.at(word.at + word.text.len() - rest);
        }
        self.layout = match layout_of(prefix) {
            Some(layout) => layout,
            None => return self.refuse(word, "vertices of four or n dimensions are"),
        };
        let mut ahead = self.lexer.clone();
        match ahead.token() {
            Some(t) if t.text.eq_ignore_ascii_case(b"BINARY") => self.refuse(t, "the binary form of OFF is"),
            _ => Some(()),
        }
    }

    fn refuse(&mut self, at: Token<'a>, what: &str) -> Option<()> {
        let message =
            format!("found `{}`: {what} not read, expected text that begins with `OFF`", at.lossy());
        let help = "write it as plain OFF or as OBJ in the program that made it";
        self.faults.error("off::unsupported", at, message, help);
        None
    }

    fn no_magic(&mut self, word: Token<'a>, start: usize) -> Option<()> {
        if integer(word.text).is_some() {
            let message = format!(
                "the first line is not `OFF`: found `{}`, taken as the number of vertices",
                word.lossy()
            );
            self.faults.warning("off::magic", word, message, "put a line `OFF` first");
            self.lexer = self.lexer.at(start);
            return Some(());
        }
        let message = format!("this is no OFF file: found `{}`, expected `OFF`", word.shortened());
        self.faults.error("off::magic", word, message, HEADER_HELP);
        None
    }

    /// Reads the numbers of vertices and faces, and of edges if it is there.
    fn counts(&mut self) -> Option<[usize; 2]> {
        let vertices = self.count("vertices", 6)?;
        let faces = self.count("faces", 2)?;
        // The number of edges may be absent, and nothing needs it. It may have a line for itself.
        let mut ahead = self.lexer.clone();
        if !ends_line(&ahead) || (ahead.next_word_line() && ahead.token().is_some() && ends_line(&ahead)) {
            self.count("edges", 1)?;
            self.lexer.next_line();
        }
        Some([vertices, faces])
    }

    /// Reads one count and holds it against the size of the file, roughly: a file that was cut gets its own
    /// message where it ends. `least`: bytes that each thing takes at least.
    fn count(&mut self, what: &str, least: usize) -> Option<usize> {
        if ends_line(&self.lexer) && !self.lexer.next_word_line() {
            let end = self.faults.end();
            let message = format!("found the end of the file, expected the number of {what}");
            self.faults.error("off::truncated", end, message, HEADER_HELP);
            return None;
        }
        let word = self.lexer.token()?;
        let left = self.lexer.remaining();
        let found = integer(word.text);
        match found.and_then(|n| usize::try_from(n).ok()) {
            Some(n) if n.saturating_mul(least) <= left.saturating_mul(16).saturating_add(4096) => Some(n),
            Some(_) => {
                let n = word.shortened();
                let message =
                    format!("{n} {what} are announced: found {left} bytes behind that, expected more");
                let help = format!("each of the {what} takes {least} bytes or more");
                self.faults.error("off::counts", word, message, help);
                None
            }
            None => {
                let message =
                    format!("found `{}`, expected the number of {what}, 0 or more", word.shortened());
                self.faults.error("off::counts", word, message, HEADER_HELP);
                None
            }
        }
    }

    fn vertices(&mut self, count: usize) -> Option<()> {
        self.soup.positions.reserve(count.min(self.lexer.remaining() / 6 + 1));
        let mut per_line = None;
        for index in 0..count {
            let fresh = per_line != Some(true) || ends_line(&self.lexer);
            if fresh && !self.lexer.next_word_line() {
                return self.truncated(index, count, "vertices");
            }
            let several = *per_line.get_or_insert_with(|| self.several_per_line());
            self.vertex(index as u32, several);
            if self.faults.is_full() {
                return None;
            }
            if !several {
                self.lexer.next_line();
            }
        }
        if per_line == Some(true) && !ends_line(&self.lexer) {
            self.extra.add(self.lexer.token()?);
        }
        Some(())
    }

    /// True if the line that begins here holds three or more whole vertices.
    fn several_per_line(&self) -> bool {
        let mut ahead = self.lexer.clone();
        let words = std::iter::from_fn(|| ahead.token()).count();
        let each = self.layout.plain_numbers();
        !self.layout.colors && words >= 3 * each && words.is_multiple_of(each)
    }

    /// `several`: other vertices may follow on the line.
    fn vertex(&mut self, index: u32, several: bool) {
        let mut line = self.lexer.clone();
        let start = line.token().expect("the caller found a word");
        let mut values = [0.0; 12];
        let mut found = 0;
        // Colours make the line's length tell whether they have three or four values.
        let most = if self.layout.colors { values.len() } else { self.layout.plain_numbers() };
        let mut broken = false;
        while found < most {
            let Some(word) = self.lexer.token() else { break };
            match number(word.text) {
                Number::Finite(v) => values[found] = v,
                Number::NotFinite if found < 3 => broken = true,
                Number::NotFinite => self.odd_numbers.add(word),
                fault => return self.bad_number(word, fault),
            }
            found += 1;
        }
        let least = self.layout.plain_numbers() + if self.layout.colors { 3 } else { 0 };
        if found < least {
            let wanted = self.layout.describe();
            let message =
                format!("vertex {index}: found {found} numbers, expected {least} or more: {wanted}");
            self.faults.error("off::vertex", start, message, LAYOUT_HELP);
        } else if !several && let Some(word) = self.lexer.token() {
            self.extra.add(word);
        }
        if broken {
            self.soup.broken.push((index, start));
        }
        self.soup.positions.push(Vec3::new(values[0], values[1], values[2]));
        self.vertex_attributes(&values, found.max(least));
    }

    fn vertex_attributes(&mut self, values: &[f32; 12], found: usize) {
        let mut at = 3;
        if self.layout.normals {
            let normal = Vec3::new(values[3], values[4], values[5]);
            self.soup.normals.push(normal.as_dvec3().normalize_or_zero().as_vec3());
            at += 3;
        }
        if self.layout.colors {
            let color = [values[at], values[at + 1], values[at + 2]];
            self.vertex_colors.scale.see(color, true);
            self.vertex_colors.values.push(color);
        }
        if self.layout.uvs {
            let at = found.clamp(at + 2, values.len()) - 2;
            self.soup.uvs.push(Vec2::new(values[at], values[at + 1]));
        }
    }

    fn bad_number(&mut self, word: Token<'a>, fault: Number) {
        self.faults.bad_number("off::number", word, fault);
        self.soup.positions.push(Vec3::ZERO);
        while self.lexer.token().is_some() {}
    }

    fn truncated(&mut self, read: usize, count: usize, what: &str) -> Option<()> {
        let end = self.faults.end();
        let message = format!("found the end of the file after {read} of {count} {what}, expected all");
        let help = format!("{} more expected; was the file cut?", count - read);
        self.faults.error("off::truncated", end, message, help);
        None
    }

    fn faces(&mut self, count: usize) -> Option<()> {
        for index in 0..count {
            if !self.lexer.next_word_line() {
                return self.truncated(index, count, "faces");
            }
            self.face();
            if self.faults.is_full() {
                return None;
            }
            self.lexer.next_line();
        }
        Some(())
    }

    fn face(&mut self) {
        let first = self.lexer.token().expect("the caller found a word");
        let Some(corners) = integer(first.text).filter(|n| *n >= 0) else {
            let message = format!("found `{}`, expected the number of corners of a face", first.shortened());
            self.faults.error("off::face", first, message, FACE_HELP);
            return;
        };
        for read in 0..corners {
            let Some(word) = self.lexer.token() else {
                let message = format!(
                    "the face announces {} corners: found {read} indices in its line, expected as many",
                    first.shortened()
                );
                self.faults.error("off::face", first, message, FACE_HELP);
                return self.soup.drop_corners();
            };
            match self.index(word) {
                Some(i) => self.soup.corner(Corner { position: i, uv: i, normal: i }),
                None => return self.soup.drop_corners(),
            }
        }
        if corners < 3 {
            self.thin.add(first);
            return self.soup.drop_corners();
        }
        self.soup.finish_polygon(first.at, 0);
        self.face_color();
    }

    /// The index of a vertex; `None` after an error.
    fn index(&mut self, word: Token<'a>) -> Option<u32> {
        let vertices = self.soup.positions.len();
        let message = match integer(word.text) {
            Some(i) if (0..vertices as i64).contains(&i) => return Some(i as u32),
            Some(_) if vertices == 0 => {
                format!("found vertex {} in the face, expected vertices: there are none", word.shortened())
            }
            Some(_) => {
                format!("found vertex {} in the face, expected 0 to {}", word.shortened(), vertices - 1)
            }
            None => format!("found `{}`, expected the index of a vertex", word.shortened()),
        };
        self.faults.error("off::index", word, message, FACE_HELP);
        None
    }

    /// Reads what follows the indices: nothing, an index into a colour map, or 3 or 4 colour values.
    fn face_color(&mut self) {
        let words: Vec<Token<'a>> = std::iter::from_fn(|| self.lexer.token()).take(5).collect();
        let mut color = [f32::NAN; 3];
        let mut values = [0.0; 5];
        let mut finite = true;
        for (value, word) in values.iter_mut().zip(&words) {
            match number(word.text) {
                Number::Finite(v) => *value = v,
                Number::NotFinite => finite = false,
                fault => return self.faults.bad_number("off::number", *word, fault),
            }
        }
        let whole = words.iter().all(|w| integer(w.text).is_some());
        match (words.len(), words.first()) {
            (3 | 4, _) if finite => {
                color = [values[0], values[1], values[2]];
                self.face_colors.scale.see(color, whole);
            }
            (1, _) if whole => {}
            (_, Some(first)) => self.odd_colors.add(*first),
            (_, None) => {}
        }
        self.face_colors.values.push(color);
    }

    /// Warns of words after the last face.
    fn trailing(&mut self) {
        if !self.lexer.next_word_line() {
            return;
        }
        if let Some(word) = self.lexer.token() {
            let message =
                format!("found `{}` after the last face, expected the end of the file", word.shortened());
            let help = "the number of faces in the header may be too small";
            self.faults.warning("off::trailing", word, message, help);
        }
    }

    fn finish(mut self, bytes: &'a [u8]) -> TriangleMesh {
        self.faults.tally("off::extra", &self.extra, "numbers after a vertex are passed over", LAYOUT_HELP);
        let message = "a number behind the position of a vertex is not finite and taken as 0";
        self.faults.tally("off::not-finite", &self.odd_numbers, message, LAYOUT_HELP);
        let message = "a face with fewer than 3 corners is left out";
        self.faults.tally("off::thin-face", &self.thin, message, FACE_HELP);
        let message = "this is no face colour and is passed over, expected 3 or 4 numbers";
        let help = "a colour is `r g b` or `r g b a` behind the indices, from 0 to 255 or from 0 to 1";
        self.faults.tally("off::face-color", &self.odd_colors, message, help);
        let RawColors { values, scale } = self.vertex_colors;
        if scale.is_used() {
            self.soup.colors = values.into_iter().map(|c| linear(c, scale)).collect();
        }
        let RawColors { values, scale } = self.face_colors;
        if scale.is_used() {
            self.soup.face_colors = values.into_iter().map(|c| linear(c, scale)).collect();
        }
        let lexer = self.lexer;
        self.soup.into_mesh(self.faults, |at| lexer.at(at).token().unwrap_or(Token { text: &bytes[..0], at }))
    }
}

/// Splits `…OFF…` into what stands before the magic word and the number of bytes after it. The word may touch the
/// counts.
fn split_magic(word: &[u8]) -> Option<(&[u8], usize)> {
    let at = word.windows(3).position(|w| w.eq_ignore_ascii_case(b"OFF"))?;
    let rest = &word[at + 3..];
    let is_prefix = word[..at].iter().all(|b| b"STCN4n".contains(b));
    (is_prefix && rest.iter().all(u8::is_ascii_digit)).then_some((&word[..at], rest.len()))
}

/// The layout of a prefix; `None` for `4` and `n`.
fn layout_of(prefix: &[u8]) -> Option<Layout> {
    let mut layout = Layout::default();
    for b in prefix {
        match b {
            b'S' | b'T' => layout.uvs = true,
            b'C' => layout.colors = true,
            b'N' => layout.normals = true,
            _ => return None,
        }
    }
    Some(layout)
}

fn ends_line(lexer: &Lexer<'_>) -> bool {
    lexer.clone().token().is_none()
}
