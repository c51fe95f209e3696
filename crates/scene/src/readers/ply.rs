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

use super::MeshWeight;
use super::faults::Faults;
use crate::diagnostic::Diagnostics;
use crate::mesh::TriangleMesh;
use crate::span::Sources;
use faces::Faces;
pub(super) use header::has_magic;
use header::{Element, Encoding, Header};
use rows::Rows;
use std::path::Path;
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

/// The mesh of a binary file of that length, which begins with `head`; `None` for text, and where the header is broken or
/// long.
pub(super) fn weigh(head: &[u8], length: u64) -> Option<MeshWeight> {
    let (mut sources, mut out) = (Sources::default(), Diagnostics::default());
    let header = header::parse(head, &mut Faults::new(head, Path::new(""), "", &mut sources, &mut out))?;
    if header.encoding == Encoding::Ascii {
        return None;
    }
    let mut left = length.saturating_sub(header.end as u64);
    let mut weight = MeshWeight::default();
    for (kind, element) in header.elements.iter().map(|e| (Kind::of(e), e)) {
        let (count, least) = (element.count as u64, element.least_bytes() as u64);
        let taken = count.saturating_mul(least);
        // Rows that the file has no room for are refused before they are read; those without properties hold nothing.
        let Some(rest) = left.checked_sub(taken) else { break };
        left = rest;
        if least == 0 {
            continue;
        }
        if kind == Kind::Vertices {
            // Beyond the position at most normals, texture coordinates and colours are kept.
            let others = element.properties.len().saturating_sub(3).min(8) as u64;
            weight.positions = count;
            weight.bytes = weight.bytes.saturating_add(count.saturating_mul(12 + 4 * others));
            weight.has_normals |= element.properties.iter().any(|p| p.name.text == b"nx");
        } else if let Some(list) = element.properties.iter().find(|p| p.list.is_some()) {
            // All the rest of the file as corners of its polygons or strips.
            let corners = rest / list.scalar.size() as u64;
            let triangles = corners.saturating_sub(count.saturating_mul(2));
            weight.triangles = weight.triangles.max(triangles);
            let colors = if element.properties.len() > 1 { 12 } else { 0 };
            weight.bytes = weight.bytes.saturating_add(triangles.saturating_mul(12 + colors));
            left = 0;
        }
    }
    Some(weight)
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
