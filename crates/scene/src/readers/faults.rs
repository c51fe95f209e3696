//! Faults of text formats: their place is an excerpt of the file, cut from it only when there is a fault.

use super::lexer::{Number, Token, line_end};
use crate::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::printable::push;
use crate::span::{Sources, Span};
use std::collections::HashSet;
use std::path::Path;

/// After this many errors a reader stops.
const MOST_ERRORS: usize = 20;
/// Warnings told about one file.
const MOST_WARNINGS: usize = 20;
/// Bytes of a line that an excerpt shows on either side of the fault.
const EXCERPT: usize = 160;

/// Where the faults of one file go.
pub(super) struct Faults<'a> {
    bytes: &'a [u8],
    path: &'a Path,
    name: &'a str,
    sources: &'a mut Sources,
    out: &'a mut Diagnostics,
    errors: usize,
    warnings: usize,
    /// Offset of a line and its number: lines behind it are counted from there.
    counted: (usize, u32),
    said: HashSet<String>,
    held: Option<Held>,
}

/// Faults that wait to be told in the order of their places.
struct Held {
    list: Vec<HeldFault>,
    /// Numbers of errors and warnings before them.
    errors: usize,
    warnings: usize,
}

struct HeldFault {
    severity: Severity,
    code: &'static str,
    at: usize,
    len: usize,
    message: String,
    help: String,
}

impl<'a> Faults<'a> {
    pub fn new(
        bytes: &'a [u8],
        path: &'a Path,
        name: &'a str,
        sources: &'a mut Sources,
        out: &'a mut Diagnostics,
    ) -> Self {
        Self {
            bytes,
            path,
            name,
            sources,
            out,
            errors: 0,
            warnings: 0,
            counted: (0, 1),
            said: HashSet::new(),
            held: None,
        }
    }

    /// Faults of another file that this one names; they go to the same place.
    pub fn companion<'b>(&'b mut self, bytes: &'b [u8], path: &'b Path, name: &'b str) -> Faults<'b> {
        Faults::new(bytes, path, name, self.sources, self.out)
    }

    /// True if any error was reported.
    pub fn failed(&self) -> bool {
        self.errors > 0
    }

    /// True if nothing was told so far.
    pub fn is_silent(&self) -> bool {
        self.errors == 0 && self.warnings == 0 && self.said.is_empty()
    }

    /// True if it is time to stop reading.
    pub fn is_full(&self) -> bool {
        self.errors >= MOST_ERRORS
    }

    /// True if no more warnings are told: their texts need not be made.
    pub fn is_hushed(&self) -> bool {
        self.warnings > MOST_WARNINGS
    }

    /// Keeps errors and warnings back until [`Faults::tell_in_order`]: some are known only at the end of the file.
    pub fn hold(&mut self) {
        self.held = Some(Held { list: Vec::new(), errors: self.errors, warnings: self.warnings });
    }

    /// Tells what was held back, in the order of the file.
    pub fn tell_in_order(&mut self) {
        let Some(mut held) = self.held.take() else { return };
        (self.errors, self.warnings) = (held.errors, held.warnings);
        held.list.sort_by_key(|f| f.at);
        for f in held.list {
            self.tell(f);
        }
    }

    /// Tells a fault or holds it back.
    fn add(&mut self, fault: HeldFault) {
        let Some(held) = &mut self.held else { return self.tell(fault) };
        self.errors += usize::from(fault.severity == Severity::Error);
        self.warnings += usize::from(fault.severity == Severity::Warning);
        held.list.push(fault);
    }

    fn tell(&mut self, fault: HeldFault) {
        let HeldFault { severity, code, at, len, message, help } = fault;
        let span = self.span(at, len);
        if severity == Severity::Error && self.errors + 1 == MOST_ERRORS {
            let stop = format!("{}: reading stops after {MOST_ERRORS} errors", self.name);
            let help = "mend the first of them: others often follow from it";
            self.at_span(Severity::Advice, "reader::too-many-errors", span, stop, help);
        }
        self.at_span(severity, code, span, message, help);
    }

    /// An error at a word.
    pub fn error(
        &mut self,
        code: &'static str,
        at: Token<'_>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let (message, help) = (message.into(), help.into());
        let severity = Severity::Error;
        self.add(HeldFault { severity, code, at: at.at, len: at.text.len(), message, help });
    }

    /// A warning at a word; those behind the first twenty are left out.
    pub fn warning(
        &mut self,
        code: &'static str,
        at: Token<'_>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        if !self.is_hushed() {
            let (message, help) = (message.into(), help.into());
            let severity = Severity::Warning;
            self.add(HeldFault { severity, code, at: at.at, len: at.text.len(), message, help });
        }
    }

    /// A fault at a place that was registered before.
    pub fn at_span(
        &mut self,
        severity: Severity,
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.errors += usize::from(severity == Severity::Error);
        self.warnings += usize::from(severity == Severity::Warning);
        if severity == Severity::Warning && self.warnings > MOST_WARNINGS {
            if self.warnings == MOST_WARNINGS + 1 {
                let rest = format!("{}: further warnings are left out", self.name);
                let help = "mend the first of them: others are often the same mistake";
                self.out.push(
                    Diagnostic::new(Severity::Advice, "reader::too-many-warnings", span, rest).help(help),
                );
            }
            return;
        }
        self.out.push(Diagnostic::new(severity, code, span, message).help(help));
    }

    /// An error at a word that is no number that can be kept.
    pub fn bad_number(&mut self, code: &'static str, word: Token<'_>, fault: Number) {
        let shown = word.shortened();
        if fault == Number::Overflow {
            let message = format!("found `{shown}`, which is too large, expected a number below 3.4e38");
            self.error(code, word, message, "numbers are kept in single precision: scale the mesh down");
        } else {
            let help = "numbers look like 3, -0.5 or 2e-3, with a point and no comma";
            self.error(code, word, format!("found `{shown}`, expected a number"), help);
        }
    }

    /// True the first time it is called with that key: for warnings that come once per file.
    pub fn first(&mut self, key: &str) -> bool {
        self.said.len() < 64 && self.said.insert(key.to_owned())
    }

    /// One warning for many equal faults, at the first of them. Nothing if there was none.
    pub fn tally(&mut self, code: &'static str, tally: &Tally<'_>, message: &str, help: &str) {
        let Some(at) = tally.first else { return };
        let message = match tally.count {
            1 => message.to_owned(),
            n => format!("{message} ({n} times, here the first)"),
        };
        self.warning(code, at, message, help);
    }

    /// The end of the file as a place.
    pub fn end(&self) -> Token<'a> {
        Token { text: b"", at: self.bytes.len() }
    }

    /// The number of the line that begins at an offset.
    fn line(&mut self, start: usize) -> u32 {
        let (from, number) = if start >= self.counted.0 { self.counted } else { (0, 1) };
        let line = number + line_breaks(&self.bytes[from..start]);
        let splits_break = start > 0 && self.bytes[start - 1..].starts_with(b"\r\n");
        if !splits_break {
            self.counted = (start, line);
        }
        line
    }

    /// Registers the line around a place as an excerpt.
    pub fn span(&mut self, at: usize, len: usize) -> Span {
        let at = at.min(self.bytes.len());
        let line_start = line_start(self.bytes, at);
        let end = line_end(self.bytes, at);
        let from = boundary(self.bytes, line_start.max(at.saturating_sub(EXCERPT))).min(at);
        let to = boundary(self.bytes, end.min(at + len.min(EXCERPT) + EXCERPT)).max(at);
        let marked = boundary(self.bytes, (at + len.max(1)).min(to)).min(to);
        let before = printable(&self.bytes[from..at]);
        let inside = printable(&self.bytes[at..marked]);
        let after = printable(&self.bytes[marked..to]);
        let column = 1 + characters(&self.bytes[line_start..from]);
        let line = self.line(line_start);
        let (start, len) = (before.len() as u32, inside.len() as u32);
        let file = self.sources.add_excerpt_at(self.path, self.name, before + &inside + &after, line, column);
        Span { file, start, len }
    }
}

/// How often something happened and where first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally<'a> {
    first: Option<Token<'a>>,
    count: usize,
}

impl<'a> Tally<'a> {
    pub fn add(&mut self, at: Token<'a>) {
        self.first.get_or_insert(at);
        self.count += 1;
    }

    pub fn count(&self) -> usize {
        self.count
    }
}

fn line_start(bytes: &[u8], at: usize) -> usize {
    bytes[..at].iter().rposition(|b| matches!(b, b'\n' | b'\r')).map_or(0, |i| i + 1)
}

/// Number of lines that end in these bytes.
fn line_breaks(bytes: &[u8]) -> u32 {
    let ends = bytes.iter().zip(bytes.iter().skip(1).chain([&0]));
    ends.filter(|(b, next)| **b == b'\n' || (**b == b'\r' && **next != b'\n')).count() as u32
}

/// Number of characters, taking every byte that does not continue one as its beginning.
fn characters(bytes: &[u8]) -> u32 {
    bytes.iter().filter(|b| !is_continuation(**b)).count() as u32
}

fn is_continuation(b: u8) -> bool {
    b & 0xC0 == 0x80
}

/// The first place at or after `at` (at most three bytes on) where no UTF-8 character is cut.
fn boundary(bytes: &[u8], at: usize) -> usize {
    (at..at + 4).find(|i| bytes.get(*i).is_none_or(|b| !is_continuation(*b))).unwrap_or(at).min(bytes.len())
}

/// Text that does a terminal no harm. Tabs stay, and what is no UTF-8 is replaced.
fn printable(bytes: &[u8]) -> String {
    let mut shown = String::new();
    for c in String::from_utf8_lossy(bytes).chars() {
        if c == '\t' { shown.push(c) } else { push(&mut shown, c) }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    fn located(bytes: &[u8], at: usize, len: usize) -> (u32, u32, String) {
        let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
        let mut faults = Faults::new(bytes, Path::new("m.obj"), "m.obj", &mut sources, &mut out);
        let span = faults.span(at, len);
        let place = sources.locate(span).expect("registered");
        let text = &sources.get(span.file).expect("registered").text;
        (place.line, place.column, text[span.start as usize..(span.start + span.len) as usize].to_owned())
    }

    #[test]
    fn names_line_and_column() {
        let text = b"v 1 2\r\n# \xC3\xA9\rv one 2\n";
        assert_eq!(located(text, 2, 1), (1, 3, "1".to_owned()));
        assert_eq!(located(text, 9, 2), (2, 3, "é".to_owned()));
        assert_eq!(located(text, 14, 3), (3, 3, "one".to_owned()));
        assert_eq!(located(text, text.len(), 0), (4, 1, String::new()));
    }

    #[test]
    fn cuts_long_lines_and_keeps_the_column() {
        let mut text = b"x\n".to_vec();
        text.extend("é".repeat(100_000).bytes());
        text.extend(b" bad ");
        text.extend([b'y'; 100_000]);
        let at = 2 + 200_000 + 1;
        assert_eq!(located(&text, at, 3), (2, 100_002, "bad".to_owned()));
        let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
        Faults::new(&text, Path::new(""), "", &mut sources, &mut out).span(at, 3);
        assert!(sources.iter().all(|f| f.text.len() < 1000));
    }

    #[test]
    fn lines_are_counted_on_from_the_last_fault() {
        let text = b"1\n2\r\n3\r4\r\n\r\n6";
        let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
        let mut faults = Faults::new(text, Path::new(""), "", &mut sources, &mut out);
        let places = [(0, 1), (5, 3), (3, 2), (4, 3), (7, 4), (5, 3), (12, 6), (0, 1)];
        let spans = places.map(|(at, line)| (faults.span(at, 1), line));
        for (span, line) in spans {
            assert_eq!(sources.locate(span).map(|at| at.line), Some(line));
        }
    }

    #[test]
    fn replaces_what_is_not_text() {
        assert_eq!(located(b"a\x1b[31m\xff\x00", 1, 20).2, "\u{fffd}[31m\u{fffd}\u{fffd}");
        assert_eq!(located("x\u{202e}y".as_bytes(), 1, 3).2, "\\u{202e}");
        for at in 0..12 {
            located("é\u{1F600}\u{1F600}x".as_bytes(), at, 1);
        }
    }
}
