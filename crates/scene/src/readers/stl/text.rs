//! STL as text.

use super::{Broken, HELP, Triangles};
use crate::mesh::TriangleMesh;
use crate::readers::faults::Faults;
use crate::readers::lexer::{Lexer, Number, Token, number};
use crate::readers::stl::weld::Weld;
use penombre_math::Vec3;

const FACET: &str =
    "a triangle is `facet normal x y z`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`";

/// True if a file that is not binary by its length is text: it begins with `solid` and has no zero bytes where binary
/// files have some.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let mut lexer = Lexer::new(bytes, false);
    let head = &bytes[..bytes.len().min(512)];
    lexer.next_word_line()
        && lexer.token().is_some_and(|w| w.text.eq_ignore_ascii_case(b"solid"))
        && !head.contains(&0)
}

/// Reads one or more solids.
pub(super) fn parse<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<TriangleMesh> {
    let broken = Broken {
        message: "a corner of a triangle is not a finite point: such triangles are left out".to_owned(),
        ..Broken::default()
    };
    // A triangle of text takes more than 64 bytes.
    let soup = Triangles { broken, weld: Weld::with_room(bytes.len() / 256), mesh: TriangleMesh::default() };
    let lexer = Lexer::new(bytes, false);
    let mut reader = Reader { lexer, faults, soup, solid: false, facet: None };
    while let Some(word) = reader.word() {
        reader.statement(word);
        if reader.faults.is_full() {
            return None;
        }
    }
    reader.end();
    let Reader { faults, soup, .. } = reader;
    if faults.failed() {
        return None;
    }
    Some(soup.finish(faults))
}

struct Facet<'a> {
    at: Token<'a>,
    corners: [Vec3; 3],
    found: usize,
}

struct Reader<'a, 'f> {
    lexer: Lexer<'a>,
    faults: &'f mut Faults<'a>,
    soup: Triangles<'a>,
    /// True between `solid` and `endsolid`.
    solid: bool,
    facet: Option<Facet<'a>>,
}

impl<'a> Reader<'a, '_> {
    /// The next word, on this line or another.
    fn word(&mut self) -> Option<Token<'a>> {
        self.lexer.token().or_else(|| {
            self.lexer.next_line();
            if self.lexer.next_word_line() { self.lexer.token() } else { None }
        })
    }

    fn statement(&mut self, word: Token<'a>) {
        let is = |name: &str| word.text.eq_ignore_ascii_case(name.as_bytes());
        if is("vertex") {
            self.vertex(word);
        } else if is("facet") {
            if let Some(open) = self.facet.take() {
                self.fault(open.at, "found the next facet within this one, expected `endfacet`");
            }
            self.facet = Some(Facet { at: word, corners: [Vec3::ZERO; 3], found: 0 });
            // The normal says nothing that the corners do not.
            let ahead = self.lexer.clone();
            if self.lexer.token().is_some_and(|w| w.text.eq_ignore_ascii_case(b"normal")) {
                (0..3).for_each(|_| _ = self.lexer.token());
            } else {
                self.lexer = ahead;
            }
        } else if is("endfacet") {
            self.end_facet(word);
        } else if is("outer") || is("loop") || is("endloop") {
        } else if is("solid") || is("endsolid") || is("end") {
            if let Some(open) = self.facet.take() {
                self.fault(open.at, "found the end of the solid within this facet, expected `endfacet`");
            }
            self.solid = is("solid");
            // What follows is its name.
            self.lexer.next_line();
        } else {
            let message = format!("found `{}`, expected a statement of STL", word.shortened());
            self.fault(word, &message);
            self.lexer.next_line();
        }
    }

    fn fault(&mut self, at: Token<'a>, message: &str) {
        self.faults.error("stl::statement", at, message, FACET);
    }

    fn vertex(&mut self, word: Token<'a>) {
        let mut values = [0.0; 3];
        for (found, value) in values.iter_mut().enumerate() {
            let Some(text) = self.lexer.token() else {
                let message = format!("the vertex: found {found} numbers, expected 3: x y z");
                self.faults.error("stl::vertex", word, message, FACET);
                return;
            };
            match number(text.text) {
                Number::Finite(v) => *value = v,
                Number::NotFinite => *value = f32::NAN,
                fault => {
                    self.faults.bad_number("stl::number", text, fault);
                    self.lexer.next_line();
                    return;
                }
            }
        }
        let Some(facet) = &mut self.facet else {
            return self.fault(word, "found a vertex outside of a facet, expected `facet` before it");
        };
        if let Some(corner) = facet.corners.get_mut(facet.found) {
            *corner = Vec3::from_array(values);
        }
        facet.found += 1;
    }

    fn end_facet(&mut self, word: Token<'a>) {
        let Some(facet) = self.facet.take() else {
            return self.fault(word, "found `endfacet`, expected `facet` before it");
        };
        // Numbers that could not be read were reported.
        if facet.found != 3 && !self.faults.failed() {
            let message = format!("found {} vertices in the facet, expected 3", facet.found);
            return self.fault(facet.at, &message);
        }
        let index = self.soup.mesh.indices.len();
        self.soup.add(facet.corners, index, facet.at);
    }

    /// The end of the file.
    fn end(&mut self) {
        let end = self.faults.end();
        if let Some(open) = &self.facet {
            let message = format!(
                "found the end of the file in a facet with {} vertices, expected 3 and `endfacet`",
                open.found
            );
            self.faults.error("stl::truncated", end, message, HELP);
        } else if self.solid && !self.faults.failed() {
            let message = "the file ends without `endsolid`";
            self.faults.warning("stl::truncated", end, message, "was the file cut?");
        }
    }
}
