//! Faults and advice about scenes, with their places.

use crate::span::Span;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The scene cannot be rendered.
    Error,
    /// The scene renders, perhaps not as meant.
    Warning,
    /// A remark that helps.
    Advice,
}

impl Severity {
    /// `error`, `warning` or `advice`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Advice => "advice",
        }
    }
}

/// One fault: what was found, where, what was expected.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// Stable name of this kind of fault, for example `scene::unknown-parameter`.
    pub code: &'static str,
    /// Where; [`Span::NONE`] if there is no place (a missing file on the command line).
    pub span: Span,
    /// What is wrong, in one sentence without a full stop; names what was found and what was expected.
    pub message: String,
    /// A few words at the marked place; empty for none.
    pub label: String,
    /// What to do about it; empty for none.
    pub help: String,
}

impl Diagnostic {
    /// A fault with a message at a place.
    pub fn new(severity: Severity, code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self { severity, code, span, message: message.into(), label: String::new(), help: String::new() }
    }

    /// Adds words at the marked place.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// Adds a hint.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }
}

/// A list of faults in the order in which they were found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// Adds a fault.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.list.push(diagnostic);
    }

    /// Adds an error; the returned reference takes a label and help.
    pub fn error(&mut self, code: &'static str, span: Span, message: impl Into<String>) -> &mut Diagnostic {
        self.add(Severity::Error, code, span, message)
    }

    /// Adds a warning; the returned reference takes a label and help.
    pub fn warning(&mut self, code: &'static str, span: Span, message: impl Into<String>) -> &mut Diagnostic {
        self.add(Severity::Warning, code, span, message)
    }

    /// Adds advice; the returned reference takes a label and help.
    pub fn advice(&mut self, code: &'static str, span: Span, message: impl Into<String>) -> &mut Diagnostic {
        self.add(Severity::Advice, code, span, message)
    }

    fn add(
        &mut self,
        severity: Severity,
        code: &'static str,
        span: Span,
        message: impl Into<String>,
    ) -> &mut Diagnostic {
        self.list.push(Diagnostic::new(severity, code, span, message));
        self.list.last_mut().expect("just pushed")
    }

    /// True if anything forbids to render.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// Number of faults of that severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.list.iter().filter(|d| d.severity == severity).count()
    }

    /// True if there are so many that near names are no longer looked for: that takes time in the number of names.
    pub(crate) fn is_long(&self) -> bool {
        const LONG: usize = 200;
        self.list.len() >= LONG
    }

    /// True if there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The faults in the order in which they were found.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Puts the faults in the order of their places; those without a place come last.
    pub fn sort_by_place(&mut self) {
        self.list.sort_by_key(|d| (d.span.file, d.span.start));
    }

    /// Changes the place of every fault.
    pub(crate) fn for_each_span(&mut self, change: impl Fn(&mut Span)) {
        self.list.iter_mut().for_each(|d| change(&mut d.span));
    }

    /// Appends another list.
    pub fn extend(&mut self, other: Self) {
        self.list.extend(other.list);
    }
}
