//! The number types of PLY.

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// The type of a name, in the words of the first description or in those with the number of bits.
    pub fn of_name(name: &[u8]) -> Option<Self> {
        match name {
            b"char" | b"int8" => Some(Self::I8),
            b"uchar" | b"uint8" => Some(Self::U8),
            b"short" | b"int16" => Some(Self::I16),
            b"ushort" | b"uint16" => Some(Self::U16),
            b"int" | b"int32" => Some(Self::I32),
            b"uint" | b"uint32" => Some(Self::U32),
            b"float" | b"float32" => Some(Self::F32),
            b"double" | b"float64" => Some(Self::F64),
            _ => None,
        }
    }

    /// Bytes that a number takes in binary files.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The name of the type.
    pub fn name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// True for whole numbers.
    pub fn is_whole(self) -> bool {
        self.range().is_some()
    }

    /// The least and the largest of the whole numbers of the type; `None` for fractions.
    pub fn range(self) -> Option<[i64; 2]> {
        match self {
            Self::I8 => Some([-1 << 7, (1 << 7) - 1]),
            Self::U8 => Some([0, (1 << 8) - 1]),
            Self::I16 => Some([-1 << 15, (1 << 15) - 1]),
            Self::U16 => Some([0, (1 << 16) - 1]),
            Self::I32 => Some([-1 << 31, (1 << 31) - 1]),
            Self::U32 => Some([0, (1 << 32) - 1]),
            Self::F32 | Self::F64 => None,
        }
    }

    /// True if a number is one of the type; any is for fractions.
    pub fn holds(self, v: f64) -> bool {
        let is_within = |[least, most]: [i64; 2]| v.fract() == 0.0 && v >= least as f64 && v <= most as f64;
        self.range().is_none_or(is_within)
    }

    /// The number at the beginning of the bytes, of which there must be enough. Every value of every type is kept.
    pub fn read(self, bytes: &[u8], big: bool) -> f64 {
        match self {
            Self::I8 => f64::from(i8::from_le_bytes(first(bytes, big))),
            Self::U8 => f64::from(u8::from_le_bytes(first(bytes, big))),
            Self::I16 => f64::from(i16::from_le_bytes(first(bytes, big))),
            Self::U16 => f64::from(u16::from_le_bytes(first(bytes, big))),
            Self::I32 => f64::from(i32::from_le_bytes(first(bytes, big))),
            Self::U32 => f64::from(u32::from_le_bytes(first(bytes, big))),
            Self::F32 => f64::from(f32::from_le_bytes(first(bytes, big))),
            Self::F64 => f64::from_le_bytes(first(bytes, big)),
        }
    }

    /// Reads one number of each row into `out`: `rows` begins with the first of them, rows are `stride` bytes apart.
    pub fn column(self, rows: &[u8], stride: usize, big: bool, out: &mut [f32]) {
        match self {
            Self::I8 => each(rows, stride, big, out, |b| f32::from(i8::from_le_bytes(b))),
            Self::U8 => each(rows, stride, big, out, |b| f32::from(u8::from_le_bytes(b))),
            Self::I16 => each(rows, stride, big, out, |b| f32::from(i16::from_le_bytes(b))),
            Self::U16 => each(rows, stride, big, out, |b| f32::from(u16::from_le_bytes(b))),
            Self::I32 => each(rows, stride, big, out, |b| i32::from_le_bytes(b) as f32),
            Self::U32 => each(rows, stride, big, out, |b| u32::from_le_bytes(b) as f32),
            Self::F32 => each(rows, stride, big, out, f32::from_le_bytes),
            Self::F64 => each(rows, stride, big, out, |b| narrow(f64::from_le_bytes(b))),
        }
    }

    /// Reads the triangles of the rows up to one whose list has not three numbers; rows are `stride` bytes long, the
    /// length of the list of the type `count` stands at `at`. Negative indices come out above any other. The largest
    /// index.
    pub fn triangles(
        self,
        rows: &[u8],
        (stride, at, count): (usize, usize, Self),
        big: bool,
        out: &mut Vec<[u32; 3]>,
    ) -> u32 {
        let run = Run { rows, stride, at, big };
        match self {
            Self::I8 => run.triangles(count, out, |b| i32::from(i8::from_le_bytes(b)) as u32),
            Self::U8 => run.triangles(count, out, |b| u32::from(u8::from_le_bytes(b))),
            Self::I16 => run.triangles(count, out, |b| i32::from(i16::from_le_bytes(b)) as u32),
            Self::U16 => run.triangles(count, out, |b| u32::from(u16::from_le_bytes(b))),
            _ => run.triangles(count, out, u32::from_le_bytes),
        }
    }
}

/// Rows of one length with a list of three.
#[derive(Clone, Copy)]
struct Run<'a> {
    rows: &'a [u8],
    stride: usize,
    at: usize,
    big: bool,
}

impl Run<'_> {
    fn triangles<const N: usize>(
        self,
        count: Scalar,
        out: &mut Vec<[u32; 3]>,
        value: impl Fn([u8; N]) -> u32,
    ) -> u32 {
        match count.size() {
            1 => self.of_count::<N, 1>(out, value),
            2 => self.of_count::<N, 2>(out, value),
            _ => self.of_count::<N, 4>(out, value),
        }
    }

    /// `C`: bytes of the length of the list.
    fn of_count<const N: usize, const C: usize>(
        self,
        out: &mut Vec<[u32; 3]>,
        value: impl Fn([u8; N]) -> u32,
    ) -> u32 {
        let mut three = [0; C];
        three[0] = 3;
        let mut largest = 0;
        for row in self.rows.chunks_exact(self.stride) {
            let row = &row[self.at..self.at + C + 3 * N];
            if first::<C>(row, self.big) != three {
                break;
            }
            let index = |i: usize| value(first(&row[C + i * N..], self.big));
            let triangle = [index(0), index(1), index(2)];
            largest = largest.max(triangle[0]).max(triangle[1]).max(triangle[2]);
            out.push(triangle);
        }
        largest
    }
}

/// A number in single precision. Infinite if it is too large, NaN if it was not finite.
#[inline]
pub(super) fn narrow(v: f64) -> f32 {
    if v.is_finite() { v as f32 } else { f32::NAN }
}

/// The first bytes, lowest first.
#[inline]
fn first<const N: usize>(bytes: &[u8], big: bool) -> [u8; N] {
    let mut own = [0; N];
    own.copy_from_slice(&bytes[..N]);
    if big {
        own.reverse();
    }
    own
}

#[inline]
fn each<const N: usize>(
    rows: &[u8],
    stride: usize,
    big: bool,
    out: &mut [f32],
    value: impl Fn([u8; N]) -> f32,
) {
    for (out, row) in out.iter_mut().zip(rows.chunks(stride)) {
        *out = value(first(row, big));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [(Scalar, &str, &str); 8] = [
        (Scalar::I8, "char", "int8"),
        (Scalar::U8, "uchar", "uint8"),
        (Scalar::I16, "short", "int16"),
        (Scalar::U16, "ushort", "uint16"),
        (Scalar::I32, "int", "int32"),
        (Scalar::U32, "uint", "uint32"),
        (Scalar::F32, "float", "float32"),
        (Scalar::F64, "double", "float64"),
    ];

    /// A value in both orders of bytes.
    fn bytes(scalar: Scalar, v: f64) -> [Vec<u8>; 2] {
        let little = match scalar {
            Scalar::I8 => (v as i8).to_le_bytes().to_vec(),
            Scalar::U8 => (v as u8).to_le_bytes().to_vec(),
            Scalar::I16 => (v as i16).to_le_bytes().to_vec(),
            Scalar::U16 => (v as u16).to_le_bytes().to_vec(),
            Scalar::I32 => (v as i32).to_le_bytes().to_vec(),
            Scalar::U32 => (v as u32).to_le_bytes().to_vec(),
            Scalar::F32 => (v as f32).to_le_bytes().to_vec(),
            Scalar::F64 => v.to_le_bytes().to_vec(),
        };
        let big = little.iter().rev().copied().collect();
        [little, big]
    }

    #[test]
    fn every_type_is_read_in_both_orders() {
        for (scalar, old, new) in ALL {
            assert_eq!([old, new].map(|n| Scalar::of_name(n.as_bytes())), [Some(scalar); 2]);
            for v in [0.0, 3.0, 100.0, -2.0, 250.0, 40000.0, 3e9, 0.25] {
                for (bytes, big) in bytes(scalar, v).iter().zip([false, true]) {
                    assert_eq!(bytes.len(), scalar.size());
                    let expected = scalar.read(bytes, big);
                    let lossless = match scalar {
                        Scalar::F32 | Scalar::F64 => true,
                        Scalar::I8 => (-128.0..128.0).contains(&v) && v.fract() == 0.0,
                        Scalar::U8 => (0.0..256.0).contains(&v) && v.fract() == 0.0,
                        _ => false,
                    };
                    assert!(!lossless || expected == v, "{scalar:?} {v} {expected}");
                    let rows = [&bytes[..], b"pad", bytes, b"pa"].concat();
                    let mut out = [0.0; 2];
                    scalar.column(&rows, bytes.len() + 3, big, &mut out);
                    assert_eq!(out, [expected as f32; 2]);
                }
            }
        }
    }

    #[test]
    fn types_have_ranges() {
        for (scalar, old, _) in ALL {
            assert_eq!(scalar.name(), old);
            let Some([least, most]) = scalar.range() else {
                assert!(scalar.holds(0.5) && scalar.holds(1e300));
                continue;
            };
            for v in [least, most] {
                for (bytes, big) in bytes(scalar, v as f64).iter().zip([false, true]) {
                    assert_eq!(scalar.read(bytes, big), v as f64);
                }
            }
            assert!(scalar.holds(least as f64) && scalar.holds(most as f64) && !scalar.holds(0.5));
            assert!(!scalar.holds(least as f64 - 1.0) && !scalar.holds(most as f64 + 1.0));
        }
        assert!(narrow(1e300) == f32::INFINITY && narrow(f64::INFINITY).is_nan() && narrow(0.1) == 0.1);
    }

    #[test]
    fn triangles_end_at_another_polygon() {
        for (index, ..) in ALL.iter().filter(|(s, ..)| s.is_whole()) {
            for (count, ..) in ALL.iter().filter(|(s, ..)| s.is_whole()) {
                for order in 0..2 {
                    let row = |n: f64, list: [f64; 3]| {
                        let mut row = vec![9];
                        row.extend(&bytes(*count, n)[order]);
                        list.iter().for_each(|i| row.extend(&bytes(*index, *i)[order]));
                        row
                    };
                    let rows =
                        [row(3.0, [0.0, 5.0, 2.0]), row(3.0, [1.0, 2.0, 100.0]), row(4.0, [1.0; 3])].concat();
                    let mut out = Vec::new();
                    let layout = (rows.len() / 3, 1, *count);
                    assert_eq!(index.triangles(&rows, layout, order == 1, &mut out), 100);
                    assert_eq!(out, [[0, 5, 2], [1, 2, 100]]);
                    if matches!(index, Scalar::I8 | Scalar::I16 | Scalar::I32) {
                        let rows = row(3.0, [0.0, -1.0, 2.0]);
                        let layout = (rows.len(), 1, *count);
                        assert_eq!(index.triangles(&rows, layout, order == 1, &mut out), u32::MAX);
                    }
                }
            }
        }
    }
}
