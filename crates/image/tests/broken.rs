//! Files that are broken in one place: each is refused, and told with the place.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use penombre_image::{ColorSpace, Decoded, Format, Image, WriteOptions, decode, decode_layers, encode};
use std::path::Path;

fn read(bytes: &[u8]) -> Result<Decoded, String> {
    decode(bytes, Path::new("a"), ColorSpace::Linear).map_err(|e| e.to_string())
}

/// Checks that a file is refused with a place and such words.
fn refused(bytes: &[u8], words: &str) {
    let text = read(bytes).expect_err(words);
    assert!(text.contains(", byte ") && text.contains("found") && text.contains("expected"), "{text}");
    assert!(text.contains(words), "{text}, not {words}");
}

fn written(format: Format, width: u32, height: u32) -> Vec<u8> {
    let data = (0..width * height * 3).map(|i| (i * 37 % 101) as f32 / 100.0).collect();
    let image = Image::from_data(width, height, 3, data).unwrap();
    let mut bytes = Vec::new();
    encode(format, &image, &WriteOptions::default(), &mut bytes).unwrap();
    bytes
}

/// The file with these bytes at a place.
fn with(file: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    file[at..at + bytes.len()].copy_from_slice(bytes);
    file
}

mod png {
    use super::{read, refused, with};

    type Chunk<'a> = (&'a [u8; 4], Vec<u8>);

    fn chunk((name, data): &Chunk<'_>) -> Vec<u8> {
        let body = [&name[..], data].concat();
        [&(data.len() as u32).to_be_bytes()[..], &body, &crc32fast::hash(&body).to_be_bytes()].concat()
    }

    fn file(chunks: &[Chunk<'_>]) -> Vec<u8> {
        let chunks: Vec<Vec<u8>> = chunks.iter().map(chunk).collect();
        [b"\x89PNG\r\n\x1a\n".to_vec(), chunks.concat()].concat()
    }

    /// One block of bytes as they are, between the zlib header and the Adler-32 sum.
    fn zlib(data: &[u8]) -> Vec<u8> {
        let length = data.len() as u16;
        let (mut a, mut b) = (1u32, 0u32);
        for byte in data {
            a = (a + u32::from(*byte)) % 65521;
            b = (b + a) % 65521;
        }
        let sum = (b << 16 | a).to_be_bytes();
        [&[0x78, 1, 1][..], &length.to_le_bytes(), &(!length).to_le_bytes(), data, &sum].concat()
    }

    /// Width, height, depth, kind of colour, compression, filter, interlace.
    fn header(width: u32, height: u32, numbers: [u8; 5]) -> Chunk<'static> {
        (b"IHDR", [&width.to_be_bytes()[..], &height.to_be_bytes(), &numbers].concat())
    }

    /// Two by two pixels of a palette of three colours, with notes.
    fn noted() -> Vec<Chunk<'static>> {
        let data = zlib(&[0, 0, 1, 0, 2, 1]);
        vec![
            header(2, 2, [8, 3, 0, 0, 0]),
            (b"gAMA", 45_455u32.to_be_bytes().to_vec()),
            (b"sRGB", vec![0]),
            (b"tEXt", b"Title\0abc".to_vec()),
            (b"PLTE", (0..9).collect()),
            (b"tRNS", vec![255, 128]),
            (b"IDAT", data[..5].to_vec()),
            (b"IDAT", data[5..].to_vec()),
            (b"tIME", vec![7, 0xd0, 1, 1, 0, 0, 0]),
            (b"IEND", Vec::new()),
        ]
    }

    #[test]
    fn no_byte_of_any_chunk_may_change() {
        let good = file(&noted());
        assert_eq!(read(&good).unwrap().metadata, [("Title".to_owned(), "abc".to_owned())]);
        for at in 0..good.len() {
            for flip in [1, 0x20, 0x80] {
                let changed = with(&good, at, &[good[at] ^ flip]);
                assert!(read(&changed).is_err(), "byte {at}");
            }
        }
        // What stands behind the last chunk does not count.
        assert!(read(&[&good[..], b"more"].concat()).is_ok());
        refused(&with(&good, 4, b"\n"), "byte 0: found \"\\x89PNG\\n\\n");
    }

    #[test]
    fn a_wrong_sum_names_its_chunk() {
        let chunks = noted();
        let mut end = 8;
        for (name, data) in &chunks {
            end += data.len() + 12;
            let good = file(&chunks);
            let [.., last] = good[..end] else { panic!("a file") };
            let words = format!("byte {}: found CRC 0x", end - 4);
            refused(&with(&good, end - 1, &[last ^ 1]), &words);
            refused(&with(&good, end - 1, &[last ^ 1]), &format!("of chunk {}, ", name.escape_ascii()));
        }
    }

    #[test]
    fn faults_of_chunks_are_placed() {
        let data = || (b"IDAT", zlib(&[0, 1, 2, 3]));
        let end = || (b"IEND", Vec::new());
        let grey = |numbers| vec![header(3, 1, numbers), data(), end()];
        let good = || grey([8, 0, 0, 0, 0]);
        assert!(read(&file(&good())).is_ok());
        let palette = |colors: Vec<u8>| vec![header(3, 1, [8, 3, 0, 0, 0]), (b"PLTE", colors), data(), end()];
        let around = |at: usize, chunk: Chunk<'static>| {
            let mut chunks = good();
            chunks.insert(at, chunk);
            chunks
        };
        for (chunks, words) in [
            (
                grey([3, 0, 0, 0, 0]),
                "byte 24: found bit depth 3 with colour type 0, expected one of 1, 2, 4, 8, 16",
            ),
            (grey([1, 2, 0, 0, 0]), "byte 24: found bit depth 1 with colour type 2, expected one of 8, 16"),
            (grey([16, 3, 0, 0, 0]), "byte 24: found bit depth 16 with colour type 3"),
            (grey([8, 5, 0, 0, 0]), "byte 25: found colour type 5"),
            (grey([8, 0, 1, 0, 0]), "byte 26: found compression method 1"),
            (grey([8, 0, 0, 9, 0]), "byte 27: found filter method 9"),
            (grey([8, 0, 0, 0, 2]), "byte 28: found interlace method 2"),
            (
                vec![(b"IHDR", vec![0; 12]), data(), end()],
                "byte 8: found chunk IHDR of 12 bytes, expected 13",
            ),
            (vec![(b"IHDR", vec![0; 14]), data(), end()], "byte 8: found chunk IHDR of 14 bytes"),
            (vec![header(0, 1, [8, 0, 0, 0, 0]), data(), end()], "byte 16: found a size of 0 × 1 pixels"),
            (vec![data(), end()], "byte 8: found chunk IDAT, expected chunk IHDR first"),
            (vec![], "byte 8: found the end of the file, expected chunk IHDR"),
            (vec![good().remove(0)], "byte 33: found the end of the file, expected chunk IDAT"),
            (vec![good().remove(0), end()], "byte 33: found chunk IEND, expected chunk IDAT"),
            (vec![good().remove(0), data()], "found the end of the file, expected chunk IEND"),
            (around(1, good().remove(0)), "byte 33: found chunk IHDR, expected one"),
            (around(1, (b"ABCD", vec![])), "byte 33: found chunk ABCD, which is not supported"),
            (around(1, (b"t3Xt", vec![])), "byte 37: found \"t3Xt\", expected the name of a chunk"),
            (around(2, (b"PLTE", vec![0; 3])), "found chunk PLTE, expected one alone, before the first IDAT"),
            (
                vec![good().remove(0), data(), (b"tEXt", b"a\0b".to_vec()), data(), end()],
                "expected all chunks IDAT",
            ),
            (vec![good().remove(0), data(), (b"IEND", vec![0])], "found chunk IEND of 1 bytes"),
            (
                palette(vec![0; 4]),
                "byte 33: found chunk PLTE of 4 bytes, expected 1 to 256 colours of 3 bytes",
            ),
            (palette(vec![]), "byte 33: found chunk PLTE of 0 bytes"),
            (palette(vec![0; 771]), "byte 33: found chunk PLTE of 771 bytes"),
            (vec![header(3, 1, [8, 3, 0, 0, 0]), data(), end()], "found chunk IDAT, expected chunk PLTE"),
        ] {
            refused(&file(&chunks), words);
        }
        let whole = file(&good());
        for length in [0u32, 14, 16, 0x7fff_ffff, u32::MAX] {
            assert!(read(&with(&whole, 33, &length.to_be_bytes())).is_err(), "{length}");
        }
        refused(
            &with(&whole, 33, &[0xff; 4]),
            "byte 33: found chunk IDAT of 4294967295 bytes, expected at most the",
        );
    }

    #[test]
    fn faults_of_the_packed_picture_are_told() {
        let picture =
            |data: Vec<u8>| file(&[header(3, 1, [8, 0, 0, 0, 0]), (b"IDAT", data), (b"IEND", vec![])]);
        let good = zlib(&[0, 1, 2, 3]);
        assert!(read(&picture(good.clone())).is_ok());
        let last = good.len() - 1;
        refused(&picture(with(&good, last, &[good[last] ^ 1])), "Adler-32");
        refused(&picture(with(&good, 0, &[0x79])), "do not begin as those of zlib");
        refused(&picture(with(&good, 2, &[7])), "a block of an unknown kind");
        refused(&picture(with(&good, 5, &[0])), "a block with a wrong length");
        refused(&picture(zlib(&[5, 1, 2, 3])), "found filter 5, expected filter 0 to 4");
        refused(&picture(zlib(&[0, 1, 2])), "expected data for all of its rows");
        refused(&picture(good[..8].to_vec()), "expected data for all of its rows");
        // More than the picture takes is no harm.
        assert!(read(&picture(zlib(&[0, 1, 2, 3, 4]))).is_ok());
    }

    #[test]
    fn chunks_of_an_animation_do_not_spoil_the_still_picture() {
        let still = |data: Vec<u8>| vec![header(3, 1, [8, 0, 0, 0, 0]), (b"IDAT", data), (b"IEND", vec![])];
        let moving = |data: Vec<u8>| {
            let mut chunks = still(data);
            chunks.insert(1, (b"acTL", vec![0; 8]));
            // A first frame of one pixel, a frame without any, and data that nothing announces.
            let small = [&[0u8; 4][..], &1u32.to_be_bytes(), &1u32.to_be_bytes(), &[0; 14]].concat();
            chunks.insert(2, (b"fcTL", small));
            chunks.insert(4, (b"fcTL", vec![0; 25]));
            chunks.insert(5, (b"fdAT", vec![1]));
            chunks
        };
        let good = zlib(&[0, 1, 2, 3]);
        assert_eq!(read(&file(&moving(good.clone()))).unwrap(), read(&file(&still(good.clone()))).unwrap());
        // A fault behind them is told with its place in the file.
        let place = |file: Vec<u8>| -> usize {
            let text = read(&file).unwrap_err();
            text.split_once("byte ").unwrap().1.split_once(':').unwrap().0.parse().unwrap()
        };
        let bad = zlib(&[5, 1, 2, 3]);
        assert_eq!(place(file(&moving(bad.clone()))), place(file(&still(bad))) + 20 + 38);
        let mut broken = file(&moving(good));
        broken[45] ^= 1;
        refused(&broken, "of chunk acTL");
    }

    #[test]
    fn colours_outside_of_the_palette_are_refused() {
        let picture = |depth: u8, colors: usize, interlaced: u8, width: u32, height: u32, rows: &[u8]| {
            let palette = (0..colors * 3).map(|i| i as u8).collect();
            let header = header(width, height, [depth, 3, 0, 0, interlaced]);
            file(&[header, (b"PLTE", palette), (b"IDAT", zlib(rows)), (b"IEND", vec![])])
        };
        let words = |color: usize, last: usize| {
            format!("found colour {color} in the picture's data, expected colours 0 to {last} of")
        };
        for (depth, colors, row, bad) in [
            (8, 4, [0, 3, 2, 0].as_slice(), [0, 3, 4, 0].as_slice()),
            (4, 9, &[0, 0x18, 0x8f], &[0, 0x18, 0x9f]),
            // The last bits of a row are no pixels.
            (2, 3, &[0, 0b0110_0011], &[0, 0b0110_1111]),
            (1, 1, &[0, 0b0001_1111], &[0, 0b0011_1111]),
        ] {
            assert!(read(&picture(depth, colors, 0, 3, 1, row)).is_ok(), "{depth} bits");
            let color = [3, 9, 4, 1][[2, 4, 8, 1].iter().position(|d| *d == depth).unwrap()];
            refused(&picture(depth, colors, 0, 3, 1, bad), &words(color, colors - 1));
        }
        // Seven passes of 5 × 3 pixels: rows of 1, 1, none, 1, 3, 2 and 2, 5 pixels.
        let rows = [0, 0x40, 0, 0x40, 0, 0x40, 0, 0x54, 0, 0x50, 0, 0x50, 0, 0x55, 0x40];
        assert!(read(&picture(2, 2, 1, 5, 3, &rows)).is_ok());
        for (at, byte) in [(1, 0xc0), (3, 0x80), (7, 0x58), (11, 0x70), (14, 0x80)] {
            refused(&picture(2, 2, 1, 5, 3, &with(&rows, at, &[byte])), "of the palette");
        }
        // Behind the pixels of each row.
        for (at, byte) in [(1, 0x7f), (7, 0x57), (11, 0x5f), (14, 0x7f)] {
            assert!(read(&picture(2, 2, 1, 5, 3, &with(&rows, at, &[byte]))).is_ok(), "byte {at}");
        }
    }
}

/// Memory for a picture is taken before it is compared with its canvas.
#[test]
fn webp_pictures_fill_their_canvas() {
    for (picture, [width, height]) in [
        (written(Format::Webp, 13, 9), [13u8, 9]),
        (include_bytes!("data/lossy.webp").to_vec(), lossy_size(include_bytes!("data/lossy.webp"))),
    ] {
        let file = |width: u8, height: u8| webp(0, [width, height], &picture[12..]);
        assert!(read(&file(width, height)).is_ok());
        refused(&file(width - 1, height), "byte 30: found a picture of");
        refused(&file(width, height + 1), "byte 30: found a picture of");
        // One behind the end of the file is none.
        let canvas = webp(0, [width - 1, height], &[]);
        assert!(read(&[&canvas[..], &picture[12..]].concat()).is_err());
    }
}

/// In frames too; the picture behind transparency must say that it is one.
#[test]
fn webp_frames_hold_pictures_of_their_size() {
    let lossy = include_bytes!("data/lossy.webp");
    let [width, height] = lossy_size(lossy);
    let frame = |[width, height]: [u8; 2], picture: &[u8]| {
        let head = [0, 0, 0, 0, 0, 0, width - 1, 0, 0, height - 1, 0, 0, 0, 0, 0, 0];
        riff_chunk(b"ANMF", &[&head[..], picture].concat())
    };
    let file = |frame: &[u8]| {
        let begin = riff_chunk(b"ANIM", &[0; 6]);
        webp(2, [width, height], &[&begin[..], frame].concat())
    };
    assert!(read(&file(&frame([width, height], &lossy[12..]))).is_ok());
    refused(&file(&frame([width - 1, height], &lossy[12..])), "byte 68: found a picture of");
    refused(&file(&frame([width, height + 1], &lossy[12..])), "byte 44: found a frame of");
    let alpha = [riff_chunk(b"ALPH", &[0; 2]), lossy[12..].to_vec()].concat();
    let named = with(&alpha, 10, b"ABCD");
    refused(
        &file(&frame([width, height], &named)),
        "byte 78: found chunk \"ABCD\", expected chunk VP8 behind",
    );
    // Frames in frames, as deep as a stack is not.
    let levels = 1u32 << 17;
    let length = |level: u32| (24 * (levels - level) - 8).to_le_bytes();
    let deep: Vec<u8> =
        (0..levels).flat_map(|level| [b"ANMF", &length(level)[..], &[0; 16]].concat()).collect();
    assert!(read(&file(&deep)).is_err());
}

/// An extended WebP file with these flags, of such a canvas.
fn webp(flags: u8, [width, height]: [u8; 2], chunks: &[u8]) -> Vec<u8> {
    let canvas = [flags, 0, 0, 0, width - 1, 0, 0, height - 1, 0, 0];
    riff_chunk(b"RIFF", &[b"WEBP", &riff_chunk(b"VP8X", &canvas)[..], chunks].concat())
}

fn riff_chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    [name, &(data.len() as u32).to_le_bytes()[..], data].concat()
}

/// Width and height stand behind three bytes and a mark of three.
fn lossy_size(file: &[u8]) -> [u8; 2] {
    [file[26], file[28]]
}

#[test]
fn webp_files_are_as_long_as_they_say() {
    let lossy = include_bytes!("data/lossy.webp").to_vec();
    let lossless = written(Format::Webp, 13, 9);
    for file in [lossy, lossless] {
        assert!(read(&file).is_ok());
        let size = file.len() as u32 - 8;
        for cut in 1..=3 {
            refused(&file[..file.len() - cut], "byte 4: found a size of");
        }
        for wrong in [0, 1, 4, 11, size - 2, size + 1, size + 2, 0x7fff_ffff, u32::MAX] {
            assert!(read(&with(&file, 4, &wrong.to_le_bytes())).is_err(), "{wrong} of {size}");
        }
        refused(&with(&file, 4, &[0; 4]), "byte 4: found a size of 0 bytes");
        refused(&with(&file, 16, &[0xff; 4]), "byte 12: found chunk \"VP8");
        let [shorter, name] = [16, 12].map(|at| with(&file, at, &[file[at] - 4]));
        assert!(read(&shorter).is_err());
        refused(&name, "byte 12: found chunk \"");
        // What stands behind does not count.
        assert!(read(&[&file[..], b"more"].concat()).is_ok());
    }
    // A last chunk of odd length whose padding is left out on both sides, or only there.
    let even = include_bytes!("data/lossy.webp").to_vec();
    let odd = [&even[..], b"abcd\x03\0\0\0xyz"].concat();
    assert!(read(&with(&odd, 4, &(odd.len() as u32 - 8).to_le_bytes())).is_ok());
    let padded = [&odd[..], &[0]].concat();
    assert!(read(&with(&padded, 4, &(odd.len() as u32 - 8).to_le_bytes())).is_ok());
    assert!(read(&with(&padded, 4, &(padded.len() as u32 - 8).to_le_bytes())).is_ok());
    refused(&with(&odd, 4, &(padded.len() as u32 - 8).to_le_bytes()), "byte 4");
}

mod gif {
    use super::{read, refused};

    /// A picture of 4 × 1 pixels; codes of 9 bits, the first of which starts anew, with a palette of four colours.
    fn file(pixels: [u8; 4], control: &[u8], end: &[u8]) -> Vec<u8> {
        let codes = [256].into_iter().chain(pixels.map(u64::from)).chain([257]);
        let bits = codes.enumerate().fold(0u64, |bits, (i, code)| bits | code << (9 * i));
        let palette: Vec<u8> = (0..12).collect();
        [
            b"GIF89a\x04\0\x01\0\x81\0\0".as_slice(),
            &palette,
            control,
            b",\0\0\0\0\x04\0\x01\0\0\x08\x07",
            &bits.to_le_bytes()[..7],
            &[0],
            end,
        ]
        .concat()
    }

    #[test]
    fn the_end_and_the_colours_are_checked() {
        assert!(read(&file([0, 1, 2, 3], b"", b";")).is_ok());
        assert!(read(&file([0, 1, 2, 3], b"", b";more")).is_ok());
        assert!(read(&file([0, 1, 2, 3], b"", b"\0;")).is_ok());
        // Old programs leave out the end.
        assert!(read(&file([0, 1, 2, 3], b"", b"")).is_ok());
        refused(&file([0, 1, 2, 3], b"", b"x;"), "byte 45: found byte 0x78");
        refused(&file([0, 1, 2, 3], b"", b"!\xfe\x03ab"), "found 2 more bytes");
        refused(
            &file([0, 1, 4, 3], b"", b";"),
            "byte 36: found colour 4 in the picture's data, expected colours 0 to 3",
        );
        refused(&file([0, 1, 2, 255], b"", b";"), "found colour 255");
        // A colour that is never shown needs none.
        assert!(read(&file([0, 1, 200, 3], b"!\xf9\x04\x01\0\0\xc8\0", b";")).is_ok());
        refused(&file([0, 1, 201, 3], b"!\xf9\x04\x01\0\0\xc8\0", b";"), "found colour 201");
        refused(&file([0, 1, 200, 3], b"!\xf9\x04\0\0\0\xc8\0", b";"), "found colour 200");
        let empty = [&file([0; 4], b"", b"")[..25], b";"].concat();
        refused(&empty, "byte 25: found the mark of the end, expected a picture");
    }
}

mod bmp {
    use super::{read, refused, with};

    /// A picture with four colours.
    fn file(width: i32, height: i32, depth: u16, compression: u32, data: &[u8]) -> Vec<u8> {
        let palette = [[1u8, 2, 3, 0]; 4];
        [
            b"BM\0\0\0\0\0\0\0\0".as_slice(),
            &70u32.to_le_bytes(),
            &40u32.to_le_bytes(),
            &width.to_le_bytes(),
            &height.to_le_bytes(),
            &1u16.to_le_bytes(),
            &depth.to_le_bytes(),
            &compression.to_le_bytes(),
            &[0; 12],
            &4u32.to_le_bytes(),
            &[0; 4],
            palette.as_flattened(),
            data,
        ]
        .concat()
    }

    #[test]
    fn headers_cut_anywhere_are_told() {
        let whole = file(4, 1, 8, 0, &[0; 4]);
        assert!(read(&whole).is_ok());
        for length in 2..whole.len() {
            let words = match length {
                2..14 => {
                    format!("byte 0: found {length} more bytes before the end of the file, expected 14 bytes")
                }
                14..18 => format!("byte 14: found {} more bytes before the end of the file", length - 14),
                18..26 => format!("byte 18: found {} more bytes before the end of the file", length - 18),
                _ => format!("byte {length}: found the end of the file"),
            };
            refused(&whole[..length], &words);
        }
        refused(&with(&whole, 14, &[5]), "expected a header of 12, 40");
        refused(&with(&whole, 26, &[2]), "expected one plane");
    }

    #[test]
    fn colours_outside_of_the_palette_are_refused() {
        // Two rows of four bytes, of which three are pixels.
        assert!(read(&file(3, 2, 8, 0, &[0, 1, 2, 9, 3, 2, 1, 9])).is_ok());
        refused(
            &file(3, 2, 8, 0, &[0, 1, 2, 9, 3, 2, 4, 9]),
            "byte 76: found colour 4, expected colours 0 to 3",
        );
        refused(&file(3, -2, 8, 0, &[0, 1, 2, 9, 3, 200, 1, 9]), "byte 75: found colour 200");
        assert!(read(&file(3, 1, 4, 0, &[0x12, 0x3f, 0, 0])).is_ok());
        refused(&file(3, 1, 4, 0, &[0x12, 0x40, 0, 0]), "byte 71: found colour 4");
        // Runs: a run and literal pixels with padding in each row, a step, the end.
        let runs = [2, 3, 0, 3, 0, 1, 2, 77, 0, 0, 1, 2, 0, 2, 1, 0, 3, 1, 0, 1];
        assert!(read(&file(5, 2, 8, 1, &runs)).is_ok());
        refused(&file(5, 2, 8, 1, &with(&runs, 1, &[4])), "byte 71: found colour 4");
        refused(&file(5, 2, 8, 1, &with(&runs, 6, &[5])), "byte 76: found colour 5");
        refused(&file(5, 2, 8, 1, &with(&runs, 17, &[6])), "byte 87: found colour 6");
        let runs = [1, 0x3f, 0, 3, 0x12, 0x3f, 0, 0, 2, 0x13, 0, 1];
        assert!(read(&file(4, 2, 4, 2, &runs)).is_ok());
        refused(&file(4, 2, 4, 2, &with(&runs, 1, &[0x43])), "byte 71: found colour 4");
        refused(&file(4, 2, 4, 2, &with(&runs, 5, &[0x43])), "byte 75: found colour 4");
        refused(&file(4, 2, 4, 2, &with(&runs, 9, &[0x14])), "byte 79: found colour 4");
    }
}

fn number(file: &[u8], at: usize) -> usize {
    file[at..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes) as usize)
}

/// Where the table of blocks begins: its first entry leads to its end.
fn offset_table(file: &[u8]) -> usize {
    let is_table = |at: &usize| {
        let first = number(file, *at);
        first > *at && first < file.len() && (first - at).is_multiple_of(8) && number(file, at + 8) > first
    };
    (100..file.len() - 16).find(is_table).unwrap()
}

#[test]
fn each_block_of_an_openexr_file_comes_once() {
    let refused = |file: &[u8], words: &str| {
        refused(file, words);
        let text = decode_layers(file, Path::new("a")).unwrap_err().to_string();
        assert!(text.contains(words), "{text}, not {words}");
    };
    // Three blocks of 16 rows.
    let file = written(Format::Exr, 5, 40);
    let table = offset_table(&file);
    let offset = |n: usize| number(&file, table + 8 * n);
    let y = |n: usize| i32::from_le_bytes(*file[offset(n)..].first_chunk().unwrap());
    assert_eq!([y(0), y(1), y(2)], [0, 16, 32]);
    let entry = |n: usize| file[table + 8 * n..table + 8 * n + 8].to_vec();
    refused(&with(&file, table, &entry(1)), &format!("byte {}: found a second block with y = 16", offset(1)));
    refused(
        &with(&file, table + 16, &entry(1)),
        "a second block with y = 16, expected each block of the picture once",
    );
    refused(&with(&file, offset(0), &[16]), "a second block with y = 16");
    for wrong in [1, 15, 33, 40, 48, -1, -16, i32::MAX, i32::MIN] {
        let words = format!("byte {}: found a block with y = {wrong}, expected", offset(0));
        refused(&with(&file, offset(0), &wrong.to_le_bytes()), &words);
    }
    // In another order all are there.
    let swapped = with(&with(&file, table, &entry(2)), table + 16, &entry(0));
    assert_eq!(read(&swapped).unwrap().image, read(&file).unwrap().image);

    let tiles = include_bytes!("data/tiled-rle.exr");
    let at = offset_table(tiles);
    let second = tiles[at + 8..at + 16].to_vec();
    refused(&with(tiles, at, &second), "found a second block with tile ");
}

#[test]
fn attributes_of_another_length_are_named() {
    let file = written(Format::Exr, 5, 40);
    for (name, kind, length) in [
        ("channels", "chlist", 55),
        ("compression", "compression", 1),
        ("dataWindow", "box2i", 16),
        ("displayWindow", "box2i", 16),
        ("lineOrder", "lineOrder", 1),
        ("pixelAspectRatio", "float", 4),
        ("screenWindowCenter", "v2f", 8),
        ("screenWindowWidth", "float", 4),
    ] {
        let head = format!("{name}\0{kind}\0");
        let at = file.windows(head.len()).position(|w| w == head.as_bytes()).unwrap();
        let place = at + head.len();
        assert_eq!(file[place..place + 4], [length, 0, 0, 0], "{name}");
        for wrong in [0, 1, u32::from(length) - 1, u32::from(length) + 1, 1000, 1 << 31, u32::MAX] {
            if wrong != length.into() {
                let words = format!("byte {at}: found attribute \"{name}\" of {wrong} bytes, expected ");
                refused(&with(&file, place, &wrong.to_le_bytes()), &words);
            }
        }
    }
}

#[test]
fn jpeg_files_of_other_processes_are_named() {
    let file = written(Format::Jpeg, 13, 9);
    let at = file.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    for (mark, words) in [
        (0xc3, "found lossless coding (SOF3), which is not supported; expected baseline or progressive"),
        (0xc6, "found hierarchical coding (SOF6), which"),
        (0xc9, "found arithmetic coding (SOF9), which"),
        (0xca, "found arithmetic coding (SOF10), which"),
        (0xcb, "found lossless arithmetic coding (SOF11), which"),
        (0xcf, "found hierarchical arithmetic coding (SOF15), which"),
    ] {
        refused(&with(&file, at + 1, &[mark]), &format!("byte {at}: {words}"));
    }
    refused(&with(&file, at + 5, &[0xff; 4]), &format!("byte {at}: found a size of 65535 × 65535 pixels"));
    refused(&with(&file, at + 5, &[0; 4]), &format!("byte {at}: found a size of 0 × 0 pixels"));
    // Texts of the library without its quotes, marks for ends of lines and slips.
    for changed in [with(&file, 4, &[0, 1]), with(&file, at + 4, &[12])] {
        let text = read(&changed).unwrap_err();
        assert!(!text.contains("\\n") && !text.contains('"') && !text.contains("Reason"), "{text}");
    }
    refused(&with(&file, at + 4, &[12]), "12 bits of precision, expected 8 bits");
}
