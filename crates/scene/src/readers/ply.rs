//! PLY, the polygon files of Stanford \[Turk1994\].
//!
//! Read: text and binary in both orders of bytes; of the element `vertex` the position, normals, texture coordinates
//! and colours, by their usual names; of `face` the polygons `vertex_indices` or `vertex_index`, colours and
//! `texcoord`, the texture coordinates of its corners; `tristrips`. Properties may have any type. All else is passed
//! over. Colours are taken as sRGB and made linear: the two unsigned types below 32 bits reach from 0 to their
//! largest value, all others from 0 to 255 or to 1, whichever fits.

mod faces;
mod header;
mod rows;
mod scalar;
mod vertices;

use super::faults::Faults;
use crate::mesh::TriangleMesh;
use faces::Faces;
pub(super) use header::has_magic;
use header::{Element, Header};
use rows::Rows;
use vertices::Vertices;

/// Values of a block: as many rows are read at a time, one property after the other.
const BLOCK: usize = 256;

/// What the elements of that name hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Vertices,
    Faces,
    Strips,
    Other,
}

impl Kind {
    fn of(element: &Element<'_>) -> Self {
        match element.name.text {
            b"vertex" => Self::Vertices,
            b"face" => Self::Faces,
            b"tristrips" => Self::Strips,
            _ => Self::Other,
        }
    }
}

/// Reads a PLY file. `None` after errors.
pub(super) fn parse<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<TriangleMesh> {
    let header = header::parse(bytes, faults)?;
    let mut rows = Rows::new(bytes, header.end, header.encoding);
    let (vertices, faces) = elements(&header, &mut rows, faults)?;
    rows.finish(faults);
    Some(faces.into_mesh(vertices))
}

/// Reads the elements in the order of the file. Faces that stand before the vertices wait for them.
fn elements<'a>(
    header: &Header<'a>,
    rows: &mut Rows<'a>,
    faults: &mut Faults<'a>,
) -> Option<(Vertices, Faces)> {
    let (mut vertices, mut faces) = (None, Faces::default());
    let mut waiting = Vec::new();
    for element in &header.elements {
        match (Kind::of(element), &vertices) {
            (Kind::Vertices, _) => vertices = Some(Vertices::read(element, rows, faults)?),
            (Kind::Faces | Kind::Strips, Some(vertices)) => faces.read(element, rows, vertices, faults)?,
            (kind, _) => {
                if kind != Kind::Other {
                    waiting.push((element, rows.offset()));
                }
                rows.skip(element, faults)?;
            }
        }
    }
    let Some(vertices) = vertices else {
        let at = header.elements.first().map_or(faults.end(), |e| e.name);
        let message = "found no element `vertex`, expected one with the properties x, y and z";
        faults.error("ply::vertex", at, message, "without vertices there is no mesh");
        return None;
    };
    let end = rows.offset();
    for (element, at) in waiting {
        rows.seek(at);
        faces.read(element, rows, &vertices, faults)?;
    }
    rows.seek(end);
    Some((vertices, faces))
}
