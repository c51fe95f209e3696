//! The rows behind the header, as text or binary, as numbers.

use super::header::{Element, Encoding, Property};
use super::scalar::Scalar;
use crate::readers::faults::{Faults, Tally};
use crate::readers::lexer::{Lexer, Number, Token, integer, number};

/// Most values that one element gives.
pub(super) const CHANNELS: usize = 11;

/// What a property is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Nothing,
    /// One of the values of a row.
    Channel(usize),
    /// The list of indices.
    Indices,
    /// The list of texture coordinates of a face's corners.
    Uvs,
}

/// What one row holds of that which is used. The types of PLY all fit into `f64`.
#[derive(Debug, Default)]
pub(super) struct Row {
    pub channels: [f64; CHANNELS],
    pub indices: Vec<f64>,
    pub uvs: Vec<f64>,
}

impl Row {
    /// The list that a property fills, emptied.
    fn list(&mut self, usage: Use) -> Option<&mut Vec<f64>> {
        let list = match usage {
            Use::Indices => &mut self.indices,
            Use::Uvs => &mut self.uvs,
            Use::Nothing | Use::Channel(_) => return None,
        };
        list.clear();
        Some(list)
    }
}

/// Which row of an element is meant, and where it begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub row: usize,
    pub at: usize,
}

/// How often something happened, and in which row first.
#[derive(Debug, Default)]
pub(super) struct RowTally {
    first: Option<Place>,
    count: usize,
}

impl RowTally {
    pub fn add(&mut self, place: Place) {
        self.first.get_or_insert(place);
        self.count += 1;
    }

    /// A warning, if it happened at all: `what` is said of the first row.
    pub fn tell<'a>(
        &self,
        rows: &Rows<'a>,
        element: &Element<'a>,
        (code, what): (&'static str, &str),
        help: &str,
        faults: &mut Faults<'a>,
    ) {
        let Some(first) = self.first else { return };
        let (at, row) = rows.place(element, first);
        let times = match self.count {
            1 => String::new(),
            n => format!(" ({n} times, here the first)"),
        };
        faults.warning(code, at, format!("{row} {what}{times}"), help);
    }
}

/// Numbers of a text that are none of their type.
#[derive(Debug, Default)]
struct Misfits<'a> {
    tally: Tally<'a>,
    /// The first of them.
    first: Option<(Token<'a>, Scalar)>,
}

impl<'a> Misfits<'a> {
    /// Counts a number if it does not fit its type. Those that are not finite are another matter.
    fn see(&mut self, v: f64, word: Token<'a>, scalar: Scalar) {
        if v.is_finite() && !scalar.holds(v) {
            self.tally.add(word);
            self.first.get_or_insert((word, scalar));
        }
    }

    fn tell(&self, faults: &mut Faults<'a>) {
        if let Some((word, scalar)) = self.first {
            let message =
                format!("found `{}`, expected {}: used as it stands", word.shortened(), numbers_of(scalar));
            let help = "the header gives the property a type that does not hold all of its numbers";
            faults.tally("ply::range", &self.tally, &message, help);
        }
    }
}

/// The numbers of a type, for messages.
fn numbers_of(scalar: Scalar) -> String {
    let name = scalar.name();
    scalar.range().map_or_else(
        || format!("a number ({name})"),
        |[least, most]| format!("a whole number from {least} to {most} ({name})"),
    )
}

/// A cursor over the rows.
pub(super) struct Rows<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    extra: Tally<'a>,
    misfits: Misfits<'a>,
}

impl<'a> Rows<'a> {
    pub fn new(bytes: &'a [u8], at: usize, encoding: Encoding) -> Self {
        Self { bytes, at, encoding, extra: Tally::default(), misfits: Misfits::default() }
    }

    /// Offset of the next byte.
    pub fn offset(&self) -> usize {
        self.at
    }

    /// How many lines so far held more numbers than the header lists.
    pub fn longer_lines(&self) -> usize {
        self.extra.count()
    }

    /// Goes to an offset.
    pub fn seek(&mut self, at: usize) {
        self.at = at.min(self.bytes.len());
    }

    /// The bytes that are left, if they are binary, and whether the highest byte of a number comes first.
    pub fn binary(&self) -> Option<(&'a [u8], bool)> {
        let big = self.encoding == Encoding::Big;
        (self.encoding != Encoding::Ascii).then(|| (&self.bytes[self.at..], big))
    }

    /// The place to mark for a row, and the words that name it: text is marked itself, for binary data the element
    /// in the header.
    pub fn place(&self, element: &Element<'a>, place: Place) -> (Token<'a>, String) {
        let (name, row) = (element.name.shortened(), place.row);
        match self.encoding {
            Encoding::Ascii => {
                let mut line = Lexer::new(self.bytes, false).at(place.at);
                line.next_word_line();
                (line.token().unwrap_or(Token { text: b"", at: place.at }), format!("{name} {row}"))
            }
            _ => (element.name, format!("{name} {row} at byte {}", place.at)),
        }
    }

    /// Holds the number of rows against the bytes that are left. `None` after an error.
    pub fn check_count(&self, element: &Element<'a>, faults: &mut Faults<'a>) -> Option<()> {
        let left = self.bytes.len() - self.at;
        let (least, spare) = match self.encoding {
            // A digit and a blank for each number; the last blank may be missing.
            Encoding::Ascii => (2 * element.properties.len(), 1),
            _ => (element.least_bytes(), 0),
        };
        let expected = element.count as u128 * least as u128;
        if expected <= (left + spare) as u128 {
            return Some(());
        }
        let (rows, name) = (element.count, element.name.shortened());
        let exactly = element.is_fixed() && self.encoding != Encoding::Ascii;
        let about = if exactly { "" } else { "at least " };
        let message = format!(
            "{rows} rows of `{name}` are announced: expected {about}{expected} bytes from byte {} on, found {left}",
            self.at
        );
        let help = "the file was cut, or the number of rows is wrong";
        faults.error("ply::truncated", element.name, message, help);
        None
    }

    /// Passes over all rows of an element. `None` after an error.
    pub fn skip(&mut self, element: &Element<'a>, faults: &mut Faults<'a>) -> Option<()> {
        self.check_count(element, faults)?;
        let count = if element.properties.is_empty() { 0 } else { element.count };
        if self.encoding == Encoding::Ascii {
            let mut lexer = Lexer::new(self.bytes, false).at(self.at);
            for row in 0..count {
                if !lexer.next_word_line() {
                    return self.ends(element, row, faults);
                }
                lexer.next_line();
            }
            self.at = lexer.offset();
        } else if element.is_fixed() {
            self.at += count * element.least_bytes();
        } else {
            let uses = vec![Use::Nothing; element.properties.len()];
            let mut row = Row::default();
            for index in 0..count {
                self.row(element, &uses, index, &mut row, faults)?;
            }
        }
        Some(())
    }

    /// Reads a row. `None` after an error.
    pub fn row(
        &mut self,
        element: &Element<'a>,
        uses: &[Use],
        index: usize,
        row: &mut Row,
        faults: &mut Faults<'a>,
    ) -> Option<()> {
        match self.encoding {
            Encoding::Ascii => self.line(element, uses, index, row, faults),
            _ => self.record(element, uses, index, row, faults),
        }
    }

    fn ends(&self, element: &Element<'a>, row: usize, faults: &mut Faults<'a>) -> Option<()> {
        let (count, name) = (element.count, element.name.shortened());
        let message =
            format!("found the end of the file after {row} of {count} rows of `{name}`, expected all");
        let help = format!("{} more expected; was the file cut?", count - row);
        let end = faults.end();
        faults.error("ply::truncated", end, message, help);
        None
    }

    fn record(
        &mut self,
        element: &Element<'a>,
        uses: &[Use],
        index: usize,
        row: &mut Row,
        faults: &mut Faults<'a>,
    ) -> Option<()> {
        let start = self.at;
        for (property, usage) in element.properties.iter().zip(uses) {
            if self.property(property, *usage, row).is_none() {
                let place = Place { row: index, at: start };
                self.broken_record(element, property, place, faults);
                return None;
            }
        }
        Some(())
    }

    /// Reads a binary property; `None` if its length is negative or the file ends.
    fn property(&mut self, property: &Property<'a>, usage: Use, row: &mut Row) -> Option<()> {
        let (bytes, big) = (&self.bytes[self.at..], self.encoding == Encoding::Big);
        let Property { scalar, list, .. } = *property;
        let Some(count) = list else {
            let value = bytes.get(..scalar.size())?;
            if let Use::Channel(channel) = usage {
                row.channels[channel] = scalar.read(value, big);
            }
            self.at += scalar.size();
            return Some(());
        };
        let length = count.read(bytes.get(..count.size())?, big);
        let values = &bytes[count.size()..];
        if length < 0.0 || length * scalar.size() as f64 > values.len() as f64 {
            return None;
        }
        let values = &values[..length as usize * scalar.size()];
        if let Some(list) = row.list(usage) {
            list.extend(values.chunks_exact(scalar.size()).map(|b| scalar.read(b, big)));
        }
        self.at += count.size() + values.len();
        Some(())
    }

    /// Tells why a record cannot be read; the cursor stands at the property that fails.
    fn broken_record(
        &self,
        element: &Element<'a>,
        property: &Property<'a>,
        place: Place,
        faults: &mut Faults<'a>,
    ) {
        let (_, row) = self.place(element, place);
        let (bytes, big) = (&self.bytes[self.at..], self.encoding == Encoding::Big);
        let (name, left) = (property.name.shortened(), bytes.len());
        let length = property.list.and_then(|count| Some(count.read(bytes.get(..count.size())?, big)));
        let message = match (length, property.list) {
            (Some(length), _) if length < 0.0 => {
                format!(
                    "{row}: found the length {length} of the list `{name}` at byte {}, expected 0 or more",
                    self.at
                )
            }
            (Some(length), Some(count)) => format!(
                "{row}: the list `{name}` at byte {} announces {length} values: expected {} bytes, found {}",
                self.at,
                length * property.scalar.size() as f64,
                left - count.size()
            ),
            _ => format!("{row}: found {left} bytes at byte {}, expected `{name}`", self.at),
        };
        let help = "the file was cut or is damaged";
        faults.error("ply::truncated", element.name, message, help);
    }

    /// Reads a line of text.
    fn line(
        &mut self,
        element: &Element<'a>,
        uses: &[Use],
        index: usize,
        row: &mut Row,
        faults: &mut Faults<'a>,
    ) -> Option<()> {
        let mut lexer = Lexer::new(self.bytes, false).at(self.at);
        if !lexer.next_word_line() {
            return self.ends(element, index, faults);
        }
        let start = lexer.offset();
        for (property, usage) in element.properties.iter().zip(uses) {
            match text_property(&mut lexer, property, *usage, row, &mut self.misfits) {
                Ok(()) => {}
                Err(fault) => return self.broken_line(element, property, (index, start), fault, faults),
            }
        }
        if let Some(word) = lexer.token() {
            self.extra.add(word);
        }
        lexer.next_line();
        self.at = lexer.offset();
        Some(())
    }

    fn broken_line(
        &self,
        element: &Element<'a>,
        property: &Property<'a>,
        (row, at): (usize, usize),
        fault: TextFault<'a>,
        faults: &mut Faults<'a>,
    ) -> Option<()> {
        let name = property.name.shortened();
        let (start, what) = self.place(element, Place { row, at });
        let help =
            "every row has a line with the values that the header lists, and lists begin with their length";
        match fault {
            TextFault::Short => {
                let message = format!("found the end of the line of {what}, expected all of `{name}`");
                faults.error("ply::truncated", start, message, help);
            }
            TextFault::Length(word) => {
                let found = word.shortened();
                let message = format!("{what}: found `{found}`, expected the length of the list `{name}`");
                faults.error("ply::number", word, message, help);
            }
            TextFault::Index(word) => {
                let (found, expected) = (word.shortened(), numbers_of(property.scalar));
                let message = format!("{what}: found vertex `{found}`, expected {expected}");
                faults.error("ply::index", word, message, help);
            }
            TextFault::Number(word, fault) => faults.bad_number("ply::number", word, fault),
        }
        None
    }

    /// Tells what stands in vain on lines and behind the last element.
    pub fn finish(&self, faults: &mut Faults<'a>) {
        let help = "the header may lack a property; colours of such faces are left out, for they may be other numbers";
        let message = "numbers behind those that the header lists are passed over";
        faults.tally("ply::extra", &self.extra, message, help);
        self.misfits.tell(faults);
        let rest = &self.bytes[self.at..];
        let help = "the number of rows in the header may be too small";
        match (self.encoding, rest.iter().position(|b| *b != 0 && !b.is_ascii_whitespace())) {
            (_, None) => {}
            (Encoding::Ascii, Some(first)) => {
                let word = Lexer::new(rest, false).at(first).token();
                let word = word.unwrap_or(Token { text: b"", at: first });
                let at = Token { text: word.text, at: self.at + first };
                let message =
                    format!("found `{}` behind the last row, expected the end of the file", word.shortened());
                faults.warning("ply::trailing", at, message, help);
            }
            (_, Some(_)) => {
                let message =
                    format!("{} bytes follow behind the last row, from byte {} on", rest.len(), self.at);
                faults.warning("ply::trailing", Token { text: &self.bytes[..3], at: 0 }, message, help);
            }
        }
    }
}

/// Why a property of a line cannot be read.
enum TextFault<'a> {
    /// The line ends.
    Short,
    /// No length of a list.
    Length(Token<'a>),
    /// No index of its type.
    Index(Token<'a>),
    Number(Token<'a>, Number),
}

fn text_property<'a>(
    lexer: &mut Lexer<'a>,
    property: &Property<'a>,
    usage: Use,
    row: &mut Row,
    misfits: &mut Misfits<'a>,
) -> Result<(), TextFault<'a>> {
    let word = lexer.token().ok_or(TextFault::Short)?;
    let Some(count) = property.list else {
        if let Use::Channel(channel) = usage {
            row.channels[channel] = text_value(word, property.scalar)?;
            misfits.see(row.channels[channel], word, property.scalar);
        }
        return Ok(());
    };
    let length = integer(word.text).filter(|n| *n >= 0).ok_or(TextFault::Length(word))?;
    misfits.see(length as f64, word, count);
    let mut list = row.list(usage);
    // A length beyond the line is found where the line ends.
    for _ in 0..length {
        let word = lexer.token().ok_or(TextFault::Short)?;
        let Some(list) = &mut list else { continue };
        let value = text_value(word, property.scalar)?;
        if usage == Use::Indices && !property.scalar.holds(value) {
            return Err(TextFault::Index(word));
        }
        misfits.see(value, word, property.scalar);
        list.push(value);
    }
    Ok(())
}

/// A word as a number, rounded once, to its type.
fn text_value(word: Token<'_>, scalar: Scalar) -> Result<f64, TextFault<'_>> {
    let parsed = match scalar {
        Scalar::F32 => None,
        Scalar::F64 => std::str::from_utf8(word.text).ok().and_then(|t| t.parse::<f64>().ok()),
        _ => integer(word.text).map(|i| i as f64),
    };
    if let Some(value) = parsed.filter(|v| v.is_finite()) {
        return Ok(value);
    }
    match number(word.text) {
        Number::Finite(v) => Ok(f64::from(v)),
        Number::NotFinite => Ok(f64::NAN),
        fault => Err(TextFault::Number(word, fault)),
    }
}
