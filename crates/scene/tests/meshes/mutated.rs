//! Broken files: a fixed number of seeded mutations of small files. Nothing may panic, and the invariants of meshes
//! (checked by [`read_in`]) hold whenever a file is accepted.

use crate::common::read_in;
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

    fn mutate(&mut self, corpus: &[&str]) -> Vec<u8> {
        let mut bytes = corpus[self.below(corpus.len())].as_bytes().to_vec();
        for _ in 0..=self.below(4) {
            let at = self.below(bytes.len() + 1);
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

/// Runs 4000 mutations. Some must be accepted and some refused, else the mutations test nothing.
fn run(format: MeshFormat, corpus: &[&str], seed: u64) {
    let mut random = Random(seed);
    let begin = Instant::now();
    let accepted = (0..4000).filter(|_| {
        let bytes = random.mutate(corpus);
        read_in(Path::new("."), format, &bytes).file.is_some()
    });
    let accepted = accepted.count();
    assert!((300..3700).contains(&accepted), "{accepted}");
    assert!(begin.elapsed().as_secs() < 30);
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
    let mut clean = 0;
    for _ in 0..1000 {
        std::fs::write(folder.path().join("a.mtl"), random.mutate(&MTL)).unwrap();
        let read = read_in(folder.path(), MeshFormat::Obj, OBJ[0].as_bytes());
        // Only a path that leads out is an error.
        let outside = read.out.iter().any(|d| d.code == "asset::outside");
        assert_eq!(read.file.is_none(), outside, "{:?}", read.messages());
        clean += usize::from(read.out.is_empty());
    }
    assert!(clean < 500, "{clean}");
}
