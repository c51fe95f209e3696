//! Places in source files.

use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Names a file of a [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

/// A range of bytes of a source file. All spans compare equal, so that descriptions are compared by what they
/// say and not by where they say it.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// First byte, counted in the text that [`Sources`] holds for the file.
    pub start: u32,
    /// Number of bytes.
    pub len: u32,
}

impl PartialEq for Span {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
impl Eq for Span {}
impl Hash for Span {
    fn hash<H: Hasher>(&self, _: &mut H) {}
}

impl Default for Span {
    fn default() -> Self {
        Self::NONE
    }
}

impl Span {
    /// No place: the thing was made by a program.
    pub const NONE: Self = Self { file: FileId(u32::MAX), start: 0, len: 0 };

    /// True if this names a place in a file.
    pub fn is_some(&self) -> bool {
        self.file != Self::NONE.file
    }
}

/// One source text.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Where it was read from; relative paths in it are resolved against this file's folder. Empty for texts
    /// that are no files (`--set` arguments, built-ins).
    pub path: PathBuf,
    /// How messages call it.
    pub name: String,
    /// The text, or for big files an excerpt around the faults.
    pub text: Arc<str>,
    /// Line number (from 1) of the first line of `text` in the file: above 1 for excerpts.
    pub first_line: u32,
    /// Column (in characters, from 1) of the first character of `text` in its line: above 1 for excerpts that leave
    /// out the beginning of a long line.
    pub first_column: u32,
}

impl SourceFile {
    /// Line and column of a byte of the text; places behind the end or inside a character are moved back.
    pub fn locate(&self, at: usize) -> Location<'_> {
        let before = &self.text[..self.text.floor_char_boundary(at.min(self.text.len()))];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = self.first_line + before.bytes().filter(|b| *b == b'\n').count() as u32;
        let first_column = if line_start == 0 { self.first_column } else { 1 };
        let column = first_column + before[line_start..].chars().count() as u32;
        Location { name: &self.name, line, column }
    }
}

/// The texts that spans point into.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
}

impl Sources {
    /// Adds a text and names it.
    pub fn add(&mut self, path: &Path, name: impl Into<String>, text: impl Into<Arc<str>>) -> FileId {
        self.add_excerpt(path, name, text, 1)
    }

    /// Adds a part of a file that begins at line `first_line` (from 1).
    pub fn add_excerpt(
        &mut self,
        path: &Path,
        name: impl Into<String>,
        text: impl Into<Arc<str>>,
        first_line: u32,
    ) -> FileId {
        self.add_excerpt_at(path, name, text, first_line, 1)
    }

    /// Adds a part of a file that begins at line `first_line` and column `first_column` (both from 1).
    pub fn add_excerpt_at(
        &mut self,
        path: &Path,
        name: impl Into<String>,
        text: impl Into<Arc<str>>,
        first_line: u32,
        first_column: u32,
    ) -> FileId {
        let id = FileId(u32::try_from(self.files.len()).expect("fewer than 2^32 source files"));
        let (path, name, text) = (path.to_owned(), name.into(), text.into());
        self.files.push(SourceFile { path, name, text, first_line, first_column });
        id
    }

    /// The file, unless the id is that of [`Span::NONE`].
    pub fn get(&self, id: FileId) -> Option<&SourceFile> {
        self.files.get(id.0 as usize)
    }

    /// All files in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = &SourceFile> {
        self.files.iter()
    }

    /// Line and column of the start of a span, with the file's name.
    pub fn locate(&self, span: Span) -> Option<Location<'_>> {
        Some(self.get(span.file)?.locate(span.start as usize))
    }
}

/// A place as people name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Location<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}
