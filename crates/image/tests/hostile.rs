//! Damaged files: an image or an error, never a panic, a long run or a flood of memory.

use penombre_image::{
    ColorSpace, Format, Image, Layer, Layers, WriteOptions, decode, decode_layers, encode, encode_layers,
    load, panic_is_contained,
};
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

static CAUGHT: AtomicUsize = AtomicUsize::new(0);
/// Those among them that are not in a library.
static OURS: AtomicUsize = AtomicUsize::new(0);

/// Counts the panics that the library catches, which print nothing then.
fn count_caught_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if panic_is_contained() {
                CAUGHT.fetch_add(1, Ordering::Relaxed);
                let is_ours = info
                    .location()
                    .is_some_and(|l| l.file().replace('\\', "/").contains("crates/image/src/"));
                OURS.fetch_add(usize::from(is_ours), Ordering::Relaxed);
            } else {
                usual(info);
            }
        }));
    });
}

fn corpus() -> Option<PathBuf> {
    let root = std::env::var_os("PENOMBRE_TESTDATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    Some(root.join("bad-inputs")).filter(|p| p.is_dir())
}

#[test]
fn corpus_of_bad_images() {
    let Some(folder) = corpus() else {
        eprintln!("NOT RUN: corpus_of_bad_images (no bad-inputs folder; set PENOMBRE_TESTDATA)");
        return;
    };
    count_caught_panics();
    let index = std::fs::read_to_string(folder.join("INDEX.tsv")).unwrap();
    let mut checked = 0;
    for line in index.lines().filter(|l| l.starts_with("images/")) {
        let fields: Vec<&str> = line.split('\t').collect();
        let (name, class) = (fields[0], fields[1]);
        let start = Instant::now();
        let result = load(&folder.join(name));
        let time = start.elapsed();
        assert!(time < Duration::from_secs(2), "{name}: {time:?}");
        match (class, &result) {
            ("ERR", Ok(_)) => panic!("{name} was accepted: {}", fields[2]),
            ("OK", Err(e)) => panic!("{name} was refused: {e}"),
            _ => {}
        }
        if let Err(error) = &result {
            let text = error.to_string();
            let file = Path::new(name).file_name().unwrap().to_string_lossy().into_owned();
            let placed = (text.contains(", byte ") || text.contains(": byte "))
                && text.contains("found")
                && text.contains("expected");
            assert!(text.contains(&file) && placed && text.len() < 600, "{name}: {text}");
        }
        checked += 1;
    }
    assert!(checked > 90, "only {checked} images in the corpus");
    // Peak of the whole test process, all tests of this file together.
    let peak = penombre_sys::peak_rss().unwrap_or(0) >> 20;
    assert!(peak < 256, "{peak} MiB");
}

/// One small good file of every format, and of every variety of ours.
fn seeds() -> Vec<(Format, Vec<u8>)> {
    let data = (0..13 * 9 * 3).map(|i| (i * 37 % 101) as f32 / 100.0).collect();
    let image = Image::from_data(13, 9, 3, data).expect("the shape fits");
    let metadata = vec![("name".to_owned(), "text".to_owned())];
    let options = WriteOptions { metadata, ..WriteOptions::default() };
    let all = [
        Format::Png,
        Format::Jpeg,
        Format::Ppm,
        Format::Pgm,
        Format::Pfm,
        Format::Exr,
        Format::Hdr,
        Format::Tga,
        Format::Bmp,
        Format::Webp,
    ];
    let write = |format, options: &WriteOptions| {
        let mut bytes = Vec::new();
        encode(format, &image, options, &mut bytes).expect("the image can be written");
        (format, bytes)
    };
    let mut seeds: Vec<_> = all.into_iter().map(|f| write(f, &options)).collect();
    let mut layers = Layers::from_image(&image);
    layers.push(Layer::new("object-id").with("X", (0..13 * 9).collect::<Vec<u32>>())).expect("it fits");
    let mut layered = Vec::new();
    encode_layers(&layers, &options, &mut layered).expect("the layers can be written");
    seeds.push((Format::Exr, layered));
    seeds.push(write(Format::Ppm, &WriteOptions { course_ppm: true, ..options }));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let entries = std::fs::read_dir(folder).expect("test data").map(|e| e.expect("an entry").path());
    let mut paths: Vec<PathBuf> = entries.collect();
    paths.sort();
    for path in paths {
        let bytes = std::fs::read(&path).expect("test data");
        seeds.push((Format::of_file(&bytes, &path).expect("a known format"), bytes));
    }
    seeds
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    count_caught_panics();
    for (format, file) in seeds() {
        // A trailing blank or line feed of the text form, and the padding of our own files, may be missing.
        let spare = file.iter().rev().take_while(|b| b.is_ascii_whitespace()).count();
        // Without its last digit the last value of a text file is another one, but still a value.
        let spare = if file.starts_with(b"P3") { spare + 3 } else { 1 };
        // The mark at the end of a run-length coded BMP or of a GIF may lack; PNG and WebP say how long they are.
        let spare = match format {
            Format::Bmp => spare + 3,
            Format::Png | Format::Webp => 0,
            Format::Gif => 1,
            _ => spare,
        };
        for length in 0..file.len().saturating_sub(spare) {
            let result = decode(&file[..length], Path::new("cut"), ColorSpace::Auto);
            assert!(result.is_err(), "{format} cut to {length} of {} bytes was accepted", file.len());
            assert!(decode_layers(&file[..length], Path::new("cut")).is_err(), "{format} cut to {length}");
        }
    }
    assert_eq!(OURS.load(Ordering::Relaxed), 0, "panics in our own code");
}

#[test]
fn a_jpeg_file_that_ends_early_with_the_right_mark_is_refused() {
    let is_read = |bytes: &[u8]| decode(bytes, Path::new("a.jpg"), ColorSpace::Auto).is_ok();
    let (mut files, mut cuts) = (0, 0);
    for (_, file) in seeds().into_iter().filter(|(format, _)| *format == Format::Jpeg) {
        assert!(is_read(&file));
        files += 1;
        // Within the data of scans: with fewer scans a progressive file is whole, and only less sharp.
        let is_mark = |w: &[u8]| w[0] == 0xff && !matches!(w[1], 0 | 0xd0..=0xd7 | 0xff);
        let is_in_scan = |length: &usize| {
            let last = file[..*length].windows(2).rposition(is_mark).unwrap_or(0);
            let header = 2 + usize::from(file[last + 3]);
            file[last + 1] == 0xda
                && last + header <= *length
                && !file[*length - 1..*length + 2].windows(2).any(is_mark)
        };
        for length in (4..file.len() - 2).filter(is_in_scan) {
            let cut = [&file[..length], &[0xff, 0xd9]].concat();
            assert!(!is_read(&cut), "{length} of {} bytes", file.len());
            cuts += 1;
        }
    }
    assert!(files >= 4 && cuts > 200, "{files} {cuts}");
}

#[test]
fn mutated_files_never_panic_or_hang() {
    count_caught_panics();
    let rounds = if std::env::var_os("PENOMBRE_SLOW").is_some() { 100_000 } else { 1500 };
    let mut state = 0x1234_5678_9abc_def0u64;
    let mut next = move || {
        // xorshift64*
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16
    };
    let special = [0u8, 1, 0x7f, 0x80, 0xff, b'0', b'9', b'-', b' ', b'\n'];
    let before = CAUGHT.load(Ordering::Relaxed);
    for (format, file) in seeds() {
        let mut good = 0;
        for _ in 0..rounds {
            let mut bytes = file.clone();
            for _ in 0..1 + next() % 4 {
                // Half of the faults hit the header.
                let reach = if next() % 2 == 0 { bytes.len().min(64) } else { bytes.len() };
                let at = next() as usize % reach;
                match next() % 5 {
                    0 => bytes[at] = next() as u8,
                    1 => bytes[at] ^= 1 << (next() % 8),
                    2 => bytes[at] = special[next() as usize % special.len()],
                    3 => bytes.insert(at, special[next() as usize % special.len()]),
                    _ => drop(bytes.remove(at)),
                }
            }
            let start = Instant::now();
            good += usize::from(decode(&bytes, Path::new("mutant"), ColorSpace::Auto).is_ok());
            if format == Format::Exr {
                // Whatever is read can be written.
                if let Ok(found) = decode_layers(&bytes, Path::new("mutant")) {
                    let options = WriteOptions::default();
                    encode_layers(&found.layers, &options, &mut Vec::new()).expect("a sound picture");
                }
            }
            let time = start.elapsed();
            assert!(time < Duration::from_secs(2), "{format}: {time:?} for {}", bytes.escape_ascii());
        }
        assert!(good < rounds, "{format}: every damaged file was accepted");
    }
    let caught = CAUGHT.load(Ordering::Relaxed) - before;
    println!("{caught} panics of decoders were caught");
    assert_eq!(OURS.load(Ordering::Relaxed), 0, "panics in our own code");
}

/// Files that begin well, claim much and end soon: the memory goes with what is read, not with what is claimed.
#[test]
fn short_files_of_large_pictures_cost_little() {
    let picture = Image::new(4000, 3000, 3);
    for format in [Format::Png, Format::Jpeg, Format::Exr, Format::Webp, Format::Bmp, Format::Tga] {
        let mut file = Vec::new();
        encode(format, &picture, &WriteOptions::default(), &mut file).expect("written");
        file.truncate(file.len() / 8);
        let result = decode(&file, Path::new("cut"), ColorSpace::Auto);
        let error = result.err().unwrap_or_else(|| panic!("{format} was accepted")).to_string();
        assert!(error.contains("found") && error.contains("expected"), "{error}");
    }
}

/// A picture of 16 000 × 16 000 pixels that lacks its last bytes is refused without room for its 256 MB.
#[test]
fn a_large_png_is_known_to_be_whole_before_memory_is_taken() {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 16_000, 16_000);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::Fastest);
    let mut writer = encoder.write_header().expect("written");
    let mut rows = writer.stream_writer().expect("written");
    for _ in 0..16_000 {
        std::io::Write::write_all(&mut rows, &[0; 16_000]).expect("written");
    }
    rows.finish().expect("written");
    drop(writer);
    file.truncate(file.len() - 100);
    let error = decode(&file, Path::new("a.png"), ColorSpace::Auto).unwrap_err().to_string();
    assert!(error.contains("byte") && error.contains("expected"), "{error}");
    let peak = penombre_sys::peak_rss().unwrap_or(0) >> 20;
    assert!(peak < 256, "{peak} MiB");
}

#[test]
fn gigantic_sizes_are_refused_before_memory_is_taken() {
    let cases: [(&str, &[u8]); 13] = [
        ("P6 wide", b"P6 4294967295 4294967295 255\n"),
        ("P6", b"P6 16000 16000 255\n\0\0\0"),
        ("P4", b"P4 100000 100000\n\0"),
        ("P3", b"P3 16000 16000 255 1 2 3"),
        ("PFM", b"PF\n100000 2000\n-1.0\n\0\0\0\0"),
        ("PFM too", b"PF\n4294967296 1\n-1.0\n\0\0\0\0"),
        ("HDR", b"#?RADIANCE\n\n-Y 10000 +X 20000\n\x02\x02\x4e\x20"),
        ("HDR columns", b"#?RADIANCE\n\n+X 20000 -Y 10000\n\x02\x02\x4e\x20"),
        ("TGA", b"\0\0\x02\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x18\0\0\0\0"),
        ("TGA runs", b"\0\0\x0a\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x18\0\xff\0\0"),
        ("BMP", b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\xff\xff\0\0\xff\xff\xff\xff\x01\0\x18\0\0\0\0\0"),
        ("GIF", b"GIF89a\xff\xff\xff\xff\0\0\0,\0\0\0\0\x01\0\x01\0\0\x02\x02D\x01\0;"),
        ("HDR negative", b"#?RADIANCE\n\n-Y -5 +X 20000\n\x02\x02\x4e\x20"),
    ];
    for (name, bytes) in cases {
        let error = decode(bytes, Path::new(name), ColorSpace::Auto).unwrap_err().to_string();
        assert!(error.contains("found") && error.contains("expected"), "{error}");
    }
    // The attribute that is too long is named: magic number, version, then "channels", "chlist", 1 GiB.
    let exr = b"v/1\x01\x02\0\0\0channels\0chlist\0\0\0\0\x40";
    let error = decode(exr, Path::new("a.exr"), ColorSpace::Auto).unwrap_err().to_string();
    assert!(error.contains("byte 8") && error.contains("\"channels\" of 1073741824 bytes"), "{error}");
    for (text, hint) in
        [("P6 0 5 255\n", "at least one pixel"), ("P6 1 1 0\n1", "1 to 65535"), ("P6 1 x", "height")]
    {
        let error = decode(text.as_bytes(), Path::new("a"), ColorSpace::Auto).unwrap_err().to_string();
        assert!(error.contains(hint) && error.contains("byte"), "{error}");
    }
}

/// A block may claim as many bytes as a tile takes: found by fuzzing, a kilobyte took 1.7 GB.
#[test]
fn tiles_far_larger_than_the_picture_are_refused() {
    let mut file = include_bytes!("data/tiled-rle.exr").to_vec();
    let tiles = b"tiles\0tiledesc\0";
    let at = file.windows(tiles.len()).position(|w| w == tiles).expect("tiles") + tiles.len() + 4;
    assert!(decode(&file, Path::new("a.exr"), ColorSpace::Auto).is_ok());
    file[at..at + 4].copy_from_slice(&0x2B00_0008u32.to_le_bytes());
    let place = format!("byte {}", at - tiles.len() - 4);
    for error in [
        decode(&file, Path::new("a.exr"), ColorSpace::Auto).unwrap_err(),
        decode_layers(&file, Path::new("a.exr")).unwrap_err(),
    ] {
        let text = error.to_string();
        assert!(text.contains(&place) && text.contains("found tiles of 721420296 ×"), "{text}");
    }
}

/// A header of channels whose names are searched for each other: the time would grow with the square of their number.
#[test]
fn very_many_channels_are_refused() {
    let mut file = b"v/1\x01\x02\0\0\0channels\0chlist\0".to_vec();
    let mut list = Vec::new();
    for i in 0..100_000 {
        list.extend(format!("{i:06}.R\0").bytes());
        list.extend([[1u8, 0, 0, 0], [0; 4], [1, 0, 0, 0], [1, 0, 0, 0]].as_flattened());
    }
    list.push(0);
    file.extend((list.len() as u32).to_le_bytes());
    file.extend(list);
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        file.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        file.extend((value.len() as u32).to_le_bytes());
        file.extend(value);
    };
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &[0; 16]);
    attribute("displayWindow", "box2i", &[0; 16]);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    file.extend([0; 64]);
    let start = Instant::now();
    let errors = [
        decode(&file, Path::new("a"), ColorSpace::Auto).unwrap_err(),
        decode_layers(&file, Path::new("a")).unwrap_err(),
    ];
    for error in errors {
        assert!(error.to_string().contains("100000 channels"), "{error}");
    }
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
}

#[cfg(unix)]
#[test]
fn devices_without_end_are_not_read() {
    for device in ["/dev/zero", "/dev/null"] {
        let error = load(Path::new(device)).unwrap_err().to_string();
        assert!(error.contains(device) && error.contains("expected the start of a PNG"), "{error}");
    }
}
