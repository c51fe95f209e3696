//! The element `vertex`.

use super::BLOCK;
use super::header::{Element, Property};
use super::rows::{CHANNELS, Row, Rows, Use};
use super::scalar::Scalar;
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
    /// The colours of the rows of a block.
    pub fn extend(&mut self, block: &Block, rows: usize) {
        self.values.extend((0..rows).map(|i| COLOR.map(|c| block[c][i])));
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
    /// Indices of positions that are not finite, in ascending order; those positions are zero.
    pub broken: Vec<u32>,
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
        let mut row = Row::default();
        let mut begin = 0;
        while begin < element.count {
            let length = BLOCK.min(element.count - begin);
            match rows.binary().filter(|_| element.is_fixed()) {
                Some((bytes, big)) => {
                    let stride = element.least_bytes();
                    columns(&layout, bytes, stride, big, &mut block, length);
                    rows.seek(rows.offset() + length * stride);
                }
                None => {
                    for index in begin..begin + length {
                        rows.row(element, &layout.uses, index, &mut row, faults)?;
                        for (column, value) in block.iter_mut().zip(row.channels) {
                            column[index - begin] = value as f32;
                        }
                    }
                }
            }
            vertices.add(&layout, &block, length);
            begin += length;
        }
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

    /// Takes the rows of a block.
    fn add(&mut self, layout: &Layout, block: &Block, rows: usize) {
        let vector = |channels: [usize; 3], i: usize| Vec3::from_array(channels.map(|c| block[c][i]));
        let first = self.positions.len();
        self.positions.extend((0..rows).map(|i| vector(POSITION, i)));
        for (i, position) in self.positions[first..].iter_mut().enumerate() {
            if !position.is_finite() {
                *position = Vec3::ZERO;
                self.broken.push((first + i) as u32);
            }
        }
        if layout.has(&NORMAL) {
            let unit = |n: Vec3| n.as_dvec3().normalize_or_zero().as_vec3();
            self.normals.extend((0..rows).map(|i| unit(vector(NORMAL, i))));
        }
        if layout.has(&UV) {
            let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
            self.uvs.extend((0..rows).map(|i| finite(Vec2::from_array(UV.map(|c| block[c][i])))));
        }
        if layout.has(&COLOR) {
            self.colors.extend(block, rows);
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
