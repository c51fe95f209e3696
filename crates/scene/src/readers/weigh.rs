//! How large the mesh of a file will be, without reading all of it: binary files say it in their headers, of text files
//! some lines are looked at.

use super::{MeshFormat, is_packed, ply, stl, without_gz};
use flate2::bufread::MultiGzDecoder;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes at the beginning of a file in which its header stands.
const HEAD: u64 = 1 << 16;
/// Pieces of a long text that are looked at, and bytes of each.
const PIECES: u64 = 64;
const PIECE: u64 = 1 << 14;
/// Bytes of text for each triangle where nothing more is known: that of an OBJ file without attributes.
const TEXT_PER_TRIANGLE: u64 = 30;

/// A mesh in a file, estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshWeight {
    /// Number of positions.
    pub positions: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// Memory of the mesh as read, bytes.
    pub bytes: u64,
    /// True if the file has normals.
    pub has_normals: bool,
    /// Length of the file, unpacked, bytes.
    pub text_bytes: u64,
}

impl MeshWeight {
    /// Memory of the copy that a shape makes, bytes. Normals that the file does not have are computed: by vertex, and
    /// at creases by corner.
    pub fn shape_bytes(&self) -> u64 {
        let computed = self.positions.saturating_mul(12).saturating_add(self.triangles.saturating_mul(24));
        self.bytes.saturating_add(if self.has_normals { 0 } else { computed })
    }
}

/// Estimates the mesh in a file of `length` bytes. `said`: the format by its name.
///
/// # Errors
/// A failure of the file system.
pub fn weigh(path: &Path, said: MeshFormat, length: u64) -> std::io::Result<MeshWeight> {
    let mut file = File::open(path)?;
    let mut head = Vec::new();
    Read::by_ref(&mut file).take(HEAD).read_to_end(&mut head)?;
    let (mut length, packed) = (length, without_gz(path) != path && is_packed(&head));
    if packed {
        length = length.saturating_add(unpacked_length(&mut file, length)?);
        file.rewind()?;
        head.clear();
        // Damaged data are told when they are read.
        let _ = MultiGzDecoder::new(BufReader::new(&file)).take(HEAD).read_to_end(&mut head);
    }
    let format = MeshFormat::of_content(&head).unwrap_or(said);
    let known = match format {
        MeshFormat::Stl => stl::weigh(&head, length),
        MeshFormat::Ply => ply::weigh(&head, length),
        _ => None,
    };
    let weight = match known {
        Some(weight) => weight,
        None if packed => Lines::unseen(length),
        None => sample(&mut file, format, length)?.weight(),
    };
    Ok(MeshWeight { text_bytes: length, ..weight })
}

/// What the end of a packed file says of the length of its last member, at most what may come out.
fn unpacked_length(file: &mut File, length: u64) -> std::io::Result<u64> {
    let mut last = [0; 4];
    file.seek(SeekFrom::Start(length.saturating_sub(4)))?;
    file.read_exact(&mut last)?;
    Ok(u64::from(u32::from_le_bytes(last)).min(super::gzip::limit(length)))
}

/// Looks at all lines of a short text, or at some all over a long one.
fn sample(file: &mut File, format: MeshFormat, length: u64) -> std::io::Result<Lines> {
    let (pieces, bytes) = if length <= PIECES * PIECE { (1, length) } else { (PIECES, PIECE) };
    let mut lines = Lines::default();
    let mut piece = Vec::new();
    for i in 0..pieces {
        let at = (length - bytes) / pieces.max(2).saturating_sub(1) * i;
        file.seek(SeekFrom::Start(at))?;
        piece.clear();
        Read::by_ref(file).take(bytes).read_to_end(&mut piece)?;
        let mut whole: Vec<&[u8]> = piece.split_inclusive(|b| matches!(b, b'\n' | b'\r')).collect();
        // The first and the last are cut.
        if at > 0 && !whole.is_empty() {
            whole.remove(0);
        }
        if at + bytes < length {
            whole.pop();
        }
        for line in whole {
            lines.bytes += line.len() as u64;
            lines.add(format, line);
        }
    }
    lines.scale = if lines.bytes == 0 { 0.0 } else { length as f64 / lines.bytes as f64 };
    Ok(lines)
}

/// What some lines hold.
#[derive(Clone, Copy, Debug, Default)]
struct Lines {
    /// Bytes of the lines that were looked at.
    bytes: u64,
    /// Bytes of the file for each of these.
    scale: f64,
    positions: u64,
    triangles: u64,
    /// Bytes of all other attributes.
    others: u64,
    has_normals: bool,
}

impl Lines {
    /// A text of which nothing was seen.
    fn unseen(length: u64) -> MeshWeight {
        let triangles = length / TEXT_PER_TRIANGLE;
        Self {
            scale: 1.0,
            positions: triangles,
            triangles,
            others: triangles.saturating_mul(12),
            ..Self::default()
        }
        .weight()
    }

    fn add(&mut self, format: MeshFormat, line: &[u8]) {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let Some(first) = words.next() else { return };
        match format {
            MeshFormat::Obj => self.add_obj(first, words),
            MeshFormat::Stl => self.add_stl(first),
            MeshFormat::Off | MeshFormat::Ply => self.add_table(first, words.count() as u64),
        }
    }

    fn add_obj<'a>(&mut self, first: &[u8], mut words: impl Iterator<Item = &'a [u8]>) {
        match first {
            b"v" => {
                self.positions += 1;
                self.others += if words.count() > 3 { 12 } else { 0 };
            }
            b"vt" => self.others += 8,
            b"vn" => (self.others, self.has_normals) = (self.others + 12, true),
            b"f" => {
                let Some(corner) = words.next() else { return };
                let triangles = (words.count() as u64).saturating_sub(1);
                let lists = corner.split(|b| *b == b'/').skip(1).filter(|index| !index.is_empty()).count();
                self.triangles += triangles;
                self.others += triangles * (12 * lists as u64 + 4);
            }
            _ => {}
        }
    }

    /// Three corners make a triangle; hardly more positions than triangles are left when equal ones are joined.
    fn add_stl(&mut self, first: &[u8]) {
        if first == b"facet" {
            (self.positions, self.triangles) = (self.positions + 1, self.triangles + 1);
        }
    }

    /// A face begins with the number of its corners; all other numbers are taken as a vertex.
    fn add_table(&mut self, first: &[u8], more: u64) {
        let corners = std::str::from_utf8(first).ok().and_then(|w| w.parse::<u64>().ok());
        match corners {
            Some(n) if n >= 3 && more >= n => {
                self.triangles += n - 2;
                self.others += if more > n { 12 * (n - 2) } else { 0 };
            }
            _ if more >= 2 => {
                self.positions += 1;
                self.others += 4 * (more - 2).min(8);
            }
            _ => {}
        }
    }

    fn weight(self) -> MeshWeight {
        let scaled = |n: u64| (n as f64 * self.scale) as u64;
        let (positions, triangles) = (scaled(self.positions), scaled(self.triangles));
        MeshWeight {
            positions,
            triangles,
            bytes: positions.saturating_add(triangles).saturating_mul(12).saturating_add(scaled(self.others)),
            has_normals: self.has_normals,
            text_bytes: 0,
        }
    }
}

#[cfg(test)]
mod tests;
