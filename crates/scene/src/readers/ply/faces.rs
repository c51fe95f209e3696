//! The elements `face` and `tristrips`.

use super::header::Element;
use super::rows::{CHANNELS, Place, Row, RowTally, Rows, Use};
use super::scalar::{Scalar, narrow};
use super::vertices::{Block, Broken, COLOR, ODD_COLOR, RawColors, Vertices, WHITE, channel};
use super::{BLOCK, Kind};
use crate::mesh::TriangleMesh;
use crate::readers::faults::Faults;
use crate::readers::polygon::{Cut, Triangulator};
use crate::readers::soup::NONE;
use penombre_math::{Vec2, Vec3};

const HELP: &str =
    "a face has a list `vertex_indices`: the number of its corners, then their vertices, counted from 0";

/// The triangles of a file.
#[derive(Default)]
pub(super) struct Faces {
    indices: Vec<[u32; 3]>,
    uvs: Vec<Vec2>,
    /// As the triangles if `uvs` is not empty, but for those at the end that have none.
    uv_indices: Vec<[u32; 3]>,
    colors: RawColors,
    cutter: Cutter,
}

/// Cuts polygons; keeps its memory between them.
#[derive(Default)]
struct Cutter {
    triangulator: Triangulator,
    corners: Vec<u32>,
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// What the properties of an element are read for.
struct Layout {
    uses: Vec<Use>,
    colors: Option<[(Scalar, usize); 3]>,
    /// Offset of the list of indices in a row, the types of its length and of its values; only if it is the only list,
    /// with the length of a row that is a triangle.
    triangles: Option<(usize, Scalar, Scalar, usize)>,
    has_uvs: bool,
}

/// The bytes that a list of three takes more than an empty one, and where what stands behind the list begins.
fn shift(property_offset: usize, list: Option<(usize, usize)>) -> usize {
    match list {
        Some((at, more)) if property_offset > at => property_offset + more,
        _ => property_offset,
    }
}

impl Layout {
    /// `None` after an error.
    fn of<'a>(element: &Element<'a>, faults: &mut Faults<'a>) -> Option<Self> {
        let mut found: [Option<(Scalar, usize)>; CHANNELS] = [None; CHANNELS];
        let (mut uses, mut offset, mut lists) = (Vec::new(), 0, 0);
        let mut indices = None;
        for property in &element.properties {
            let mut usage = Use::Nothing;
            if let Some(count) = property.list {
                lists += 1;
                match property.name.text {
                    b"vertex_indices" | b"vertex_index" if indices.is_none() => {
                        if !property.scalar.is_whole() {
                            let message =
                                "found fractions for the numbers of vertices, expected a list of int or uint";
                            faults.error("ply::type", property.name, message, HELP);
                            return None;
                        }
                        indices = Some((offset, count, property.scalar));
                        usage = Use::Indices;
                    }
                    b"texcoord" if !uses.contains(&Use::Uvs) => usage = Use::Uvs,
                    _ => {}
                }
            } else if let Some(c) = channel(property, COLOR[0]..CHANNELS).filter(|c| found[*c].is_none()) {
                found[c] = Some((property.scalar, offset));
                usage = Use::Channel(c);
            }
            uses.push(usage);
            offset += property.list.unwrap_or(property.scalar).size();
        }
        let Some((at, count, scalar)) = indices else {
            let message =
                format!("found no list `vertex_indices` in `{}`, expected one", element.name.lossy());
            faults.error("ply::face", element.name, message, HELP);
            return None;
        };
        let more = 3 * scalar.size();
        let list = (lists == 1).then_some((at, more));
        let colors = match COLOR.map(|c| found[c]) {
            [Some(r), Some(g), Some(b)] => Some([r, g, b].map(|(s, o)| (s, shift(o, list)))),
            _ => None,
        };
        let triangles = list.map(|_| (at, count, scalar, offset + more));
        let has_uvs = uses.contains(&Use::Uvs);
        Some(Self { uses, colors, triangles, has_uvs })
    }
}

/// An element being read.
struct Reading<'r, 'a> {
    element: &'r Element<'a>,
    rows: &'r mut Rows<'a>,
    vertices: &'r Vertices,
    layout: Layout,
    thin: RowTally,
    tangled: RowTally,
    odd_colors: RowTally,
    odd_uvs: RowTally,
}

impl<'a> Reading<'_, 'a> {
    fn new<'r>(
        element: &'r Element<'a>,
        rows: &'r mut Rows<'a>,
        vertices: &'r Vertices,
        layout: Layout,
    ) -> Reading<'r, 'a> {
        let (thin, tangled) = (RowTally::default(), RowTally::default());
        let (odd_colors, odd_uvs) = (RowTally::default(), RowTally::default());
        Reading { element, rows, vertices, layout, thin, tangled, odd_colors, odd_uvs }
    }

    /// An error about a row.
    fn fault(&self, place: Place, code: &'static str, what: &str, faults: &mut Faults<'a>) -> Option<()> {
        let (at, row) = self.rows.place(self.element, place);
        faults.error(code, at, format!("{row}: {what}"), HELP);
        None
    }

    fn wild_index(&self, place: Place, index: f64, faults: &mut Faults<'a>) -> Option<()> {
        let what = match self.vertices.positions.len() {
            0 => format!("found vertex {index}, expected vertices: there are none"),
            n => format!("found vertex {index}, expected 0 to {}", n - 1),
        };
        self.fault(place, "ply::index", &what, faults)
    }

    /// An error if a corner is no finite point.
    fn check_finite(&self, place: Place, corners: &[u32], faults: &mut Faults<'a>) -> Option<()> {
        if self.vertices.broken.is_empty() {
            return Some(());
        }
        let broken = |c: &u32| {
            let found = self.vertices.broken.binary_search_by_key(c, |b| b.index).ok()?;
            Some(self.vertices.broken[found])
        };
        let Some(Broken { index, is_large }) = corners.iter().find_map(broken) else { return Some(()) };
        let what = if is_large {
            format!(
                "found vertex {index} with a position that is too large for a 32-bit float, expected numbers below 3.4e38"
            )
        } else {
            format!("found vertex {index} with a position that is not finite, expected three finite numbers")
        };
        self.fault(place, "ply::not-finite", &what, faults)
    }

    /// Tells what was left out or replaced.
    fn tell(&self, faults: &mut Faults<'a>) {
        let help = "cut it into triangles in the program that wrote the file";
        let tangled = "has very many corners and crosses or touches itself: it is left out";
        let uvs = "has texture coordinates that are not finite: taken as 0";
        for (tally, code, what, help) in [
            (&self.thin, "ply::thin-face", "has fewer than 3 corners and is left out", HELP),
            (&self.tangled, "mesh::large-polygon", tangled, help),
            (&self.odd_colors, "ply::color", ODD_COLOR, HELP),
            (&self.odd_uvs, "ply::uv", uvs, HELP),
        ] {
            tally.tell(self.rows, self.element, (code, what), help, faults);
        }
    }
}

impl Faces {
    /// Reads an element. `None` after errors.
    pub fn read<'a>(
        &mut self,
        element: &Element<'a>,
        rows: &mut Rows<'a>,
        vertices: &Vertices,
        faults: &mut Faults<'a>,
    ) -> Option<()> {
        if element.count == 0 {
            return Some(());
        }
        let layout = Layout::of(element, faults)?;
        rows.check_count(element, faults)?;
        self.pad(layout.has_uvs, layout.colors.is_some());
        let (first_color, longer_lines) = (self.colors.values.len(), rows.longer_lines());
        let mut reading = Reading::new(element, rows, vertices, layout);
        self.rows(&mut reading, faults)?;
        if reading.rows.longer_lines() > longer_lines {
            // Some programs write a list of colours of corners where the header says `red`, `green` and `blue`.
            self.colors.values[first_color..].fill(WHITE);
        }
        reading.tell(faults);
        Some(())
    }

    /// Gives triangles so far that have none texture coordinates, or the colour white, if the next ones have some.
    fn pad(&mut self, uvs: bool, colors: bool) {
        if uvs || !self.uv_indices.is_empty() {
            self.uv_indices.resize(self.indices.len(), [NONE; 3]);
        }
        if colors || !self.colors.values.is_empty() {
            self.colors.values.resize(self.indices.len(), WHITE);
        }
    }

    fn rows<'a>(&mut self, reading: &mut Reading<'_, 'a>, faults: &mut Faults<'a>) -> Option<()> {
        if let Some(colors) = reading.layout.colors {
            self.colors.types = Some(colors.map(|(scalar, _)| scalar));
        }
        let strips = Kind::of(reading.element) == Kind::Strips;
        let (mut row, mut index) = (Row::default(), 0);
        let count = reading.element.count;
        while index < count {
            if !strips {
                index += self.run(reading, index, faults)?;
            }
            if index == count {
                break;
            }
            let place = Place { row: index, at: reading.rows.offset() };
            reading.rows.row(reading.element, &reading.layout.uses, index, &mut row, faults)?;
            let before = self.indices.len();
            if strips {
                self.strip(reading, place, &row.indices, faults)?;
            } else {
                self.polygon(reading, place, &row, faults)?;
            }
            if reading.layout.colors.is_some() {
                let mut color = COLOR.map(|c| narrow(row.channels[c]));
                if !color.iter().all(|c| c.is_finite()) {
                    color = WHITE;
                    reading.odd_colors.add(place);
                }
                let added = self.indices.len() - before;
                self.colors.values.extend(std::iter::repeat_n(color, added));
            }
            index += 1;
        }
        Some(())
    }

    /// Reads the triangles that come next in a binary file, row by row of one length. Their number.
    fn run<'a>(
        &mut self,
        reading: &mut Reading<'_, 'a>,
        index: usize,
        faults: &mut Faults<'a>,
    ) -> Option<usize> {
        let (Some((bytes, big)), Some((at, count, scalar, stride))) =
            (reading.rows.binary(), reading.layout.triangles)
        else {
            return Some(0);
        };
        let most = (reading.element.count - index).min(bytes.len() / stride);
        let bytes = &bytes[..most * stride];
        let first = self.indices.len();
        self.indices.reserve(if index == 0 { most } else { 0 });
        let largest = scalar.triangles(bytes, (stride, at, count), big, &mut self.indices);
        let length = self.indices.len() - first;
        let limit = reading.vertices.positions.len();
        let start = reading.rows.offset();
        let place = |row: usize| Place { row: index + row, at: start + row * stride };
        if length > 0 && largest as usize >= limit {
            let is_wild = |t: &[u32; 3]| t.iter().any(|i| *i as usize >= limit);
            let row = self.indices[first..].iter().position(is_wild).unwrap_or(0);
            let values = bytes[row * stride + at + count.size()..].chunks_exact(scalar.size()).take(3);
            let mut values = values.map(|b| scalar.read(b, big));
            let wild = values.find(|v| *v < 0.0 || *v >= limit as f64).unwrap_or(f64::NAN);
            reading.wild_index(place(row), wild, faults)?;
        }
        if !reading.vertices.broken.is_empty() {
            for (row, triangle) in self.indices[first..].iter().enumerate() {
                reading.check_finite(place(row), triangle, faults)?;
            }
        }
        if let Some(colors) = reading.layout.colors {
            self.run_colors(colors, &bytes[..length * stride], (stride, big), &mut reading.odd_colors, place);
        }
        reading.rows.seek(start + length * stride);
        Some(length)
    }

    /// Reads the colours of rows of one length, `stride` bytes. `place`: of one of them.
    fn run_colors(
        &mut self,
        colors: [(Scalar, usize); 3],
        bytes: &[u8],
        (stride, big): (usize, bool),
        odd: &mut RowTally,
        place: impl Fn(usize) -> Place,
    ) {
        let mut block: Block = [[0.0; BLOCK]; CHANNELS];
        for (i, rows) in bytes.chunks(BLOCK * stride).enumerate() {
            let length = rows.len() / stride;
            for (channel, (scalar, offset)) in COLOR.into_iter().zip(colors) {
                scalar.column(&rows[offset..], stride, big, &mut block[channel][..length]);
            }
            self.colors.extend(&block, length, odd, |row| place(i * BLOCK + row));
        }
    }

    /// Takes a face of any number of corners.
    fn polygon<'a>(
        &mut self,
        reading: &mut Reading<'_, 'a>,
        place: Place,
        row: &Row,
        faults: &mut Faults<'a>,
    ) -> Option<()> {
        let Cutter { triangulator, corners, points, triangles } = &mut self.cutter;
        let positions = &reading.vertices.positions;
        if let Some(wild) = row.indices.iter().find(|i| !(0.0..positions.len() as f64).contains(*i)) {
            return reading.wild_index(place, *wild, faults);
        }
        let corners_found = row.indices.len();
        if corners_found < 3 {
            reading.thin.add(place);
            return Some(());
        }
        // Those with holes meet some of their vertices twice.
        if corners_found > 2 * positions.len() {
            let what = format!(
                "found {corners_found} corners, expected at most twice the {} vertices",
                positions.len()
            );
            return reading.fault(place, "ply::face", &what, faults);
        }
        corners.clear();
        corners.extend(row.indices.iter().map(|i| *i as u32));
        reading.check_finite(place, corners, faults)?;
        points.clear();
        points.extend(corners.iter().map(|i| positions[*i as usize]));
        triangles.clear();
        if triangulator.cut(points, triangles) == Cut::TooLarge {
            reading.tangled.add(place);
        }
        self.indices.extend(triangles.iter().map(|t| t.map(|i| corners[i as usize])));
        if reading.layout.has_uvs {
            let first = self.uvs.len() as u32;
            let own = row.uvs.len() == 2 * corners.len();
            self.uv_indices
                .extend(triangles.iter().map(|t| if own { t.map(|i| first + i) } else { [NONE; 3] }));
            if own {
                let pairs = row.uvs.chunks_exact(2).map(|p| Vec2::new(narrow(p[0]), narrow(p[1])));
                if pairs.clone().any(|uv| !uv.is_finite()) {
                    reading.odd_uvs.add(place);
                }
                self.uvs.extend(pairs.map(|uv| if uv.is_finite() { uv } else { Vec2::ZERO }));
            }
        }
        Some(())
    }

    /// Takes strips of triangles: each corner makes one with the two before it, every other one turned over; -1 ends
    /// a strip. Triangles with a corner twice only lead on to the next ones.
    fn strip<'a>(
        &mut self,
        reading: &Reading<'_, 'a>,
        place: Place,
        corners: &[f64],
        faults: &mut Faults<'a>,
    ) -> Option<()> {
        let limit = reading.vertices.positions.len() as f64;
        if let Some(wild) = corners.iter().find(|i| **i != -1.0 && !(0.0..limit).contains(*i)) {
            return reading.wild_index(place, *wild, faults);
        }
        for strip in corners.split(|i| *i == -1.0) {
            for (i, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]].map(|i| i as u32);
                if a == b || b == c || c == a {
                    continue;
                }
                let triangle = if i % 2 == 0 { [a, b, c] } else { [b, a, c] };
                reading.check_finite(place, &triangle, faults)?;
                self.indices.push(triangle);
            }
        }
        Some(())
    }

    /// The mesh of all triangles.
    pub fn into_mesh(mut self, vertices: Vertices) -> TriangleMesh {
        self.pad(false, false);
        let (normals, normal_indices) = normals_of(vertices.normals, &self.indices);
        let (uvs, uv_indices) = match self.uvs.is_empty() {
            true => (vertices.uvs, Vec::new()),
            false => (self.uvs, self.uv_indices),
        };
        TriangleMesh {
            positions: vertices.positions,
            normals,
            normal_indices,
            uvs,
            uv_indices,
            colors: vertices.colors.into_linear(),
            face_colors: self.colors.into_linear(),
            indices: self.indices,
            slots: Vec::new(),
        }
    }
}

/// The normals without those that are zero, which programs write for vertices that have none.
fn normals_of(normals: Vec<Vec3>, triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let is_zero = |n: &Vec3| *n == Vec3::ZERO;
    let zeros = normals.iter().filter(|n| is_zero(n)).count();
    if zeros == normals.len() {
        return (Vec::new(), Vec::new());
    }
    if zeros == 0 {
        return (normals, Vec::new());
    }
    let own = |i: u32| if is_zero(&normals[i as usize]) { NONE } else { i };
    let indices = triangles.iter().map(|t| t.map(own)).collect();
    (normals, indices)
}
