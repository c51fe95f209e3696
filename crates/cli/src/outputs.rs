//! Where images go: checked before the first sample, written whole or not at all.

use crate::report;
use penombre::film::FilmLayer;
use penombre_image::{Format, Layers, WriteOptions, layer_path};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Bytes of slack that must stay free on the disk.
const SPARE_BYTES: u64 = 1 << 20;

/// One output.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// A file; its extension decides the format.
    File(PathBuf),
    /// PNG on standard output.
    StandardOutput,
}

impl Output {
    /// The outputs that were asked for, or the default: the scene's name with `.png` in the current folder.
    pub fn all(asked: &[PathBuf], scene: &str) -> Vec<Self> {
        if asked.is_empty() {
            return vec![Self::File(PathBuf::from(format!("{scene}.png")))];
        }
        let output =
            |p: &PathBuf| if p == Path::new("-") { Self::StandardOutput } else { Self::File(p.clone()) };
        asked.iter().map(output).collect()
    }

    /// All files that it becomes with those layers.
    fn files(&self, layers: &[FilmLayer]) -> Vec<PathBuf> {
        let Self::File(path) = self else { return vec![PathBuf::from("-")] };
        let mut files = vec![path.clone()];
        if Format::from_path(path).ok() != Some(Format::Exr) {
            files.extend(layers.iter().map(|layer| layer_path(path, layer.name())));
        }
        files
    }

    /// Reports outputs that are asked for twice, `--course-ppm` without a file that it is for, and layers without a file
    /// that could hold them. True if all is well.
    pub fn check_all(outputs: &[Self], course_ppm: bool, layers: &[FilmLayer]) -> bool {
        let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
        let mut places: Vec<PathBuf> = Vec::new();
        for file in outputs.iter().flat_map(|o| o.files(layers)) {
            if places.contains(&absolute(&file)) {
                report::error(&format!("the output {} is asked for twice", file.display()), "name it once");
                return false;
            }
            places.push(absolute(&file));
        }
        if !layers.is_empty() && !outputs.iter().any(|o| matches!(o, Self::File(_))) {
            let message = "`--aov` is given, but there is no file for the layers";
            report::error(message, "standard output takes the colour only: add `-o image.exr`");
            return false;
        }
        let is_ppm = |place: &PathBuf| place.extension().is_some_and(|e| e.eq_ignore_ascii_case("ppm"));
        if course_ppm && !places.iter().any(is_ppm) {
            report::error("`--course-ppm` is given, but no output ends in .ppm", "add `-o rendu.ppm`");
            return false;
        }
        true
    }

    /// How messages call it.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::StandardOutput => "-".to_owned(),
        }
    }

    /// Reports an extension that is not known, a folder that is not there or not writable, and a disk that is
    /// too full for an image of that size with so many layers. True if all is well.
    pub fn check(&self, size: [u32; 2], layers: &[FilmLayer]) -> bool {
        let Self::File(path) = self else { return true };
        if path.is_dir() {
            report::error(&format!("cannot write {}: it is a folder", path.display()), "name a file in it");
            return false;
        }
        if let Err(error) = Format::from_path(path) {
            report::error(&error.to_string(), "name the output with one of the extensions");
            return false;
        }
        if let Err(error) = penombre_sys::check_writable(path) {
            let help = "nothing was rendered; choose another place with `-o FILE`";
            report::error(&format!("cannot write {error}"), help);
            return false;
        }
        for file in &self.files(layers)[1..] {
            if file.is_dir() {
                report::error(
                    &format!("cannot write {}: it is a folder", file.display()),
                    "choose another name",
                );
                return false;
            }
        }
        // The largest format takes four bytes for each of three channels, and a header.
        let pictures = 1 + layers.len() as u64;
        let needed = pictures * (u64::from(size[0]) * u64::from(size[1]) * 12 + SPARE_BYTES);
        match penombre_sys::available_space(path) {
            Some(free) if free < needed => {
                let message = format!(
                    "cannot write {}: {} MiB free on that disk, {} MiB may be needed",
                    path.display(),
                    free >> 20,
                    needed >> 20
                );
                report::error(&message, "nothing was rendered; free some space or choose another disk");
                false
            }
            _ => true,
        }
    }

    /// Writes the layers, or the colour if there is no place for others, and tells the files. `None` if a file could
    /// not be written; the fault is reported.
    pub fn write(&self, layers: &Layers, options: &WriteOptions) -> Option<Vec<String>> {
        let written = match self {
            Self::File(path) => penombre_image::save_layers(path, layers, options)
                .map(|files| files.iter().map(|f| f.display().to_string()).collect())
                .map_err(|e| e.to_string()),
            Self::StandardOutput => to_standard_output(layers, options).map(|()| vec![self.name()]),
        };
        let told = written.map_err(|e| report::error(&format!("the image was not saved: {e}"), ""));
        told.ok()
    }
}

/// The whole file is made first: a reader gets it or nothing.
fn to_standard_output(layers: &Layers, options: &WriteOptions) -> Result<(), String> {
    let mut bytes = Vec::new();
    let color = layers.get("").ok_or("there is no colour")?;
    let image = color.to_image(layers.width(), layers.height()).map_err(|e| e.to_string())?;
    penombre_image::encode(Format::Png, &image, options, &mut bytes).map_err(|e| e.to_string())?;
    let mut stdout = std::io::stdout().lock();
    stdout
        .write_all(&bytes)
        .and_then(|()| stdout.flush())
        .map_err(|e| format!("cannot write to standard output: {e}"))
}
