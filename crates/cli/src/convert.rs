//! `penombre convert`.

mod scenes;

use crate::args::{ConvertArgs, Verbosity};
use crate::{Exit, report, terminal};
use penombre_image::{
    ColorSpace, Decoded, Format, ImageError, ToneCurve, WriteOptions, load_as, load_layers, save, save_layers,
};
use std::path::{Path, PathBuf};

/// What is read, for messages.
pub const READABLE: &str = "images are PNG, JPEG, PPM, PFM, OpenEXR, Radiance, TGA, BMP, WebP or GIF files";

/// Longest name of a text that every format keeps, in characters of ASCII.
const LONGEST_NAME: usize = 79;

/// Longest such text, bytes.
const LONGEST_TEXT: usize = 60_000;

/// One image or scene, and where it goes.
#[derive(Debug, PartialEq)]
struct Job {
    input: PathBuf,
    outputs: Vec<PathBuf>,
}

/// What is wrong with the command line, and what to do about it.
type Fault = (String, String);

/// Converts images or scenes. All are tried, whatever becomes of the others.
pub fn run(args: &ConvertArgs, verbosity: &Verbosity) -> Exit {
    let checked = |jobs: Vec<Job>| {
        let to_scenes = scenes::are_wanted(&jobs)?;
        if to_scenes { scenes::check(args) } else { check_images(&jobs, args) }?;
        check(&jobs).map(|()| (jobs, to_scenes))
    };
    let (jobs, to_scenes) = match jobs(args).and_then(checked) {
        Ok(checked) => checked,
        Err((message, help)) => {
            report::error(&message, &help);
            return Exit::Usage;
        }
    };
    let convert = if to_scenes { scenes::convert } else { convert };
    let ends: Vec<Exit> = jobs.iter().map(|job| convert(job, args, verbosity)).collect();
    // A file that is wrong weighs more than a disk that is full.
    let worst = [Exit::Usage, Exit::Failure].into_iter().find(|worst| ends.contains(worst));
    worst.unwrap_or(Exit::Done)
}

fn fault<T>(message: String, help: impl Into<String>) -> Result<T, Fault> {
    Err((message, help.into()))
}

/// `IN OUT`, or `IN… -o OUT`, where several need a folder and a format.
fn jobs(args: &ConvertArgs) -> Result<Vec<Job>, Fault> {
    let files = &args.files;
    if args.output.is_empty() {
        let [input, output] = &files[..] else {
            let help = "`penombre convert IN OUT`, or `penombre convert IN… -o FOLDER --format png`";
            let found = files.len();
            return fault(
                format!("found {found} file names, expected an image or scene and its new name"),
                help,
            );
        };
        return Ok(vec![Job { input: input.clone(), outputs: vec![output.clone()] }]);
    }
    let place = |input: &PathBuf, output: &PathBuf| match (&args.format, output.is_dir()) {
        (Some(format), true) => {
            let mut name = input.file_stem().unwrap_or_default().to_owned();
            name.push(format!(".{}", format.trim_start_matches('.')));
            Ok(output.join(name))
        }
        (None, true) => {
            let help = "add the format, for example `--format png`";
            fault(format!("the output {} is a folder", output.display()), help)
        }
        (Some(_), false) => {
            let help = "name a folder that exists, or leave `--format` out";
            fault(format!("`--format` is given, but {} is no folder", output.display()), help)
        }
        (None, false) if files.len() > 1 => {
            let message = format!("{} files cannot all become {}", files.len(), output.display());
            fault(message, "name a folder that exists, and add the format, for example `--format png`")
        }
        (None, false) => Ok(output.clone()),
    };
    let job = |input: &PathBuf| {
        let outputs = args.output.iter().map(|output| place(input, output)).collect::<Result<_, _>>()?;
        Ok(Job { input: input.clone(), outputs })
    };
    files.iter().map(job).collect()
}

/// Checks the names of the outputs before anything is read.
fn check(jobs: &[Job]) -> Result<(), Fault> {
    let mut seen: Vec<PathBuf> = Vec::new();
    for (job, output) in jobs.iter().flat_map(|job| job.outputs.iter().map(move |output| (job, output))) {
        let absolute = std::path::absolute(output).unwrap_or_else(|_| output.clone());
        if seen.contains(&absolute) {
            return fault(format!("two files would become {}", output.display()), "choose other names");
        }
        seen.push(absolute);
        if same_file(output, &job.input) {
            let message = format!("the new file would replace {}, the one it is made of", output.display());
            return fault(message, "choose another name for the output");
        }
        penombre_sys::check_writable(output)
            .or_else(|e| fault(format!("cannot write {e}"), "choose another place for the output"))?;
    }
    Ok(())
}

/// Checks what is for images alone.
fn check_images(jobs: &[Job], args: &ConvertArgs) -> Result<(), Fault> {
    let mut formats = Vec::new();
    for output in jobs.iter().flat_map(|job| &job.outputs) {
        formats
            .push(Format::from_path(output).or_else(|e| fault(e.to_string(), "choose another extension"))?);
    }
    let has_tone = args.tone.is_some() || args.exposure != 0.0;
    if has_tone && !formats.into_iter().any(Format::is_8_bit) {
        let message = "`--tone` and `--exposure` are for outputs of 8 bits, and there is none".to_owned();
        return fault(message, "leave them out: .exr, .hdr and .pfm hold the light as it is");
    }
    if !args.set.is_empty() || !args.asset_root.is_empty() {
        let message = "`--set` and `--asset-root` are for scenes, and these are images".to_owned();
        return fault(message, "leave them out");
    }
    Ok(())
}

/// True if both paths lead to one file that is there.
pub fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

fn convert(job: &Job, args: &ConvertArgs, verbosity: &Verbosity) -> Exit {
    let decoded = match load_as(&job.input, args.color_space) {
        Ok(decoded) => decoded,
        Err(error) => {
            report::error(&error.to_string(), READABLE);
            return Exit::Usage;
        }
    };
    let options = WriteOptions {
        tone: args.tone.unwrap_or(ToneCurve::Srgb),
        exposure: args.exposure,
        metadata: texts(&decoded, job, verbosity),
        ..WriteOptions::default()
    };
    let mut end = Exit::Done;
    for output in &job.outputs {
        if let Err(error) = write(output, job, &decoded, args, &options) {
            report::error(&format!("the image was not saved: {error}"), "");
            end = Exit::Failure;
        } else if !verbosity.quiet {
            let (w, h) = (decoded.image.width(), decoded.image.height());
            terminal::out(&format!("{}  {w}×{h}, from {}", output.display(), job.input.display()));
            warn_of_alpha(output, &decoded);
        }
    }
    end
}

/// OpenEXR files keep all the layers of another; every other way is one picture.
fn write(
    output: &Path,
    job: &Job,
    decoded: &Decoded,
    args: &ConvertArgs,
    options: &WriteOptions,
) -> Result<(), ImageError> {
    let both = decoded.format == Format::Exr && Format::from_path(output)? == Format::Exr;
    if both && args.color_space == ColorSpace::Auto {
        let layers = load_layers(&job.input)?.layers;
        return save_layers(output, &layers, options).map(drop);
    }
    save(output, &decoded.image, options)
}

/// The texts of the file that every format can hold. What it says of its tone curve is no longer true.
fn texts(decoded: &Decoded, job: &Job, verbosity: &Verbosity) -> Vec<(String, String)> {
    let fits = |(name, text): &&(String, String)| {
        (1..=LONGEST_NAME).contains(&name.len())
            && name.bytes().all(|b| b.is_ascii_graphic() || b == b' ')
            && name.trim() == name
            && text.len() <= LONGEST_TEXT
            && !text.contains('\0')
    };
    let texts = decoded.metadata.iter().filter(|(name, _)| name != "penombre:tone");
    let (kept, left): (Vec<_>, Vec<_>) = texts.partition(fits);
    if !left.is_empty() && !verbosity.quiet {
        terminal::err(&format!(
            "note: {}: {} texts were left out, which other formats cannot hold",
            job.input.display(),
            left.len()
        ));
    }
    kept.into_iter().cloned().collect()
}

fn warn_of_alpha(output: &Path, decoded: &Decoded) {
    let keeps = |f| matches!(f, Format::Png | Format::Exr | Format::Tga | Format::Bmp | Format::Webp);
    let is_cut_out = || decoded.image.pixels().any(|pixel| pixel.alpha().is_some_and(|a| a < 1.0));
    if !Format::from_path(output).is_ok_and(keeps) && is_cut_out() {
        terminal::err(&format!("note: {} has no place for alpha, which was left out", output.display()));
    }
}
