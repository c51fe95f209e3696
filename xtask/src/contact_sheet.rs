//! One picture of all meshes, scenes and images of a folder, to be looked at.

use crate::run::{Call, Outcome, release_binary, root};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Edge of a picture, pixels, and the gap beside it.
const CELL: usize = 160;
const GAP: usize = 4;
const COLUMNS: usize = 8;

const SCENES: &[&str] = &["toml", "json", "obj", "ply", "stl", "off", "gz"];
const IMAGES: &[&str] =
    &["png", "jpg", "jpeg", "exr", "hdr", "pfm", "ppm", "pgm", "pbm", "tga", "bmp", "webp", "gif"];

/// 8-bit RGB.
struct Tile {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

/// Draws every file that can be drawn below the folder into `target/contact-sheet/sheet.png` and says of each its place and
/// what is suspect: black, or white for the most part.
pub fn run(folder: &str) -> Outcome {
    Call::cargo(&["build", "--release", "-p", "penombre-cli"]).status()?;
    let out = root().join("target/contact-sheet");
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let mut files = Vec::new();
    gather(Path::new(folder), &mut files)?;
    files.sort();
    let mut tiles = Vec::new();
    let mut refused = String::new();
    for file in &files {
        match draw(file, &out.join("tile.ppm")) {
            Ok(tile) => {
                let place = (tiles.len() / COLUMNS + 1, tiles.len() % COLUMNS + 1);
                println!("row {}, column {}: {}{}", place.0, place.1, file.display(), suspect(&tile));
                tiles.push(tile);
            }
            Err(message) => {
                let _ = writeln!(refused, "{}: {}", file.display(), message.trim());
            }
        }
    }
    if tiles.is_empty() {
        return Err(format!("nothing in {folder} could be drawn\n{refused}"));
    }
    let sheet = out.join("sheet.ppm");
    std::fs::write(&sheet, sheet_of(&tiles)).map_err(|e| format!("{}: {e}", sheet.display()))?;
    let png = out.join("sheet.png");
    let words = ["convert", &sheet.to_string_lossy(), "-o", &png.to_string_lossy()].map(str::to_owned);
    Call::new(release_binary(), &words.each_ref().map(String::as_str)).status()?;
    print!("\nrefused:\n{refused}");
    println!("{} pictures: {}", tiles.len(), png.display());
    Ok(())
}

/// All files below a folder whose ending says that they can be drawn.
fn gather(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| format!("{}: {e}", folder.display()))?.path();
        if path.is_dir() {
            gather(&path, files)?;
        } else if SCENES.contains(&ending(&path).as_str()) || IMAGES.contains(&ending(&path).as_str()) {
            files.push(path);
        }
    }
    Ok(())
}

fn ending(path: &Path) -> String {
    path.extension().map_or(String::new(), |e| e.to_string_lossy().to_ascii_lowercase())
}

/// Draws a file; or what the command says of it.
fn draw(file: &Path, tile: &Path) -> Result<Tile, String> {
    let (from, to) = (file.to_string_lossy(), tile.to_string_lossy());
    let words = if SCENES.contains(&ending(file).as_str()) {
        let size = format!("{CELL}x{CELL}");
        let options = ["--spp", "32", "--no-progress", "-q", "-o", &to].map(str::to_owned);
        [&["render".to_owned(), from.to_string(), "--size".to_owned(), size], &options[..]].concat()
    } else {
        ["convert", &from, "-q", "-o", &to].map(str::to_owned).to_vec()
    };
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    Call::new(release_binary(), &words).output()?;
    let bytes = std::fs::read(tile).map_err(|e| format!("{to}: {e}"))?;
    let tile = read_ppm(&bytes).ok_or_else(|| format!("{to} is no PPM"))?;
    Ok(fitted(&tile))
}

/// A binary PPM.
fn read_ppm(bytes: &[u8]) -> Option<Tile> {
    let mut at = 0;
    let mut word = || {
        let start = at + bytes[at..].iter().position(|b| !b.is_ascii_whitespace())?;
        let end = start + bytes[start..].iter().position(u8::is_ascii_whitespace)?;
        at = end + 1;
        std::str::from_utf8(&bytes[start..end]).ok()
    };
    let (magic, width, height, _) = (word()?, word()?.parse().ok()?, word()?.parse().ok()?, word()?);
    let rgb = bytes.get(at..)?.to_vec();
    (magic == "P6" && rgb.len() >= 3 * width * height).then_some(Tile { width, height, rgb })
}

/// Scaled to fit into a cell, by the mean of the pixels that fall together.
fn fitted(tile: &Tile) -> Tile {
    let scale = (tile.width.max(tile.height) as f64 / CELL as f64).max(1.0);
    let side = |n: usize| ((n as f64 / scale) as usize).clamp(1, CELL);
    let (width, height) = (side(tile.width), side(tile.height));
    let mut rgb = Vec::with_capacity(3 * width * height);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let range = |i: usize, n: usize, all: usize| i * all / n..((i + 1) * all / n).max(i * all / n + 1);
        let (rows, columns) = (range(y, height, tile.height), range(x, width, tile.width));
        let count = rows.len() * columns.len();
        for c in 0..3 {
            let row =
                |r: usize| columns.clone().map(move |k| usize::from(tile.rgb[3 * (r * tile.width + k) + c]));
            rgb.push((rows.clone().flat_map(row).sum::<usize>() / count) as u8);
        }
    }
    Tile { width, height, rgb }
}

/// What a person should look at.
fn suspect(tile: &Tile) -> &'static str {
    let pixels = tile.rgb.len() / 3;
    let count = |is: fn(&[u8]) -> bool| tile.rgb.chunks(3).filter(|p| is(p)).count();
    if count(|p| p.iter().all(|v| *v < 4)) * 100 > pixels * 98 {
        "  BLACK?"
    } else if count(|p| p.iter().all(|v| *v > 252)) * 2 > pixels {
        "  WHITE?"
    } else if tile.rgb.chunks(3).all(|p| p == &tile.rgb[..3]) {
        "  EMPTY?"
    } else {
        ""
    }
}

/// All tiles in rows.
fn sheet_of(tiles: &[Tile]) -> Vec<u8> {
    let step = CELL + GAP;
    let (width, height) = (COLUMNS * step, tiles.len().div_ceil(COLUMNS) * step);
    let mut rgb = vec![64; 3 * width * height];
    for (i, tile) in tiles.iter().enumerate() {
        let (left, top) = (i % COLUMNS * step, i / COLUMNS * step);
        for (y, row) in tile.rgb.chunks(3 * tile.width).take(tile.height).enumerate() {
            let start = 3 * ((top + y) * width + left);
            rgb[start..start + row.len()].copy_from_slice(row);
        }
    }
    let mut sheet = format!("P6\n{width} {height}\n255\n").into_bytes();
    sheet.append(&mut rgb);
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_scaled_and_placed() {
        let wide = read_ppm(&[&b"P6\n640 2 255\n"[..], &[100; 3840]].concat()).unwrap();
        let tile = fitted(&wide);
        assert_eq!((tile.width, tile.height), (CELL, 1));
        assert!(tile.rgb.iter().all(|v| *v == 100));
        assert_eq!(suspect(&tile), "  EMPTY?");
        let sheet = read_ppm(&sheet_of(&[tile])).unwrap();
        assert_eq!((sheet.width, sheet.height), (COLUMNS * (CELL + GAP), CELL + GAP));
        assert_eq!((sheet.rgb[0], sheet.rgb[3 * sheet.width]), (100, 64));
    }
}
