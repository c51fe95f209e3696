//! The header of a PLY file: text, whatever follows it.

use super::scalar::Scalar;
use crate::readers::encoding;
use crate::readers::faults::Faults;
use crate::readers::lexer::{MARK, Token, integer};
use std::collections::HashSet;

const HELP: &str = "a PLY file begins with the lines `ply`, `format ascii 1.0` (or binary_little_endian, \
                    binary_big_endian), `element NAME COUNT`, `property TYPE NAME` and `end_header`";
const TYPES_HELP: &str = "types are char, uchar, short, ushort, int, uint, float, double, or int8 to float64";

/// How the numbers behind the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// One value, or a list of values, of every row of an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Property<'a> {
    pub name: Token<'a>,
    pub scalar: Scalar,
    /// The type of a list's length.
    pub list: Option<Scalar>,
}

/// A table of the file.
#[derive(Clone, Debug)]
pub(super) struct Element<'a> {
    pub name: Token<'a>,
    pub count: usize,
    pub properties: Vec<Property<'a>>,
}

impl Element<'_> {
    /// Bytes that a row takes at least in binary files: its lists are empty.
    pub fn least_bytes(&self) -> usize {
        self.properties.iter().map(|p| p.list.unwrap_or(p.scalar).size()).sum()
    }

    /// True if all rows have the same length in binary files.
    pub fn is_fixed(&self) -> bool {
        self.properties.iter().all(|p| p.list.is_none())
    }
}

/// What the header says.
#[derive(Clone, Debug)]
pub(super) struct Header<'a> {
    pub encoding: Encoding,
    pub elements: Vec<Element<'a>>,
    /// Offset of the first byte behind it.
    pub end: usize,
}

/// True if the bytes begin as PLY files do: with a line `ply`, perhaps with blanks behind it, and with a byte order mark
/// before it.
pub(in crate::readers) fn has_magic(bytes: &[u8]) -> bool {
    let rest = bytes.strip_prefix(MARK).unwrap_or(bytes);
    let rest = rest.strip_prefix(b"ply").unwrap_or(b"");
    let blanks = rest.iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    matches!(rest.get(blanks), Some(b'\n' | b'\r'))
}

/// Reads the header. `None` after errors.
pub(super) fn parse<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<Header<'a>> {
    if bytes.is_empty() {
        let end = faults.end();
        faults.error("ply::empty", end, "found an empty file, expected a line `ply`", HELP);
        return None;
    }
    if !has_magic(bytes) {
        if encoding::is_refused(bytes, faults) {
            return None;
        }
        let first = Words::new(bytes, 0, line_end(bytes, 0, b'\n')).next();
        let first = first.unwrap_or(Token { text: b"", at: 0 });
        let message = format!("this is no PLY file: found `{}`, expected a line `ply`", first.shortened());
        faults.error("ply::magic", first, message, HELP);
        return None;
    }
    let (names, properties) = (HashSet::new(), HashSet::new());
    let mut reader = Reader { faults, encoding: None, elements: Vec::new(), names, properties };
    let end = reader.lines(bytes)?;
    let Some(encoding) = reader.encoding else {
        let message = "found no line `format`, expected one in the header";
        reader.faults.error("ply::format", Token { text: &bytes[..3], at: 0 }, message, HELP);
        return None;
    };
    Some(Header { encoding, elements: reader.elements, end })
}

struct Reader<'a, 'f> {
    faults: &'f mut Faults<'a>,
    encoding: Option<Encoding>,
    elements: Vec<Element<'a>>,
    names: HashSet<&'a [u8]>,
    /// Names of the properties of the last element.
    properties: HashSet<&'a [u8]>,
}

impl<'a> Reader<'a, '_> {
    /// Reads the lines behind the first one; the offset behind the last. Lines end as the first does, so that binary
    /// data may begin with any byte.
    fn lines(&mut self, bytes: &'a [u8]) -> Option<usize> {
        let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(0);
        let old = bytes[first] == b'\r' && bytes.get(first + 1) != Some(&b'\n');
        let last = if old { b'\r' } else { b'\n' };
        let mut at = line_end(bytes, 0, last) + 1;
        while at < bytes.len() {
            let end = line_end(bytes, at, last);
            let mut words = Words::new(bytes, at, end);
            at = end + 1;
            match words.next() {
                Some(word) if word.text == b"end_header" => {
                    return (!self.faults.failed()).then_some(at.min(bytes.len()));
                }
                Some(word) => self.line(word, words)?,
                None => {}
            }
        }
        let message = "found the end of the file in the header, expected a line `end_header`";
        let end = self.faults.end();
        self.faults.error("ply::header", end, message, HELP);
        None
    }

    fn line(&mut self, word: Token<'a>, mut words: Words<'a>) -> Option<()> {
        match word.text {
            b"comment" | b"obj_info" => Some(()),
            b"format" => self.format(word, words),
            b"element" => {
                let name = self.word(word, words.next(), "the name of an element")?;
                let count = self.word(word, words.next(), "the number of its rows")?;
                self.element(name, count)?;
                self.ends(words)
            }
            b"property" => self.property(word, words),
            _ => {
                let found = word.shortened();
                let message =
                    format!("found `{found}`, expected comment, element, property, obj_info or end_header");
                self.fault("ply::header", word, message, HELP)
            }
        }
    }

    fn fault<T>(&mut self, code: &'static str, at: Token<'a>, message: String, help: &str) -> Option<T> {
        self.faults.error(code, at, message, help);
        None
    }

    /// The word, or a fault at the one that began the line.
    fn word(&mut self, line: Token<'a>, found: Option<Token<'a>>, expected: &str) -> Option<Token<'a>> {
        match found {
            Some(word) => Some(word),
            None => {
                let message = format!("found the end of the line `{}`, expected {expected}", line.lossy());
                self.fault("ply::header", line, message, HELP)
            }
        }
    }

    /// A fault at a word behind those that a line has.
    fn ends(&mut self, mut words: Words<'a>) -> Option<()> {
        let Some(word) = words.next() else { return Some(()) };
        let message = format!("found `{}`, expected the end of the line", word.shortened());
        self.fault("ply::header", word, message, HELP)
    }

    fn format(&mut self, line: Token<'a>, mut words: Words<'a>) -> Option<()> {
        let kind = self.word(line, words.next(), "the name of the format")?;
        let version = self.word(line, words.next(), "the version 1.0")?;
        let encoding = match kind.text {
            b"ascii" => Some(Encoding::Ascii),
            b"binary_little_endian" => Some(Encoding::Little),
            b"binary_big_endian" => Some(Encoding::Big),
            _ => None,
        };
        if encoding.is_none() {
            let message = format!(
                "found the format `{}`, expected ascii, binary_little_endian or binary_big_endian",
                kind.shortened()
            );
            return self.fault("ply::format", kind, message, HELP);
        }
        if version.text != b"1.0" {
            let message = format!("found the version `{}`, expected 1.0", version.shortened());
            return self.fault("ply::format", version, message, HELP);
        }
        if self.encoding.is_some() {
            let message = "found a second line `format`, expected one".to_owned();
            return self.fault("ply::format", line, message, "remove the one that is wrong");
        }
        self.encoding = encoding;
        self.ends(words)
    }

    fn element(&mut self, name: Token<'a>, count: Token<'a>) -> Option<()> {
        // The largest stands for all above it.
        let found = integer(count.text);
        let range = if found == Some(i64::MAX) { "below 2⁶³" } else { "0 or more" };
        let Some(rows) = found.filter(|n| *n < i64::MAX).and_then(|n| usize::try_from(n).ok()) else {
            let message = format!(
                "found `{}`, expected the number of rows of `{}`, {range}",
                count.shortened(),
                name.shortened()
            );
            return self.fault("ply::count", count, message, HELP);
        };
        self.properties = HashSet::new();
        if !self.names.insert(name.text) {
            let message = format!("found the element `{}` twice, expected it once", name.shortened());
            return self.fault("ply::element", name, message, "remove or rename one of them");
        }
        self.elements.push(Element { name, count: rows, properties: Vec::new() });
        Some(())
    }

    fn property(&mut self, line: Token<'a>, mut words: Words<'a>) -> Option<()> {
        let first = self.word(line, words.next(), "the type of the property")?;
        let (list, kind) = if first.text == b"list" {
            let count = self.word(line, words.next(), "the type of the list's length")?;
            let list = self.scalar(count)?;
            if !list.is_whole() {
                let message = format!(
                    "found the type {} for the length of a list, expected a whole one",
                    count.lossy()
                );
                return self.fault("ply::type", count, message, TYPES_HELP);
            }
            (Some(list), self.word(line, words.next(), "the type of the list's values")?)
        } else {
            (None, first)
        };
        let scalar = self.scalar(kind)?;
        let name = self.word(line, words.next(), "the name of the property")?;
        let Some(element) = self.elements.last_mut() else {
            let message = format!("found the property `{}`, expected an element before it", name.shortened());
            return self.fault("ply::header", line, message, HELP);
        };
        element.properties.push(Property { name, scalar, list });
        if !self.properties.insert(name.text) {
            let element = self.elements.last().map_or(String::new(), |e| e.name.shortened());
            let message = format!("`{element}` has two properties `{}`: the first counts", name.shortened());
            self.faults.warning("ply::twice", name, message, "remove or rename one of them");
        }
        self.ends(words)
    }

    fn scalar(&mut self, name: Token<'a>) -> Option<Scalar> {
        let scalar = Scalar::of_name(name.text);
        if scalar.is_none() {
            let message = format!("found the type `{}`, expected one of PLY", name.shortened());
            return self.fault("ply::type", name, message, TYPES_HELP);
        }
        scalar
    }
}

/// Offset of the byte that ends the line, or of the end of the file.
fn line_end(bytes: &[u8], from: usize, last: u8) -> usize {
    bytes[from..].iter().position(|b| *b == last).map_or(bytes.len(), |i| from + i)
}

/// The words of one line.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
}

impl<'a> Words<'a> {
    fn new(bytes: &'a [u8], at: usize, end: usize) -> Self {
        Self { bytes, at, end }
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        let rest = &self.bytes[self.at..self.end];
        let start = self.at + rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = &self.bytes[start..self.end];
        self.at = start + rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        Some(Token { text: &self.bytes[start..self.at], at: start })
    }
}
