//! TOML values and keys with their places.

use crate::description::{Param, Value, ValueKind};
use crate::diagnostic::Diagnostics;
use crate::span::{FileId, Span};
use ::toml::Spanned;
use ::toml::de::{DeTable, DeValue, Error};
use std::ops::Range;

/// Syntax faults reported for one file: after that many the rest follows from the first.
const MOST_FAULTS: usize = 20;
/// Syntax faults of which the consequences of others are sorted out: hostile texts have millions.
const MOST_LOOKED_AT: usize = 500;

/// The span of a range of bytes of a file.
pub fn span(file: FileId, range: Range<usize>) -> Span {
    let clamp = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Span { file, start: clamp(range.start), len: clamp(range.len()) }
}

/// Converts a parsed value; what TOML has and scenes have not (dates) becomes a text.
pub fn value(file: FileId, parsed: &Spanned<DeValue<'_>>) -> Value {
    let kind = match parsed.get_ref() {
        DeValue::String(s) => ValueKind::String(s.to_string()),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(v) => ValueKind::Int(v),
            // Beyond 64 bits: as a number it may still be meant; where a whole number is, it is out of range.
            Err(_) if i.radix() == 10 => ValueKind::Float(i.as_str().parse().unwrap_or(f64::NAN)),
            Err(_) => ValueKind::Float(wide_int(i.as_str(), i.radix())),
        },
        DeValue::Float(f) => ValueKind::Float(f.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(b) => ValueKind::Bool(*b),
        DeValue::Datetime(d) => ValueKind::String(d.to_string()),
        DeValue::Array(list) => ValueKind::Array(list.iter().map(|v| value(file, v)).collect()),
        DeValue::Table(table) => ValueKind::Table(params(file, table)),
    };
    Value { kind, span: span(file, parsed.span()) }
}

/// Hexadecimal, octal and binary numbers have no sign in TOML.
fn wide_int(digits: &str, radix: u32) -> f64 {
    let digit = |c: char| c.to_digit(radix).map_or(0.0, f64::from);
    digits.chars().fold(0.0, |sum, c| sum * f64::from(radix) + digit(c))
}

/// The entries of a table in file order.
pub fn params(file: FileId, table: &DeTable<'_>) -> Vec<Param> {
    let mut params: Vec<Param> = table
        .iter()
        .map(|(key, v)| Param {
            name: key.get_ref().to_string(),
            name_span: span(file, key.span()),
            value: value(file, v),
        })
        .collect();
    params.sort_by_key(|p| p.name_span.start);
    params
}

/// Reports syntax faults; true if there are any.
pub fn report_syntax(file: FileId, text: &str, errors: &[Error], out: &mut Diagnostics) -> bool {
    let shown = without_consequences(text, errors);
    for (range, message) in shown.iter().take(MOST_FAULTS) {
        let (message, help) = explain(message, text.get(range.clone()).unwrap_or(""));
        out.error("toml::syntax", span(file, range.clone()), message).help = help;
    }
    if let Some((range, _)) = shown.get(MOST_FAULTS) {
        let message = format!("more than {MOST_FAULTS} syntax faults; the others are not shown");
        out.error("toml::syntax", span(file, range.clone()), message);
    }
    !errors.is_empty()
}

/// The faults in the order of the text, without those that only follow from another: the parser goes on behind
/// what it could not read. Behind a fault of structure it has lost its way until the end of the line; below a
/// header that is there twice all keys are doubtful.
fn without_consequences<'a>(text: &str, errors: &'a [Error]) -> Vec<(Range<usize>, &'a str)> {
    const DUPLICATE: &str = "duplicate key";
    let clamp = |r: Range<usize>| r.start.min(text.len())..r.end.clamp(r.start, text.len().max(r.start));
    let mut faults: Vec<(Range<usize>, &str)> =
        errors.iter().map(|e| (clamp(e.span().unwrap_or(0..0)), e.message())).collect();
    faults.sort_by_key(|(range, _)| range.start);
    faults.truncate(MOST_LOOKED_AT);
    let bytes = text.as_bytes();
    let line_end = |at: usize| bytes[at..].iter().position(|b| *b == b'\n').map_or(text.len(), |n| at + n);
    let mut lost_until = None;
    let mut doubtful_until = 0;
    faults.retain(|(range, message)| {
        let duplicate = *message == DUPLICATE;
        if lost_until.is_some_and(|end| range.start <= end) || (duplicate && range.start < doubtful_until) {
            return false;
        }
        let line_start = bytes[..range.start].iter().rposition(|b| *b == b'\n').map_or(0, |n| n + 1);
        if duplicate && bytes[line_start..].trim_ascii_start().starts_with(b"[") {
            let next = bytes[range.start..].windows(2).position(|w| w == b"\n[");
            doubtful_until = next.map_or(text.len(), |n| range.start + n);
        }
        let structure =
            ["unclosed", "missing", "unexpected", "key with no value", "unquoted key", "must be quoted"];
        if structure.iter().any(|word| message.contains(word)) && !message.contains("leading zero") {
            lost_until = Some(line_end(range.start));
        }
        true
    });
    faults
}

/// The parser's message in our words, and a hint for the common mistakes.
fn explain(message: &str, found: &str) -> (String, String) {
    let found: String = found.chars().take(40).collect();
    let (what, help) = match message {
        "duplicate key" => (
            format!("`{found}` is defined twice"),
            "a key or table can be given once; give the second one another name or remove it",
        ),
        m if m.contains("recurse further") || m.contains("recursion limit") => {
            ("lists and tables are nested too deeply, expected at most 80 levels".to_owned(), "")
        }
        m if m.starts_with("string values must be quoted") => unquoted(&found),
        m => {
            let m = m.trim_end_matches(", expected nothing");
            (format!("syntax error: {m}{}", seen(&found)), hint(m, &found))
        }
    };
    (what, help.to_owned())
}

/// Something that is no value stands where a value is wanted.
fn unquoted(found: &str) -> (String, &'static str) {
    if found.trim().is_empty() {
        let help =
            "write a value behind `=`; texts and colours in quotes, for `#` begins a comment: \"#ff8000\"";
        return ("a value is missing".to_owned(), help);
    }
    let numbers = found.chars().all(|c| c.is_ascii_digit() || " .+-eE".contains(c));
    if numbers {
        return (format!("{found:?} is no value"), "put commas between the entries of a list: [0, 1, 2]");
    }
    (
        format!("{found:?} is a text without quotes"),
        "put texts in quotes: material = \"red\", color = \"#ff8000\"",
    )
}

/// What the common mistakes are mended with.
fn hint(message: &str, found: &str) -> &'static str {
    match message {
        m if m.contains("escape") || m.contains("unicode") => {
            "in quotes a backslash begins an escape: double it, or write / in the names of files"
        }
        m if m.contains("basic string") => "a text ends with a quote on the same line",
        m if m.contains("unquoted key") && found == ":" => "keys and values have `=` between them: fov = 45",
        m if m.contains("mantissa") || m.contains("fraction") => {
            "write digits on both sides of the point: 0.5, 1.0"
        }
        m if m.contains("leading zero") => "write the number without the zero before it",
        _ => "",
    }
}

fn seen(found: &str) -> String {
    if found.trim().is_empty() { String::new() } else { format!(", found {found:?}") }
}

/// Reads one value; used for `--set`. `None` if the text is no TOML value.
pub fn read_value(text: &str, file: FileId, offset: usize) -> Option<Value> {
    let parsed = DeValue::parse(text).ok()?;
    let mut value = value(file, &parsed);
    shift(&mut value, u32::try_from(offset).ok()?);
    Some(value)
}

fn shift(value: &mut Value, by: u32) {
    value.span.start += by;
    match &mut value.kind {
        ValueKind::Array(list) => list.iter_mut().for_each(|v| shift(v, by)),
        ValueKind::Table(entries) => {
            for entry in entries {
                entry.name_span.start += by;
                shift(&mut entry.value, by);
            }
        }
        _ => {}
    }
}

/// The parts of a dotted key with their places, or `None` if the text is no key.
pub fn read_key_path(text: &str, file: FileId) -> Option<Vec<(String, Span)>> {
    let line = format!("{text} = 0");
    let parsed = DeTable::parse(&line).ok()?;
    let mut path = Vec::new();
    let mut table = parsed.get_ref();
    loop {
        let (key, value) = table.iter().next()?;
        path.push((key.get_ref().to_string(), span(file, key.span())));
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            _ => return Some(path),
        }
    }
}
