//! STL, the files of stereolithography \[Burns1993\], text and binary.
//!
//! A file with the length that its number of triangles asks for is binary, whatever its first word. Corners at one
//! position become one vertex, so that creases are found as in other formats; the normals of the file say nothing
//! more than the order of the corners and are not used. Text must have all words of the format, in upper or lower
//! case. Colours of binary files: 15 bits for each triangle, in the order of VisCAM and SolidView, or in that of
//! Materialise Magics if the header says `COLOR=`; taken as sRGB.

mod text;
mod weld;

use super::MeshWeight;
use super::encoding;
use super::faults::{Faults, Tally};
use super::lexer::Token;
use crate::mesh::TriangleMesh;
use penombre_math::Vec3;
use penombre_math::color::srgb_decode;
use weld::Weld;

/// Bytes before the first triangle: a text, then the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle: a normal, three corners, 16 bits that may be a colour.
const RECORD: usize = 50;
const HELP: &str = "a binary STL file has 80 bytes of text, the number of triangles in 4 bytes, then 50 bytes for each; one in text begins with `solid`";

/// Reads an STL file. `None` after errors.
pub(super) fn parse<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<TriangleMesh> {
    if bytes.is_empty() {
        let end = faults.end();
        faults.error("stl::empty", end, "found an empty file, expected triangles", HELP);
        return None;
    }
    if announced(bytes).is_some_and(|n| n == records(bytes)) {
        return binary(bytes, faults);
    }
    if encoding::is_refused(bytes, faults) {
        return None;
    }
    if text::is_text(bytes) { text::parse(bytes, faults) } else { binary(bytes, faults) }
}

/// The number of triangles that the header of a binary file announces.
fn announced(bytes: &[u8]) -> Option<f64> {
    let count = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    Some(f64::from(u32::from_le_bytes(count)))
}

/// The number of triangles that a binary file has room for.
fn records(bytes: &[u8]) -> f64 {
    (bytes.len() - HEADER) as f64 / RECORD as f64
}

/// The mesh of a binary file of that length, which begins with `head`; `None` for text.
pub(super) fn weigh(head: &[u8], length: u64) -> Option<MeshWeight> {
    let room = length.saturating_sub(HEADER as u64) / RECORD as u64;
    let announced = announced(head)?;
    if announced != room as f64 && text::is_text(head) {
        return None;
    }
    // When equal positions are joined, a closed surface has half as many as triangles; twice that is allowed for.
    let triangles = if announced > room as f64 { 0 } else { announced as u64 };
    Some(MeshWeight {
        positions: triangles,
        triangles,
        bytes: triangles.saturating_mul(24),
        ..MeshWeight::default()
    })
}

fn binary<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<TriangleMesh> {
    let start = Token { text: &bytes[..0], at: 0 };
    let length = bytes.len();
    let Some(count) = announced(bytes) else {
        let message = format!("found {length} bytes, expected `solid` or a binary header of {HEADER}");
        faults.error("stl::header", start, message, HELP);
        return None;
    };
    if count > records(bytes) {
        let expected = count * RECORD as f64 + HEADER as f64;
        let message = format!(
            "{count} triangles are announced at byte 80: expected a file of {expected} bytes, found {length}"
        );
        faults.error("stl::truncated", start, message, HELP);
        return None;
    }
    let count = count as usize;
    let end = HEADER + count * RECORD;
    if length > end {
        let message = format!(
            "{} bytes follow from byte {end} on, behind the {count} triangles that the header announces",
            length - end
        );
        faults.warning("stl::trailing", start, message, "the number of triangles may be too small");
    }
    let mut soup = Triangles::with_room(count);
    soup.mesh.indices.reserve_exact(count);
    let records = bytes[HEADER..end].chunks_exact(RECORD);
    let colors = Colors::of(&bytes[..HEADER - 4], records.clone().map(attribute));
    for (i, record) in records.enumerate() {
        let [normal, corners @ ..] = [0, 12, 24, 36].map(|at| vector(record, at));
        if !normal.is_finite() {
            soup.normals.add(start, i);
        }
        if soup.add(corners, i, start)
            && let Some(colors) = colors
        {
            soup.mesh.face_colors.push(colors.decode(attribute(record)));
        }
    }
    let place = |row: usize| format!("triangle {row}, at byte {}, ", HEADER + row * RECORD);
    soup.broken.place = soup.broken.row.map(place);
    soup.normals.place = soup.normals.row.map(place);
    Some(soup.finish(faults))
}

fn vector(record: &[u8], at: usize) -> Vec3 {
    let float = |k| f32::from_le_bytes([record[k], record[k + 1], record[k + 2], record[k + 3]]);
    Vec3::new(float(at), float(at + 4), float(at + 8))
}

fn attribute(record: &[u8]) -> u16 {
    u16::from_le_bytes([record[RECORD - 2], record[RECORD - 1]])
}

/// Triangles in which something is not finite.
#[derive(Default)]
struct Broken<'a> {
    tally: Tally<'a>,
    /// Index of the first one.
    row: Option<usize>,
    /// What messages call it, with a blank behind; `None`: a triangle at a place of the text.
    place: Option<String>,
}

impl<'a> Broken<'a> {
    fn add(&mut self, at: Token<'a>, index: usize) {
        self.tally.add(at);
        self.row.get_or_insert(index);
    }

    fn tell(&self, code: &'static str, what: &str, help: &str, faults: &mut Faults<'a>) {
        let message = format!("{}{what}", self.place.as_deref().unwrap_or("a triangle "));
        faults.tally(code, &self.tally, &message, help);
    }
}

/// Triangles on their way to a mesh.
struct Triangles<'a> {
    broken: Broken<'a>,
    normals: Broken<'a>,
    weld: Weld,
    mesh: TriangleMesh,
}

impl<'a> Triangles<'a> {
    fn with_room(triangles: usize) -> Self {
        let (broken, normals) = (Broken::default(), Broken::default());
        Self { broken, normals, weld: Weld::with_room(triangles), mesh: TriangleMesh::default() }
    }

    /// Adds a triangle; false if a corner is not finite.
    fn add(&mut self, corners: [Vec3; 3], index: usize, at: Token<'a>) -> bool {
        if !corners.iter().all(|c| c.is_finite()) {
            self.broken.add(at, index);
            return false;
        }
        let triangle = corners.map(|c| self.weld.index(c, &mut self.mesh.positions));
        self.mesh.indices.push(triangle);
        true
    }

    fn finish(mut self, faults: &mut Faults<'a>) -> TriangleMesh {
        let what = "has a corner that is not a finite point: such triangles are left out";
        self.broken.tell("mesh::not-finite", what, "expected three finite numbers for each corner", faults);
        let what = "has a normal that is not finite: normals of STL files are not used";
        self.normals.tell("stl::normal", what, "expected three finite numbers for each normal", faults);
        self.mesh.positions.shrink_to_fit();
        self.mesh
    }
}

/// How the 16 bits of a triangle tell its colour.
#[derive(Clone, Copy)]
enum Colors {
    /// Blue in the lowest bits; the highest bit says that there is a colour.
    VisCam,
    /// Red in the lowest bits; the highest bit says that the triangle has the colour of the whole.
    Magics([f32; 3]),
    /// All triangles have the colour of the whole.
    Whole([f32; 3]),
}

impl Colors {
    /// `None` if no triangle has a colour.
    fn of(header: &[u8], mut attributes: impl Iterator<Item = u16>) -> Option<Self> {
        const KEY: &[u8] = b"COLOR=";
        let at = header.windows(KEY.len() + 4).position(|w| w.starts_with(KEY));
        if let Some(at) = at {
            let whole = [0, 1, 2].map(|i| srgb_decode(f32::from(header[at + KEY.len() + i]) / 255.0));
            // Programs that know no colours of triangles leave all bits zero, which would be black.
            let is_plain = attributes.all(|a| a == 0);
            return Some(if is_plain { Self::Whole(whole) } else { Self::Magics(whole) });
        }
        attributes.any(|a| a & 0x8000 != 0).then_some(Self::VisCam)
    }

    /// A triangle's colour, linear Rec. 709. White, which changes nothing, if it has none.
    fn decode(self, bits: u16) -> [f32; 3] {
        let part = |shift: u16| srgb_decode(f32::from((bits >> shift) & 31) / 31.0);
        match (self, bits & 0x8000 != 0) {
            (Self::VisCam, true) => [10, 5, 0].map(part),
            (Self::VisCam, false) => [1.0; 3],
            (Self::Magics(whole), true) | (Self::Whole(whole), _) => whole,
            (Self::Magics(_), false) => [0, 5, 10].map(part),
        }
    }
}
