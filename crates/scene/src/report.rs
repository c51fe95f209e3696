//! Faults as people and programs read them.

use crate::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::printable::{harmless, of_one_length};
use crate::span::{SourceFile, Sources, Span};
use miette::{LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use serde_json::{Value, json};
use std::fmt;
use std::ops::Range;

/// Lines longer than this many bytes are shown as a window around the marked place.
const LONG_LINE: usize = 160;
/// Bytes of a long line shown before the marked place.
const BEFORE: usize = 60;
/// Bytes of a long line shown from the marked place on.
const AFTER: usize = 90;

/// A fault with its source text, to be drawn by one of `miette`'s handlers.
pub fn report(diagnostic: &Diagnostic, sources: &Sources) -> miette::Report {
    miette::Report::new(Drawn::new(diagnostic, sources))
}

#[derive(Debug)]
struct Drawn {
    diagnostic: Diagnostic,
    source: Option<Excerpt>,
}

impl Drawn {
    fn new(diagnostic: &Diagnostic, sources: &Sources) -> Self {
        let source = sources.get(diagnostic.span.file);
        let (source, cut) = source.map(|file| Excerpt::around(file, diagnostic.span.start as usize)).unzip();
        // Places count in the excerpt.
        let start = diagnostic.span.start.saturating_sub(cut.unwrap_or(0));
        let span = Span { start, ..diagnostic.span };
        let Diagnostic { message, label, help, .. } = diagnostic;
        let [message, label, help] = [message, label, help].map(|text| harmless(text).into_owned());
        Self { diagnostic: Diagnostic { message, label, help, span, ..*diagnostic }, source }
    }
}

impl fmt::Display for Drawn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.diagnostic.message)
    }
}

impl std::error::Error for Drawn {}

impl miette::Diagnostic for Drawn {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.diagnostic.code))
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.diagnostic.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
            Severity::Advice => miette::Severity::Advice,
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let help = self.diagnostic.help.as_str();
        if help.is_empty() { None } else { Some(Box::new(help)) }
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|s| s as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let source = self.source.as_ref()?;
        let words = Some(self.diagnostic.label.as_str()).filter(|l| !l.is_empty());
        let label =
            LabeledSpan::new_primary_with_span(words.map(str::to_owned), source.mark(self.diagnostic.span));
        Some(Box::new(std::iter::once(label)))
    }
}

/// A source text, of which only the neighbourhood of the marked place is shown.
#[derive(Debug)]
struct Excerpt(SourceFile);

impl Excerpt {
    /// What a drawing needs of a file, and the offset at which that begins: the whole text is not looked at anew
    /// for every fault.
    fn around(file: &SourceFile, at: usize) -> (Self, u32) {
        let (mut file, start) = file.around(at);
        if file.text.chars().any(|c| of_one_length(c) != c) {
            file.text = file.text.chars().map(of_one_length).collect::<String>().into();
        }
        (Self(file), start as u32)
    }

    fn text(&self) -> &str {
        &self.0.text
    }

    /// The part of a span that is drawn: within its first line and, if that is long, within the window.
    fn mark(&self, span: Span) -> SourceSpan {
        let text = self.text();
        let start = floor_boundary(text, span.start as usize);
        let end = floor_boundary(text, start.saturating_add(span.len as usize)).max(start);
        let marked = &text[start..end];
        let length = marked.find(['\n', '\r']).unwrap_or(marked.len());
        let end = floor_boundary(text, start + length.min(AFTER));
        (start, end - start).into()
    }

    /// Offset of the line that holds a place.
    fn line_start(&self, at: usize) -> usize {
        self.text()[..at].rfind('\n').map_or(0, |i| i + 1)
    }

    /// The part of a long line around a place.
    fn window(&self, at: usize) -> Range<usize> {
        let text = self.text();
        let line_end = text[at..].find('\n').map_or(text.len(), |i| at + i);
        let start = floor_boundary(text, at.saturating_sub(BEFORE)).max(self.line_start(at));
        let end = floor_boundary(text, (at + AFTER).min(line_end)).max(at);
        start..end
    }

    /// A part of the text with its place in the file.
    fn contents(&self, part: Range<usize>) -> MietteSpanContents<'_> {
        let at = self.0.locate(part.start);
        let span = (part.start, part.len()).into();
        let data = &self.text().as_bytes()[part];
        let lines = data.iter().filter(|b| **b == b'\n').count() + 1;
        let (line, column) = (at.line as usize - 1, at.column as usize - 1);
        MietteSpanContents::new_named(harmless(&self.0.name).into_owned(), data, span, line, column, lines)
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        context_lines_before: usize,
        context_lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let bytes = self.text().as_bytes();
        let contents = bytes.read_span(span, context_lines_before, context_lines_after)?;
        let (data, whole) = (contents.data(), *contents.span());
        let at = floor_boundary(self.text(), span.offset());
        // With no lines of context the contents begin at the place itself, which may be anywhere in its line.
        let far = at - self.line_start(at) > LONG_LINE;
        let long = far || data.split(|b| *b == b'\n').any(|line| line.len() > LONG_LINE);
        let part = if long && context_lines_before + context_lines_after > 0 {
            self.window(at)
        } else {
            whole.offset()..whole.offset() + whole.len()
        };
        Ok(Box::new(self.contents(part)))
    }
}

/// The last character boundary at or before `at`.
fn floor_boundary(text: &str, at: usize) -> usize {
    text.floor_char_boundary(at.min(text.len()))
}

/// A fault on a few lines: what, where, and what to do.
///
/// ```text
/// error: `radius` of `shape.ball` is -1, expected a number greater than 0 m
///   --> scene.toml:7:10
///   help: …
/// ```
pub fn render_plain(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let mut text = format!("{}: {}\n", diagnostic.severity.name(), harmless(&diagnostic.message));
    if let Some(at) = sources.locate(diagnostic.span) {
        text.push_str(&format!("  --> {}:{}:{}\n", harmless(at.name), at.line, at.column));
    }
    if !diagnostic.help.is_empty() {
        text.push_str(&format!("  help: {}\n", harmless(&diagnostic.help)));
    }
    text
}

/// All faults, one paragraph each.
pub fn render_all_plain(diagnostics: &Diagnostics, sources: &Sources) -> String {
    diagnostics.iter().map(|d| render_plain(d, sources)).collect::<Vec<_>>().join("\n")
}

/// A fault as a JSON object: `severity, code, message, help, file, line, column, end`, where `end` is the line and
/// column behind the marked place. Lines and columns count from 1; what is not known is null.
pub fn to_json(diagnostic: &Diagnostic, sources: &Sources) -> Value {
    let span = diagnostic.span;
    let at = sources.locate(span);
    let end = sources.locate(Span { start: span.start.saturating_add(span.len), len: 0, ..span });
    json!({
        "severity": diagnostic.severity.name(),
        "code": diagnostic.code,
        "message": diagnostic.message,
        "help": Some(diagnostic.help.as_str()).filter(|h| !h.is_empty()),
        "file": at.map(|a| a.name),
        "line": at.map(|a| a.line),
        "column": at.map(|a| a.column),
        "end": end.map(|e| json!({ "line": e.line, "column": e.column })),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::span::FileId;
    use std::path::Path;

    fn sources(text: &str, first_line: u32) -> (Sources, FileId) {
        let mut sources = Sources::default();
        let file = sources.add_excerpt(Path::new("dir/a.toml"), "a.toml", text, first_line);
        (sources, file)
    }

    fn fault(file: FileId, start: u32, len: u32) -> Diagnostic {
        Diagnostic::new(Severity::Error, "scene::test", Span { file, start, len }, "it is wrong")
            .help("mend it")
    }

    fn drawn(diagnostic: &Diagnostic, sources: &Sources) -> String {
        let mut text = String::new();
        let report = report(diagnostic, sources);
        miette::NarratableReportHandler::new().render_report(&mut text, report.as_ref()).unwrap();
        text
    }

    #[test]
    fn plain_names_the_place_in_characters() {
        let (sources, file) = sources("[a]\nä = \"ö\" # x\n", 1);
        let d = fault(file, 4 + 5, 4);
        assert_eq!(render_plain(&d, &sources), "error: it is wrong\n  --> a.toml:2:5\n  help: mend it\n");
        let nowhere = Diagnostic { span: Span::NONE, help: String::new(), ..d };
        assert_eq!(render_plain(&nowhere, &sources), "error: it is wrong\n");
    }

    #[test]
    fn json_has_every_key() {
        let (sources, file) = sources("one\ntwo three\n", 1);
        let json = to_json(&fault(file, 8, 5), &sources);
        let expected = json!({
            "severity": "error", "code": "scene::test", "message": "it is wrong", "help": "mend it",
            "file": "a.toml", "line": 2, "column": 5, "end": { "line": 2, "column": 10 },
        });
        assert_eq!(json, expected);
        let nowhere = Diagnostic { span: Span::NONE, ..fault(file, 0, 0) };
        assert!(to_json(&nowhere, &sources)["file"].is_null());
    }

    #[test]
    fn drawing_counts_lines_from_the_excerpts_start() {
        let (sources, file) = sources("v 1 2 3\nf 1 2 x\nv 0 0 0\n", 1000);
        let text = drawn(&fault(file, 14, 1), &sources);
        assert!(text.contains("a.toml"), "{text}");
        assert!(text.contains("1001"), "{text}");
        assert!(text.contains("f 1 2 x"), "{text}");
    }

    #[test]
    fn drawing_counts_columns_in_characters_from_the_excerpts_start() {
        let mut sources = Sources::default();
        let file = sources.add_excerpt_at(Path::new("m.obj"), "m.obj", "é 1 x\nö bad", 7, 500);
        for (start, place) in [(0, "m.obj:7:500"), (5, "m.obj:7:504"), (7, "m.obj:8:1"), (10, "m.obj:8:3")] {
            let fault = fault(file, start, 1);
            assert!(render_plain(&fault, &sources).contains(&format!("--> {place}\n")));
            // The head of a drawing is made of what is read without context.
            let report = report(&fault, &sources);
            let marked = (start as usize, 1).into();
            let read = report.source_code().unwrap().read_span(&marked, 0, 0).unwrap();
            let name = read.name().unwrap();
            assert_eq!(format!("{name}:{}:{}", read.line() + 1, read.column() + 1), place);
        }
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let line = format!("points = [{}oops{}]", "ö, ".repeat(50_000), "7, ".repeat(50_000));
        let at = line.find("oops").unwrap() as u32;
        let (sources, file) = sources(&line, 1);
        for len in [4, 100_000] {
            let text = drawn(&fault(file, at, len), &sources);
            assert!(text.contains("oops"), "{text}");
            assert!(text.len() < 2000, "{} bytes", text.len());
        }
    }

    #[test]
    fn no_control_character_reaches_a_terminal() {
        let (sources, file) = sources("# \u{1b}[2J\u{9b}x\nbad\u{7}", 1);
        let mut fault = fault(file, 10, 3);
        fault.message.push_str("\u{1b}[31m\n");
        fault.help.push('\u{9b}');
        let plain = render_plain(&fault, &sources);
        assert_eq!(
            plain,
            "error: it is wrong\u{fffd}[31m\u{fffd}\n  --> a.toml:2:1\n  help: mend it\u{fffd}\n"
        );
        let text = drawn(&fault, &sources);
        assert!(text.contains("bad?") && text.contains("# ?[2J·x"), "{text}");
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{text:?}");
    }

    #[test]
    fn places_beyond_the_text_or_inside_a_character_are_drawn() {
        let (sources, file) = sources("é", 1);
        for (start, len) in [(0, 0), (1, 0), (1, 1), (2, 0), (9, 9), (u32::MAX, u32::MAX)] {
            let text = drawn(&fault(file, start, len), &sources);
            assert!(text.contains("it is wrong"), "{text}");
            assert!(render_plain(&fault(file, start, len), &sources).contains("a.toml:1:"));
        }
        let (empty, file) = self::sources("", 1);
        assert!(drawn(&fault(file, 0, 0), &empty).contains("it is wrong"));
    }

    #[test]
    fn drawing_many_faults_of_a_large_text_takes_no_quadratic_time() {
        let count = 20_000;
        let text: String = (0..count).map(|i| format!("radius = {i:8}\n")).collect();
        let (sources, file) = sources(&text, 1);
        let begin = std::time::Instant::now();
        for i in (0..count).step_by(10) {
            let text = drawn(&fault(file, 18 * i + 9, 8), &sources);
            assert!(
                text.contains(&format!("radius = {i:8}")) && text.contains(&(i + 1).to_string()),
                "{text}"
            );
        }
        assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
    }
}
