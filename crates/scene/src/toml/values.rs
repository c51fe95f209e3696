//! TOML values and keys with their places.

use crate::description::{Param, Value, ValueKind};
use crate::span::{FileId, Span};
use ::toml::Spanned;
use ::toml::de::{DeTable, DeValue};
use std::ops::Range;

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
            Err(_) if i.radix() == 10 => ValueKind::Float(float(i.as_str())),
            Err(_) => ValueKind::Float(wide_int(i.as_str(), i.radix()).min(f64::MAX)),
        },
        DeValue::Float(f) => ValueKind::Float(float(f.as_str())),
        DeValue::Boolean(b) => ValueKind::Bool(*b),
        DeValue::Datetime(d) => ValueKind::String(d.to_string()),
        DeValue::Array(list) => ValueKind::Array(list.iter().map(|v| value(file, v)).collect()),
        DeValue::Table(table) => ValueKind::Table(params(file, table)),
    };
    Value { kind, span: span(file, parsed.span()) }
}

/// Digits beyond double precision come out as its largest number: only `inf` itself is infinite.
fn float(text: &str) -> f64 {
    let v: f64 = text.parse().unwrap_or(f64::NAN);
    let overflows = v.is_infinite() && text.contains(|c: char| c.is_ascii_digit());
    if overflows { f64::MAX.copysign(v) } else { v }
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
