//! Places in source files.

use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Bytes of a long line between two marks.
const MARK_STEP: usize = 512;

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
    /// Made when a place is first asked for.
    marks: OnceLock<Arc<[Mark]>>,
}

/// A byte of a text whose line and column are known: every beginning of a line, and within long lines one about
/// every [`MARK_STEP`] bytes, so that a place is found in the same time wherever it is.
#[derive(Clone, Copy, Debug)]
struct Mark {
    at: usize,
    line: u32,
    column: u32,
}

impl SourceFile {
    fn marks(&self) -> &[Mark] {
        self.marks.get_or_init(|| {
            let mut place = Mark { at: 0, line: self.first_line, column: self.first_column };
            let mut marks = vec![place];
            let mut last = 0;
            for (at, c) in self.text.char_indices() {
                if at - last >= MARK_STEP {
                    marks.push(Mark { at, ..place });
                    last = at;
                }
                place.column += 1;
                if c == '\n' {
                    place = Mark { at: at + 1, line: place.line + 1, column: 1 };
                    marks.push(place);
                    last = at + 1;
                }
            }
            marks.into()
        })
    }

    /// The part of the text that a drawing of the place `at` may show, a few lines or, of long lines, a few
    /// thousand bytes; and the offset at which it begins.
    pub(crate) fn around(&self, at: usize) -> (Self, usize) {
        const LINES: usize = 8;
        const BYTES: usize = 4096;
        let text = &*self.text;
        let at = text.floor_char_boundary(at.min(text.len()));
        let from = text.floor_char_boundary(at.saturating_sub(BYTES));
        let to = text.floor_char_boundary((at + BYTES).min(text.len()));
        let start = text[from..at].rmatch_indices('\n').nth(LINES).map_or(from, |(i, _)| from + i + 1);
        let end = text[at..to].match_indices('\n').nth(LINES).map_or(to, |(i, _)| at + i + 1);
        let Location { line, column, .. } = self.locate(start);
        let part = Self {
            path: self.path.clone(),
            name: self.name.clone(),
            text: text[start..end].into(),
            first_line: line,
            first_column: column,
            marks: OnceLock::new(),
        };
        (part, start)
    }

    /// Line and column of a byte of the text; places behind the end or inside a character are moved back.
    pub fn locate(&self, at: usize) -> Location<'_> {
        let at = self.text.floor_char_boundary(at.min(self.text.len()));
        let marks = self.marks();
        let mark = marks[marks.partition_point(|m| m.at <= at) - 1];
        let column = mark.column + self.text[mark.at..at].chars().count() as u32;
        Location { name: &self.name, line: mark.line, column }
    }
}

/// The texts that spans point into.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// Number of the first file: not 0 in a list that will be appended to another one.
    first: u32,
    files: Vec<SourceFile>,
}

/// How the numbers of files change when one list of texts is appended to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Renumbering {
    from: u32,
    by: u32,
}

impl Renumbering {
    /// The span in the joined list. Files that were in the other list from the beginning keep their numbers.
    pub fn apply(self, span: &mut Span) {
        if span.is_some() && span.file.0 >= self.from {
            span.file.0 += self.by;
        }
    }
}

impl Sources {
    /// An empty list whose numbers go on from those of this one: for texts that are found at the same time as others.
    pub(crate) fn branch(&self) -> Self {
        Self { first: self.next(), files: Vec::new() }
    }

    /// Appends what a branch of this list has got; texts may have been added to this one since.
    pub(crate) fn append(&mut self, branch: Self) -> Renumbering {
        let moved = Renumbering { from: branch.first, by: self.next() - branch.first };
        self.files.extend(branch.files);
        moved
    }

    fn next(&self) -> u32 {
        let count = u32::try_from(self.files.len()).ok().and_then(|n| n.checked_add(self.first));
        count.expect("fewer than 2^32 source files")
    }

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
        let id = FileId(self.next());
        let (path, name, text) = (path.to_owned(), name.into(), text.into());
        self.files.push(SourceFile { path, name, text, first_line, first_column, marks: OnceLock::new() });
        id
    }

    /// The file, unless the id is that of [`Span::NONE`].
    pub fn get(&self, id: FileId) -> Option<&SourceFile> {
        self.files.get(id.0.checked_sub(self.first)? as usize)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Line and column by counting from the start.
    fn counted(text: &str, first: (u32, u32), at: usize) -> (u32, u32) {
        let before = &text[..text.floor_char_boundary(at.min(text.len()))];
        let line = before.matches('\n').count() as u32;
        let last = before.rsplit('\n').next().unwrap_or("").chars().count() as u32;
        (first.0 + line, last + if line == 0 { first.1 } else { 1 })
    }

    #[test]
    fn every_place_is_that_which_counting_gives() {
        let long = "é".repeat(3 * MARK_STEP);
        let texts = ["", "\n", "a\n\nbc\r\nd", "é\nöü\n", &long, &format!("{long}\n{long}x\n{long}")];
        for text in texts {
            let mut sources = Sources::default();
            let id = sources.add_excerpt_at(Path::new(""), "a", text, 7, 50);
            let file = sources.get(id).unwrap();
            for at in 0..text.len() + 3 {
                let found = file.locate(at);
                assert_eq!((found.line, found.column), counted(text, (7, 50), at), "{at}");
                let (part, start) = file.around(at);
                assert!(part.text.len() <= 2 * 4096 + 8, "{}", part.text.len());
                let again = part.locate(at.min(text.len()) - start);
                assert_eq!((again.line, again.column), (found.line, found.column), "{at}");
            }
        }
    }

    #[test]
    fn branches_are_joined_with_their_places() {
        let mut all = Sources::default();
        let place = |file| Span { file, start: 0, len: 1 };
        let scene = place(all.add(Path::new(""), "scene", "s"));
        let mut branches = [all.branch(), all.branch()];
        let own = ["a", "b"].map(|name| {
            let branch = &mut branches[usize::from(name == "b")];
            let spans = [1, 2].map(|_| place(branch.add(Path::new(""), name, name)));
            assert_eq!(branch.locate(spans[1]).unwrap().name, name);
            assert!(branch.locate(scene).is_none());
            spans
        });
        for (branch, (name, spans)) in branches.into_iter().zip(["a", "b"].iter().zip(own)) {
            let moved = all.append(branch);
            for mut span in spans {
                moved.apply(&mut span);
                assert_eq!(&all.locate(span).unwrap().name, name);
            }
            for (mut kept, file) in [(scene, scene.file), (Span::NONE, Span::NONE.file)] {
                moved.apply(&mut kept);
                assert_eq!(kept.file, file);
            }
        }
        assert_eq!(all.iter().count(), 5);
    }

    #[test]
    fn many_places_of_a_large_text_are_found_quickly() {
        // Counting from the start would read 10^12 bytes.
        let count = 200_000;
        for text in ["radius = 1\n".repeat(count), "radius = 1,".repeat(count)] {
            let mut sources = Sources::default();
            let id = sources.add(Path::new(""), "a", text.as_str());
            let begin = std::time::Instant::now();
            let at = |i: usize| sources.locate(Span { file: id, start: 11 * i as u32, len: 1 }).unwrap();
            let sum: u64 = (0..count).map(|i| u64::from(at(i).line) + u64::from(at(i).column)).sum();
            assert!(sum > count as u64 * count as u64 / 2);
            assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
        }
    }
}
