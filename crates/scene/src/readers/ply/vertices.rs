//! The element `vertex`.

use super::BLOCK;
use super::header::{Element, Property};
use super::rows::{CHANNELS, Place, Row, RowTally, Rows, Use};
use super::scalar::{Scalar, narrow};
use crate::readers::colors::{ColorScale, linear};
use crate::readers::faults::Faults;
use penombre_math::color::srgb_decode;
use penombre_math::{Vec2, Vec3};

const HELP: &str =
    "vertices have the properties x, y and z, and perhaps nx ny nz, s t (or u v), red green blue";

/// The names of what is read, in the order of the channels.
const NAMES: [&[&str]; CHANNELS] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["s", "u", "texture_u", "texture_s"],
    &["t", "v", "texture_v", "texture_t"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
];
const POSITION: [usize; 3] = [0, 1, 2];
const NORMAL: [usize; 3] = [3, 4, 5];
const UV: [usize; 2] = [6, 7];
/// The channels of a colour; faces have only those.
pub(super) const COLOR: [usize; 3] = [8, 9, 10];

/// White, whatever the range of the colours.
pub(super) const WHITE: [f32; 3] = [f32::INFINITY; 3];
/// What is said of a row with a colour that is none.
pub(super) const ODD_COLOR: &str = "has a colour that is not finite: taken as white";

/// Values of some rows by channel.
pub(super) type Block = [[f32; BLOCK]; CHANNELS];

/// The channel of a property, of those that the element may have.
pub(super) fn channel(property: &Property<'_>, channels: std::ops::Range<usize>) -> Option<usize> {
    let named = |c: &usize| NAMES[*c].iter().any(|n| n.as_bytes() == property.name.text);
    if property.list.is_some() { None } else { channels.into_iter().find(named) }
}

/// Colours as a file has them, and their type.
#[derive(Debug, Default)]
pub(super) struct RawColors {
    pub values: Vec<[f32; 3]>,
    pub types: Option<[Scalar; 3]>,
}

impl RawColors {
    /// The colours of the rows of a block; those that are not finite are white. `place`: of a row of the block.
    pub fn extend(&mut self, block: &Block, rows: usize, odd: &mut RowTally, place: impl Fn(usize) -> Place) {
        let first = self.values.len();
        self.values.extend((0..rows).map(|i| COLOR.map(|c| block[c][i])));
        for (i, color) in self.values[first..].iter_mut().enumerate() {
            if !color.iter().all(|c| c.is_finite()) {
                *color = WHITE;
                odd.add(place(i));
            }
        }
    }

    /// The colours made linear.
    pub fn into_linear(mut self) -> Vec<[f32; 3]> {
        let largest = match self.types {
            Some([Scalar::U8, Scalar::U8, Scalar::U8]) => {
                let table: Vec<f32> = (0..=255u8).map(|v| srgb_decode(f32::from(v) / 255.0)).collect();
                let decode = |c: &mut [f32; 3]| *c = c.map(|v| table[usize::from(v as u8)]);
                self.values.iter_mut().for_each(decode);
                return self.values;
            }
            Some([Scalar::U16, Scalar::U16, Scalar::U16]) => 65535.0,
            _ => 1.0,
        };
        let mut scale = ColorScale::default();
        for color in &mut self.values {
            *color = color.map(|c| c / largest);
            if color.iter().all(|c| c.is_finite()) {
                scale.see(*color, color.iter().all(|c| c.fract() == 0.0));
            }
        }
        self.values.iter_mut().for_each(|c| *c = linear(*c, scale));
        self.values
    }
}

/// What the vertices have.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub positions: Vec<Vec3>,
    /// Unit vectors or zero; empty if there are none.
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub colors: RawColors,
    /// Positions that are not finite, by ascending index; those positions are zero.
    pub broken: Vec<Broken>,
    odd: Odd,
}

/// A position that is not finite.
#[derive(Clone, Copy, Debug)]
pub(super) struct Broken {
    pub index: u32,
    /// True if its numbers are finite, but too large for single precision.
    pub is_large: bool,
}

/// Rows with attributes that are not finite.
#[derive(Debug, Default)]
struct Odd {
    normals: RowTally,
    uvs: RowTally,
    colors: RowTally,
}

impl Odd {
    fn tell<'a>(&self, rows: &Rows<'a>, element: &Element<'a>, faults: &mut Faults<'a>) {
        let help = "expected finite numbers below 3.4e38";
        let what = ("ply::normal", "has a normal that is not finite: it has none");
        self.normals.tell(rows, element, what, help, faults);
        let what = ("ply::uv", "has texture coordinates that are not finite: taken as 0");
        self.uvs.tell(rows, element, what, help, faults);
        self.colors.tell(rows, element, ("ply::color", ODD_COLOR), help, faults);
    }
}

/// The channels that an element has, with the type and the offset in a row of each.
struct Layout {
    uses: Vec<Use>,
    channels: [Option<(Scalar, usize)>; CHANNELS],
}

impl Layout {
    /// The first property of a name counts.
    fn of(element: &Element<'_>) -> Self {
        let mut layout = Self { uses: Vec::new(), channels: [None; CHANNELS] };
        let mut offset = 0;
        for property in &element.properties {
            let found = channel(property, 0..CHANNELS).filter(|c| layout.channels[*c].is_none());
            if let Some(c) = found {
                layout.channels[c] = Some((property.scalar, offset));
            }
            layout.uses.push(found.map_or(Use::Nothing, Use::Channel));
            offset += property.scalar.size();
        }
        layout
    }

    fn has(&self, channels: &[usize]) -> bool {
        channels.iter().all(|c| self.channels[*c].is_some())
    }
}

impl Vertices {
    /// Reads the element. `None` after errors.
    pub fn read<'a>(element: &Element<'a>, rows: &mut Rows<'a>, faults: &mut Faults<'a>) -> Option<Self> {
        let layout = Layout::of(element);
        if let Some(missing) = POSITION.iter().find(|c| layout.channels[**c].is_none()) {
            let message =
                format!("found no property `{}` of vertices, expected x, y and z", NAMES[*missing][0]);
            faults.error("ply::vertex", element.name, message, HELP);
            return None;
        }
        rows.check_count(element, faults)?;
        if element.count >= u32::MAX as usize {
            let message = format!("the file has {} vertices, expected fewer than 2³²-1", element.count);
            faults.error("ply::count", element.name, message, "cut the mesh into several files");
            return None;
        }
        let mut vertices = Self::default();
        vertices.reserve(element.count, &layout);
        let mut block = [[0.0; BLOCK]; CHANNELS];
        let mut starts = [0; BLOCK];
        let mut row = Row::default();
        let mut begin = 0;
        while begin < element.count {
            let length = BLOCK.min(element.count - begin);
            match rows.binary().filter(|_| element.is_fixed()) {
                Some((bytes, big)) => {
                    let (stride, at) = (element.least_bytes(), rows.offset());
                    columns(&layout, bytes, stride, big, &mut block, length);
                    starts.iter_mut().enumerate().for_each(|(i, start)| *start = at + i * stride);
                    rows.seek(at + length * stride);
                }
                None => {
                    for index in begin..begin + length {
                        starts[index - begin] = rows.offset();
                        rows.row(element, &layout.uses, index, &mut row, faults)?;
                        for (column, value) in block.iter_mut().zip(row.channels) {
                            column[index - begin] = narrow(value);
                        }
                    }
                }
            }
            vertices.add(&layout, &block, length, &starts);
            begin += length;
        }
        vertices.odd.tell(rows, element, faults);
        Some(vertices)
    }

    /// Makes room; the count was held against the size of the file.
    fn reserve(&mut self, count: usize, layout: &Layout) {
        self.positions.reserve_exact(count);
        if layout.has(&NORMAL) {
            self.normals.reserve_exact(count);
        }
        if layout.has(&UV) {
            self.uvs.reserve_exact(count);
        }
        if layout.has(&COLOR) {
            self.colors.types = Some(COLOR.map(|c| layout.channels[c].map_or(Scalar::F32, |(s, _)| s)));
            self.colors.values.reserve_exact(count);
        }
    }

    /// Zeroes and notes the positions from `first` on, those of a block, that are not finite.
    fn take_out_broken(&mut self, layout: &Layout, block: &Block, first: usize) {
        for (i, position) in self.positions[first..].iter_mut().enumerate() {
            if !position.is_finite() {
                *position = Vec3::ZERO;
                // Doubles become infinite only if they are too large.
                let is_large = |c: usize| {
                    block[c][i].is_finite()
                        || block[c][i].is_infinite() && matches!(layout.channels[c], Some((Scalar::F64, _)))
                };
                let is_large = POSITION.into_iter().all(is_large);
                self.broken.push(Broken { index: (first + i) as u32, is_large });
            }
        }
    }

    /// Takes the rows of a block. `starts`: their offsets.
    fn add(&mut self, layout: &Layout, block: &Block, rows: usize, starts: &[usize; BLOCK]) {
        let vector = |channels: [usize; 3], i: usize| Vec3::from_array(channels.map(|c| block[c][i]));
        let first = self.positions.len();
        let place = |i: usize| Place { row: first + i, at: starts[i] };
        self.positions.extend((0..rows).map(|i| vector(POSITION, i)));
        self.take_out_broken(layout, block, first);
        let odd = &mut self.odd;
        if layout.has(&NORMAL) {
            self.normals.extend((0..rows).map(|i| {
                let normal = vector(NORMAL, i);
                if !normal.is_finite() {
                    odd.normals.add(place(i));
                }
                normal.as_dvec3().normalize_or_zero().as_vec3()
            }));
        }
        if layout.has(&UV) {
            self.uvs.extend((0..rows).map(|i| {
                let uv = Vec2::from_array(UV.map(|c| block[c][i]));
                if uv.is_finite() {
                    return uv;
                }
                odd.uvs.add(place(i));
                Vec2::ZERO
            }));
        }
        if layout.has(&COLOR) {
            self.colors.extend(block, rows, &mut self.odd.colors, place);
        }
    }
}

/// Reads the columns of binary rows of one length.
fn columns(layout: &Layout, bytes: &[u8], stride: usize, big: bool, block: &mut Block, rows: usize) {
    let bytes = &bytes[..rows * stride];
    for (out, channel) in block.iter_mut().zip(layout.channels) {
        if let Some((scalar, offset)) = channel {
            scalar.column(&bytes[offset..], stride, big, &mut out[..rows]);
        }
    }
}
