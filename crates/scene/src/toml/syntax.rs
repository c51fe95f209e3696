//! Syntax faults of TOML: which are told, and in what words.

use super::values::span;
use crate::diagnostic::Diagnostics;
use crate::span::FileId;
use ::toml::de::Error;
use std::ops::Range;

/// Syntax faults reported for one file: after that many the rest follows from the first.
const MOST_FAULTS: usize = 20;
/// Syntax faults of which the consequences of others are sorted out: hostile texts have millions.
const MOST_LOOKED_AT: usize = 500;

/// Reports syntax faults; true if there are any.
pub fn report_syntax(file: FileId, text: &str, errors: &[Error], out: &mut Diagnostics) -> bool {
    let shown = without_consequences(text, errors);
    for (range, message) in shown.iter().take(MOST_FAULTS) {
        let (message, help) = explain(message, text.get(range.clone()).unwrap_or(""));
        out.error("toml::syntax", span(file, range.clone()), message).help = help.to_owned();
    }
    if let Some((range, _)) = shown.get(MOST_FAULTS) {
        let message = format!("more than {MOST_FAULTS} syntax faults; the others are not shown");
        out.error("toml::syntax", span(file, range.clone()), message).help =
            "mend the first of them: others often follow from it".to_owned();
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

/// The parser's message in our words, and what right TOML looks like there.
fn explain(message: &str, found: &str) -> (String, &'static str) {
    let found: String = found.chars().take(40).collect();
    match message {
        "duplicate key" => (
            format!("`{found}` is defined twice"),
            "a key or table can be given once; give the second one another name or remove it",
        ),
        m if m.contains("recurse further") || m.contains("recursion limit") => (
            "lists and tables are nested too deeply, expected at most 80 levels".to_owned(),
            "scenes need few levels: is there an opening bracket too many?",
        ),
        m if m.starts_with("string values must be quoted") => unquoted(&found),
        m => {
            let m = m.trim_end_matches(", expected nothing");
            (format!("syntax error: {m}{}", seen(&found)), hint(m, &found))
        }
    }
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
    let mut words = found.split_whitespace();
    let begins_with_value =
        words.next().is_some_and(|w| w.parse::<f64>().is_ok() || w.parse::<bool>().is_ok());
    if begins_with_value && words.next().is_some() {
        return (format!("{found:?} is more than one value"), ONE_HELP);
    }
    (
        format!("{found:?} is a text without quotes"),
        "put texts in quotes: material = \"red\", color = \"#ff8000\"",
    )
}

const KEY_HELP: &str = "keys and values have `=` between them: fov = 45";
const LINE_HELP: &str = "a line is `key = value`, a header such as [shape.ball], or a comment after `#`";
const ONE_HELP: &str = "write one `key = value` a line, with commas between the entries of tables and lists";
const LIST_HELP: &str = "a list has commas between its entries and ends with `]`: [0, 1, 2]";
const TABLE_HELP: &str = "a table in a line looks like { rotate = [0, 1, 0], angle = 30 }";
const NUMBER_HELP: &str = "numbers look like 3, -0.5 or 2e-3, with digits on both sides of the point";

/// Right TOML by words of the parser's message; the first entry counts that has one of them.
const HINTS: [(&[&str], &str); 12] = [
    (&["cannot extend"], "this key has a value already, which is no table that could have parts"),
    (
        &["escape", "unicode"],
        "in quotes a backslash begins an escape: double it, or write / in the names of files",
    ),
    (&["string", "opening quote"], "a text begins and ends with a quote on one line: \"red\""),
    (&["inline table", "between key-value"], TABLE_HELP),
    (&["array table", "unclosed table", "invalid table", "table open"], "a header looks like [shape.ball]"),
    (&["array"], LIST_HELP),
    (&["key with no value", "value for key", "missing value", "extra `=`"], KEY_HELP),
    (&["leading zero"], "write the number without the zero before it"),
    (
        &["float", "integer", "number", "sign", "radix", "mantissa", "fraction", "exponent", "`_`"],
        NUMBER_HELP,
    ),
    (&["boolean"], "write true or false"),
    (&["date-time"], "scenes have no dates: put texts in quotes, and one number a value"),
    (&["unexpected key or value"], ONE_HELP),
];

fn hint(message: &str, found: &str) -> &'static str {
    if message.contains("key") && found == ":" {
        return KEY_HELP;
    }
    let what = message.split(", expected").next().unwrap_or(message);
    let fits = |words: &[&str]| words.iter().any(|word| what.contains(word));
    HINTS.iter().find(|(words, _)| fits(words)).map_or(LINE_HELP, |(_, help)| help)
}

fn seen(found: &str) -> String {
    if found.trim().is_empty() { String::new() } else { format!(", found {found:?}") }
}
