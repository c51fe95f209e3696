//! JSON with places.

use crate::description::{Param, Value, ValueKind};
use crate::span::{FileId, Span};
use std::collections::HashSet;

/// Objects and lists within each other at most.
const DEEPEST: u32 = 80;

/// What is wrong with a text.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub span: Span,
    pub message: String,
    pub help: String,
}

type Result<T> = std::result::Result<T, Fault>;

/// The value of a text.
pub fn parse(text: &str, file: FileId) -> Result<Value> {
    // An editor may have put a mark at the beginning.
    let start = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let mut parser = Parser { text, file, at: start, depth: 0 };
    let value = parser.value("a value")?;
    parser.space();
    if parser.at < text.len() {
        return Err(parser.unexpected("the end of the file", "a scene is one object: { … }"));
    }
    Ok(value)
}

struct Parser<'a> {
    text: &'a str,
    file: FileId,
    at: usize,
    depth: u32,
}

impl Parser<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    fn span(&self, start: usize) -> Span {
        let clamp = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Span { file: self.file, start: clamp(start), len: clamp(self.at - start) }
    }

    /// A fault at one character.
    fn fault(&self, at: usize, message: String, help: &str) -> Fault {
        let length = self.text[at..].chars().next().map_or(0, char::len_utf8);
        let span = Span { len: length as u32, ..Parser { at, ..*self }.span(at) };
        Fault { span, message, help: help.to_owned() }
    }

    /// Something else stands here.
    fn unexpected(&self, expected: &str, help: &str) -> Fault {
        let found = match self.text[self.at..].chars().next() {
            None => "the end of the file".to_owned(),
            Some(c) if c.is_ascii_alphabetic() => {
                let rest = &self.text[self.at..];
                let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
                format!("`{}`", &rest[..end.min(40)])
            }
            Some(c) => format!("{c:?}"),
        };
        let comment = self.text[self.at..].starts_with("//") || self.text[self.at..].starts_with("/*");
        let help =
            if comment { "JSON has no comments: take it away, or write the scene in TOML" } else { help };
        self.fault(self.at, format!("found {found}, expected {expected}"), help)
    }

    fn value(&mut self, expected: &str) -> Result<Value> {
        self.space();
        let start = self.at;
        let kind = match self.peek() {
            Some(b'{') => self.within(Self::object)?,
            Some(b'[') => self.within(Self::array)?,
            Some(b'"') => ValueKind::String(self.string()?),
            Some(b'-' | b'0'..=b'9') => self.number()?,
            _ => self.word(expected)?,
        };
        Ok(Value { kind, span: self.span(start) })
    }

    fn within(&mut self, read: fn(&mut Self) -> Result<ValueKind>) -> Result<ValueKind> {
        if self.depth == DEEPEST {
            let message =
                format!("objects and lists are nested too deeply, expected at most {DEEPEST} levels");
            return Err(self.fault(
                self.at,
                message,
                "scenes need few levels: is there an opening bracket too many?",
            ));
        }
        self.depth += 1;
        self.at += 1;
        let kind = read(self);
        self.depth -= 1;
        kind
    }

    /// True at the closing bracket, which is taken; else goes past the comma that must stand there after an entry.
    fn ends(&mut self, close: u8, entries: usize) -> Result<bool> {
        self.space();
        match self.peek() {
            Some(c) if c == close => {
                self.at += 1;
                return Ok(true);
            }
            Some(b',') if entries > 0 => self.at += 1,
            _ if entries == 0 => return Ok(false),
            _ => {
                let expected = format!("`,` or `{}`", char::from(close));
                return Err(self.unexpected(&expected, "entries have commas between them"));
            }
        }
        self.space();
        if self.peek() == Some(close) {
            let message = format!("a comma before `{}`", char::from(close));
            return Err(self.fault(self.at, message, "take the comma behind the last entry away"));
        }
        Ok(false)
    }

    fn array(&mut self) -> Result<ValueKind> {
        let mut list = Vec::new();
        while !self.ends(b']', list.len())? {
            list.push(self.value("a value or `]`")?);
        }
        Ok(ValueKind::Array(list))
    }

    fn object(&mut self) -> Result<ValueKind> {
        let mut entries: Vec<Param> = Vec::new();
        let mut names = HashSet::new();
        while !self.ends(b'}', entries.len())? {
            self.space();
            let start = self.at;
            if self.peek() != Some(b'"') {
                return Err(self.unexpected("a key in quotes or `}`", "keys have quotes: \"fov\": 45"));
            }
            let name = self.string()?;
            let name_span = self.span(start);
            if !names.insert(name.clone()) {
                let shown: String = name.chars().take(40).collect();
                let help =
                    "a key can be given once; give the second one another name or remove it".to_owned();
                return Err(Fault { span: name_span, message: format!("`{shown}` is defined twice"), help });
            }
            self.space();
            if self.peek() != Some(b':') {
                return Err(self.unexpected("`:`", "keys and values have a colon between them: \"fov\": 45"));
            }
            self.at += 1;
            entries.push(Param { name, name_span, value: self.value("a value")? });
        }
        Ok(ValueKind::Table(entries))
    }

    fn string(&mut self) -> Result<String> {
        let open = self.at;
        self.at += 1;
        let mut text = String::new();
        loop {
            let rest = &self.text[self.at..];
            let plain = rest.find(['"', '\\', '\n']).unwrap_or(rest.len());
            text.push_str(&rest[..plain]);
            self.at += plain;
            match self.peek() {
                Some(b'"') => {
                    self.at += 1;
                    return Ok(text);
                }
                Some(b'\\') => text.push(self.escape()?),
                _ => {
                    let message = "a text has no closing quote on its line".to_owned();
                    return Err(self.fault(open, message, "a text begins and ends with a quote: \"red\""));
                }
            }
        }
    }

    fn escape(&mut self) -> Result<char> {
        let at = self.at;
        let escaped = self.text.as_bytes().get(at + 1).copied();
        self.at += 2;
        Ok(match escaped {
            Some(c @ (b'"' | b'\\' | b'/')) => char::from(c),
            Some(b'b') => '\u{8}',
            Some(b'f') => '\u{c}',
            Some(b'n') => '\n',
            Some(b'r') => '\r',
            Some(b't') => '\t',
            Some(b'u') => {
                let high = self.unit();
                let low = match high {
                    Some(0xd800..=0xdbff) if self.text[self.at..].starts_with("\\u") => {
                        self.at += 2;
                        self.unit()
                    }
                    _ => None,
                };
                let units = [high, low].into_iter().flatten();
                let mut decoded = char::decode_utf16(units);
                match (high, decoded.next(), decoded.next()) {
                    (Some(_), Some(Ok(c)), None) => c,
                    _ => return Err(self.bad_escape(at)),
                }
            }
            _ => return Err(self.bad_escape(at)),
        })
    }

    fn bad_escape(&self, at: usize) -> Fault {
        let help = "in texts a backslash begins an escape: double it, or write / in the names of files";
        self.fault(at, "a backslash begins no escape that JSON knows".to_owned(), help)
    }

    /// Four hexadecimal digits.
    fn unit(&mut self) -> Option<u16> {
        let digits = self.text.get(self.at..self.at + 4)?;
        if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
            return None;
        }
        self.at += 4;
        u16::from_str_radix(digits, 16).ok()
    }

    fn word(&mut self, expected: &str) -> Result<ValueKind> {
        let words = [
            ("true", ValueKind::Bool(true)),
            ("false", ValueKind::Bool(false)),
            ("Infinity", ValueKind::Float(f64::INFINITY)),
        ];
        for (word, kind) in words {
            let rest = self.text[self.at..].strip_prefix(word);
            if rest.is_some_and(|r| !r.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_')) {
                self.at += word.len();
                return Ok(kind);
            }
        }
        let help = if self.text[self.at..].starts_with("null") {
            "leave out the key of what is not there"
        } else {
            "values are numbers, texts in quotes, true, false, lists [ ] and objects { }"
        };
        Err(self.unexpected(expected, help))
    }

    fn number(&mut self) -> Result<ValueKind> {
        let start = self.at;
        let rest = &self.text[start..];
        if rest.starts_with("-Infinity") {
            self.at += "-Infinity".len();
            return Ok(ValueKind::Float(f64::NEG_INFINITY));
        }
        let end =
            rest.find(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c))).unwrap_or(rest.len());
        let word = &rest[..end];
        let Some(whole) = form(word) else {
            let shown: String = word.chars().take(40).collect();
            let help = "numbers look like 3, -0.5 or 2e-3, with digits on both sides of the point and no zero before others";
            return Err(self.fault(start, format!("`{shown}` is no number"), help));
        };
        self.at += end;
        Ok(match word.parse::<i64>() {
            Ok(v) if whole => ValueKind::Int(v),
            // Digits beyond double precision come out as its largest number.
            _ => ValueKind::Float(word.parse::<f64>().map_or(f64::NAN, |v| v.clamp(f64::MIN, f64::MAX))),
        })
    }
}

/// Whether a word is a number of JSON, and then whether it is a whole one.
fn form(word: &str) -> Option<bool> {
    let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    let unsigned = word.strip_prefix('-').unwrap_or(word);
    let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
        Some((m, e)) => (m, Some(e.strip_prefix(['+', '-']).unwrap_or(e))),
        None => (unsigned, None),
    };
    let (whole, fraction) = match mantissa.split_once('.') {
        Some((w, f)) => (w, Some(f)),
        None => (mantissa, None),
    };
    let sound = digits(whole)
        && (whole == "0" || !whole.starts_with('0'))
        && fraction.is_none_or(digits)
        && exponent.is_none_or(digits);
    sound.then_some(fraction.is_none() && exponent.is_none())
}
