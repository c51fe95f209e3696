//! STL as text.

use super::{HEADER, Triangles};
use crate::mesh::TriangleMesh;
use crate::readers::faults::Faults;
use crate::readers::lexer::{Lexer, Number, Token, number};
use penombre_math::Vec3;

const FACET: &str = "a triangle is `facet normal x y z`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`; \
                     all of them stand between `solid` and `endsolid`";

/// True if a file that is not binary by its length is text. Where the number of triangles of a binary file stands, text
/// has letters: they would be 150 million triangles. A few control characters are damage; text that begins with
/// `solid` may have more.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let controls =
        |bytes: &[u8]| bytes.iter().filter(|b| b.is_ascii_control() && !matches!(**b, 9..=13)).count();
    let head = &bytes[..bytes.len().min(HEADER)];
    let has_solid = Lexer::new(bytes, false).word().is_some_and(|w| is(w, "solid"));
    let has_count = bytes.get(HEADER - 4..HEADER).is_some_and(|count| controls(count) > 0);
    let is_clean = !bytes[..bytes.len().min(512)].contains(&0);
    has_solid && (is_clean || !has_count) || !has_count && controls(head) * 20 <= head.len()
}

fn is(word: Token<'_>, name: &str) -> bool {
    word.text.eq_ignore_ascii_case(name.as_bytes())
}

/// Reads one or more solids.
pub(super) fn parse<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<TriangleMesh> {
    // A triangle of text takes more than 64 bytes.
    let soup = Triangles::with_room(bytes.len() / 256);
    let mut reader = Reader { lexer: Lexer::new(bytes, false), faults, soup };
    reader.first_solid()?;
    while !reader.faults.is_full() && reader.statement() {}
    let Reader { faults, soup, .. } = reader;
    if faults.failed() {
        return None;
    }
    Some(soup.finish(faults))
}

struct Reader<'a, 'f> {
    lexer: Lexer<'a>,
    faults: &'f mut Faults<'a>,
    soup: Triangles<'a>,
}

impl<'a> Reader<'a, '_> {
    /// Reads the first line; `None` after an error.
    fn first_solid(&mut self) -> Option<()> {
        match self.lexer.word() {
            Some(word) if is(word, "solid") => {
                self.name();
                Some(())
            }
            Some(word) => {
                let message = format!("found text that begins with `{}`, expected `solid`", word.shortened());
                self.faults.error("stl::statement", word, message, super::HELP);
                None
            }
            None => {
                self.unexpected(None, "`solid`");
                None
            }
        }
    }

    /// Reads a facet or the end of a solid. False at the end of the file.
    fn statement(&mut self) -> bool {
        match self.lexer.word() {
            Some(word) if is(word, "facet") => {
                if self.facet(word).is_none() {
                    self.go_on();
                }
                true
            }
            Some(word) if is(word, "endsolid") => {
                self.name();
                self.next_solid()
            }
            Some(word) => {
                self.unexpected(Some(word), "`facet` or `endsolid`");
                if is(word, "solid") {
                    self.name();
                } else {
                    self.go_on();
                }
                true
            }
            None => {
                self.unexpected(None, "`facet` or `endsolid`");
                false
            }
        }
    }

    /// Reads the `solid` behind an `endsolid`. False at the end of the file.
    fn next_solid(&mut self) -> bool {
        let Some(word) = self.lexer.word() else { return false };
        if !is(word, "solid") {
            self.unexpected(Some(word), "`solid` or the end of the file");
            return false;
        }
        self.name();
        true
    }

    /// Passes over the name of a solid: the rest of the line, or what stands before `facet normal` and a number.
    fn name(&mut self) {
        loop {
            let here = self.lexer.clone();
            let Some(word) = self.lexer.token() else { return };
            let mut ahead = self.lexer.clone();
            if is(word, "facet")
                && ahead.token().is_some_and(|w| is(w, "normal"))
                && ahead.token().is_some_and(|w| number(w.text) != Number::None)
            {
                self.lexer = here;
                return;
            }
        }
    }

    /// Goes to the next statement behind a fault.
    fn go_on(&mut self) {
        loop {
            let here = self.lexer.clone();
            match self.lexer.word() {
                Some(w) if ["facet", "endsolid", "solid"].iter().all(|name| !is(w, name)) => {}
                _ => {
                    self.lexer = here;
                    return;
                }
            }
        }
    }

    /// An error at a word, or at the end of the file.
    fn unexpected(&mut self, found: Option<Token<'a>>, expected: &str) {
        if let Some(word) = found {
            let message = format!("found `{}`, expected {expected}", word.shortened());
            self.faults.error("stl::statement", word, message, FACET);
        } else if !self.faults.failed() {
            let message = format!("found the end of the file, expected {expected}");
            let end = self.faults.end();
            self.faults.error("stl::truncated", end, message, "was the file cut?");
        }
    }

    /// Reads a word that must be there; `None` after an error, and then the word is still to be read.
    fn expect(&mut self, name: &str, expected: &str) -> Option<Token<'a>> {
        let here = self.lexer.clone();
        let found = self.lexer.word();
        if found.is_some_and(|word| is(word, name)) {
            return found;
        }
        self.lexer = here;
        self.unexpected(found, expected);
        None
    }

    /// Reads what stands behind `facet`; `None` after an error.
    fn facet(&mut self, start: Token<'a>) -> Option<()> {
        let word = self.expect("normal", "`normal`")?;
        // It says nothing that the corners do not.
        let index = self.soup.mesh.indices.len();
        if !self.numbers(word, "the normal")?.is_finite() {
            self.soup.normals.add(word, index);
        }
        self.expect("outer", "`outer loop`")?;
        self.expect("loop", "`outer loop`")?;
        let mut corners = [Vec3::ZERO; 3];
        for corner in &mut corners {
            let word = self.expect("vertex", "`vertex`: a facet has three")?;
            *corner = self.numbers(word, "the vertex")?;
        }
        self.expect("endloop", "`endloop`")?;
        self.expect("endfacet", "`endfacet`")?;
        self.soup.add(corners, index, start);
        Some(())
    }

    /// Reads three numbers of a line; those that are not finite become NaN. `None` after an error.
    fn numbers(&mut self, word: Token<'a>, what: &str) -> Option<Vec3> {
        let mut values = [0.0; 3];
        for (found, value) in values.iter_mut().enumerate() {
            let Some(text) = self.lexer.token() else {
                let message = format!("{what}: found {found} numbers, expected 3: x y z");
                self.faults.error("stl::vertex", word, message, FACET);
                return None;
            };
            match number(text.text) {
                Number::Finite(v) => *value = v,
                Number::NotFinite => *value = f32::NAN,
                fault => {
                    self.faults.bad_number("stl::number", text, fault);
                    return None;
                }
            }
        }
        Some(Vec3::from_array(values))
    }
}
