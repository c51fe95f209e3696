//! Broken files: a fixed number of seeded mutations of small files. Nothing may panic, and the invariants of meshes
//! (checked by [`read_in`]) hold whenever a file is accepted.

use crate::common::read_in;
use crate::ply::as_binary;
use crate::stl::{TEXT, binary};
use penombre_scene::readers::MeshFormat;
use std::path::Path;
use std::time::Instant;

const OFF: [&str; 4] = [
    "OFF\n4 2 5\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n4 0 1 2 3\n",
    "COFF # c\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2 0.5 0.5 0.5 1\n",
    "STNOFF\n3 1\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n3 2 1 0 7\n",
    "OFF 5 1 0\n0 0 0 2 0 0 0.5 0.5 0 0 2 0 -1 -1 0\n5 0 1 2 3 4\n",
];
const OBJ: [&str; 5] = [
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0 1\nv 0 1 0 0.5 0.5 0.5\nusemtl m\nf 1 2 3 4\nf -1 -2 -3\n",
    "v 0 0 0\nvt 0 0\nvn 0 0 1\nv 1 0 0\nvt 1 0 0\nv 0 1 0\ns 1\ng a b\nf 1/1/1 2/2/1 3//1\nf 1 \\\n2 3\n",
    "o x\r\nv -1e-3 .5 1.\r\nv nan 0 inf\r\nv 1 2 3\r\nv 3 2 1\r\nv 0 0.1 0\r\nf 1 3 5 4\r\nf 1 2 3\r\nl 1 2\r\n",
    "v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 1 2 3 4\nusemtl\nf 4 3 2 1 # c\np 1\ncurv2 1 2\n",
    "v 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 2 0\nf 1 2 3\ns 1\nf 1 2 4\nvn 0 0 1\nf 1//1 2//1 3\ns 2\nf 1 2 3 4\ns off\nf 1 3 4\n",
];
const MTL: [&str; 3] = [
    "newmtl m\nKd 0.5 0.25 1\nKs 1\nNs 20\nillum 2\nd 0.5\nnewmtl n\nKe 0 0 0\nfoo\n",
    "newmtl m\nmap_Kd -s 1 2 3 -o 0.1 -clamp on -bm 3 -mm 0 1 -type sphere my file.png\nbump -bm 2 b.png\n",
    "newmtl m\nKe 1 2 3\nPr 0.5\nPm 0.5\nd 0.5\nTr 0.5\nillum 7\nNi 1.5\nTf 1 1 0.5\nnewmtl n\nmap_d -imfchan r -mm 0 1 a.png\nillum 5\nKs 0.5\n",
];

const PLY: [&str; 5] = [
    "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n1 0 0 4 5 6\n0 1 0 7 8 9\n1 1 0 0 0 0\n3 0 1 2\n3 2 1 3\n",
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\nelement face 2\nproperty list uchar ushort vertex_index\nproperty list uchar float texcoord\nproperty float red\nproperty float green\nproperty float blue\nend_header\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n1 1 0 0 0 0 1 1\n0.2 0.2 0 0 0 1 0 1\n0 1 0 0 0 1 0 1\n5 0 1 2 3 4 10 0 0 1 0 1 1 0 1 0 1 0.5 0.5 1\n3 0 1 2 0 1 1 1\n",
    "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty list uchar float more\nend_header\n6 0 1 2 3 -1 0\n0 0 0 0\n1 0 0 1 7\n0 1 0 0\n1 1 0 2 5 5\n",
    "ply\nformat ascii 1.0\nelement other 2\nproperty list short double a\nproperty char b\nelement vertex 3\nproperty short x\nproperty char y\nproperty uint z\nelement face 1\nproperty list uint uint vertex_indices\nend_header\n2 1 2 3\n0 4\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 3\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 1 2 3\n4 0 1 3 2 4 5 6\n3 0 1 3 7 8 9\n",
];

const HEADER_END: &[u8] = b"end_header\n";

/// Pieces that files are likely to break on.
const PIECES: [&[u8]; 20] = [
    b"-1",
    b"0",
    b"4294967295",
    b"4294967296",
    b"99999999999999999999",
    b"1e999",
    b"-",
    b"nan",
    b"/",
    b"//",
    b"\\\n",
    b"\r",
    b"\n",
    b"#",
    b"\0\0",
    b"\xff\xfe",
    b" ",
    b"f",
    b"OFF",
    b"../../x",
];

struct Random(u64);

impl Random {
    /// SplitMix64 \[Steele2014\].
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    fn mutate(&mut self, corpus: &[impl AsRef<[u8]>]) -> Vec<u8> {
        let mut bytes = corpus[self.below(corpus.len())].as_ref().to_vec();
        // Of files with a long header half are changed behind it only.
        let header =
            bytes.windows(HEADER_END.len()).position(|w| w == HEADER_END).map_or(0, |i| i + HEADER_END.len());
        let from = if header > 0 && self.below(2) == 0 { header } else { 0 };
        for _ in 0..=self.below(4) {
            let at = from.min(bytes.len()) + self.below(bytes.len() + 1 - from.min(bytes.len()));
            let end = (at + self.below(12)).min(bytes.len());
            match self.below(6) {
                0 => bytes.truncate(at),
                1 => _ = bytes.drain(at..end),
                2 => {
                    let piece = PIECES[self.below(PIECES.len())];
                    bytes.splice(at..end, piece.iter().copied());
                }
                3 => {
                    let copy = bytes[at..end].to_vec();
                    let to = self.below(bytes.len() + 1);
                    bytes.splice(to..to, copy);
                }
                4 if at < bytes.len() => bytes[at] = self.below(256) as u8,
                _ if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
                _ => {}
            }
        }
        bytes
    }
}

/// So many, or with `PENOMBRE_SLOW=1` 100 000.
fn rounds(usual: usize) -> usize {
    if std::env::var_os("PENOMBRE_SLOW").is_some_and(|v| v == "1") { 100_000 } else { usual }
}

/// Runs 4000 mutations; with `PENOMBRE_SLOW=1`, 100 000. Some must be accepted and some refused, else the mutations test
/// nothing.
fn run(format: MeshFormat, corpus: &[impl AsRef<[u8]>], seed: u64) {
    let rounds = rounds(4000);
    let mut random = Random(seed);
    let begin = Instant::now();
    let accepted = (0..rounds).filter(|_| {
        let bytes = random.mutate(corpus);
        read_in(Path::new("."), format, &bytes).file.is_some()
    });
    let accepted = accepted.count();
    assert!((rounds / 40..rounds * 37 / 40).contains(&accepted), "{accepted}");
    assert!(begin.elapsed().as_secs() < 30 * rounds as u64 / 4000);
}

#[test]
fn mutated_ply_files() {
    run(MeshFormat::Ply, &PLY, 4);
}

#[test]
fn mutated_binary_ply_files() {
    let corpus: Vec<Vec<u8>> = PLY.iter().flat_map(|t| [false, true].map(|big| as_binary(t, big))).collect();
    run(MeshFormat::Ply, &corpus, 5);
}

#[test]
fn mutated_stl_files() {
    run(MeshFormat::Stl, &[TEXT, &TEXT.replace('\n', "\r\n")], 6);
    let solid = binary("solid and yet binary", &[([0.0; 9], 0), ([1.0; 9], 0x8123)]);
    let magics = binary("COLOR=\u{1}\u{2}\u{3}\u{4} MATERIAL=", &[([0.5; 9], 0), ([1.0; 9], 0x8123)]);
    run(MeshFormat::Stl, &[solid, magics], 7);
}

#[test]
fn mutated_off_files() {
    run(MeshFormat::Off, &OFF, 1);
}

#[test]
fn mutated_obj_files() {
    run(MeshFormat::Obj, &OBJ, 2);
}

#[test]
fn mutated_libraries() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(3);
    let (mut clean, rounds) = (0, rounds(1000));
    for _ in 0..rounds {
        std::fs::write(folder.path().join("a.mtl"), random.mutate(&MTL)).unwrap();
        let read = read_in(folder.path(), MeshFormat::Obj, OBJ[0].as_bytes());
        // Only a path that leads out is an error.
        let outside = read.out.iter().any(|d| d.code == "asset::outside");
        assert_eq!(read.file.is_none(), outside, "{:?}", read.messages());
        clean += usize::from(read.out.is_empty());
    }
    assert!(clean < rounds / 2, "{clean}");
}
