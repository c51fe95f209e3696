//! The command line.

use crate::limits::{parse_noise, parse_time};
use crate::memory::parse_memory;
use clap::{ArgAction, Args, Parser, Subcommand};
use penombre::film::FilmLayer;
use penombre::render::RenderSettings;
use penombre_image::{ColorSpace, ToneCurve};
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

/// A renderer: scene in, picture out.
#[derive(Debug, Parser)]
#[command(name = "penombre", version, about, arg_required_else_help = true, max_term_width = 110)]
pub struct Cli {
    #[command(flatten)]
    pub verbosity: Verbosity,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Args)]
pub struct Verbosity {
    /// Say nothing but errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more; twice: still more.
    #[arg(short, long, global = true, action = ArgAction::Count, conflicts_with = "quiet")]
    pub verbose: u8,
    /// Draw no progress bar.
    #[arg(long, global = true)]
    pub no_progress: bool,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene into images.
    Render(RenderArgs),
    /// Open a window: turn a scene, render it, save the image.
    View(ViewArgs),
    /// Tell what is inside a scene.
    Info(InfoArgs),
    /// Tell all faults of a scene, rendering nothing.
    Check(CheckArgs),
    /// Write images, or scenes, in other formats.
    Convert(ConvertArgs),
    /// Compare two images.
    Diff(DiffArgs),
    /// Follow the path of one sample of one pixel.
    Trace(TraceArgs),
    /// Print the scene format as a JSON Schema, for editors.
    Schema,
    /// Print completions for a shell.
    Completions(CompletionsArgs),
    /// Print the manual page, to be read with `man -l -`.
    Man,
}

/// A scene and what the command line changes of it.
#[derive(Debug, Default, Args)]
pub struct SceneArgs {
    /// A scene file (.toml, .json), a mesh (.obj, .off, .ply, .stl), or a built-in: sphere, square, cornell, sphere-as-given,
    /// cornell-as-given.
    pub scene: String,
    /// Override a parameter of the scene, e.g. `camera.fov=40` or `material.red.diffuse=[1,0,0]`; repeatable.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Also allow files below this folder, not only below the scene's; repeatable.
    #[arg(long, value_name = "DIR")]
    pub asset_root: Vec<PathBuf>,
    /// Most memory to take: 8G, 512M, 1.5GiB, or bytes; default: what the machine has free.
    ///
    /// It is estimated before files are decoded, and again before the scene is built: what would take more ends with
    /// status 2 and a list of what takes how much.
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, allow_hyphen_values = true)]
    pub memory_limit: Option<u64>,
    /// Width and height of the image, pixels.
    #[arg(long, value_name = "WxH", value_parser = RenderSettings::parse_size, allow_hyphen_values = true)]
    pub size: Option<[u32; 2]>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub spp: Option<u32>,
    /// The camera: its name, or its number from 0.
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    /// Another seed gives other noise.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,
    /// How light is computed: path, classic, direct, ao or aov; default: the scene's own, else path.
    ///
    /// path: all light, by chance. classic: the course's ray tracer. direct: light without a detour. ao: ambient occlusion.
    /// aov: a feature of the first surfaces, see `integrator.aov.layer`.
    #[arg(long, value_name = "NAME")]
    pub integrator: Option<String>,
    /// classic: 1 flat colour, 2 Phong and shadows, 3 and mirrors, 4 and glass.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=4))]
    pub phase: Option<u8>,
    /// classic: area lights act as points at their centre.
    #[arg(long)]
    pub hard_shadows: bool,
    /// Most path segments between camera and light.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub max_depth: Option<u32>,
    /// Send rays through the centres of pixels.
    #[arg(long)]
    pub disable_pixel_jitter: bool,
}

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// bash, elvish, fish, powershell or zsh.
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Write this file, repeatable; the format is the extension's: .png .jpg .ppm .pgm .pfm .exr .hdr .tga .bmp
    /// .webp; `-` is PNG on standard output. Default: the scene's name with .png in the current folder.
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Number of threads; default: all cores.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    /// Write .ppm files exactly as the course's program does: ASCII, one line, truncated, no gamma.
    #[arg(long)]
    pub course_ppm: bool,
    /// Tone curve of 8-bit outputs: srgb, raw, agx, aces, pbr-neutral or filmic; default: raw for classic, else srgb.
    ///
    /// srgb cuts what is brighter than white; raw does so too and has no gamma, like the course's images; agx is the base
    /// look of AgX; aces the look of ACES as fitted by Hill; pbr-neutral is Khronos PBR Neutral, which keeps base colours
    /// as they are; filmic is Hable's curve of Uncharted 2.
    #[arg(long, value_name = "CURVE")]
    pub tone: Option<ToneCurve>,
    /// Brightness of 8-bit outputs in powers of two.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_finite)]
    pub exposure: f32,
    /// Layers beside the colour, with commas between: albedo, depth, material-id, normal, object-id, position, samples,
    /// uv, variance. They are in each .exr output; beside an output of another format each is a file of its own,
    /// `image.depth.png`.
    ///
    /// Those of surfaces are of the first one that a ray meets, means over the pixel's samples. albedo: share of light that
    /// the surface scatters, plus what it emits, at most 1. depth: distance along the viewing direction, metres, 1e10
    /// where there is nothing. normal: world space, facing the viewer. position: world space, metres. object-id,
    /// material-id: numbers from 1, 0 for nothing, of the pixel's first sample. samples: how many the pixel has.
    /// variance: estimated variance of the pixel's mean.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = parse_layer)]
    pub aov: Vec<FilmLayer>,
    /// Stop when the estimated relative error of the image is below this, for example 0.02; at most after `--spp`, or
    /// 65536 samples per pixel.
    ///
    /// The error is the root of the mean over pixels and channels of variance / (mean² + 0.01): its square is the relMSE
    /// that `penombre diff` would find against the converged image. It is looked at after 32 samples per pixel, then at
    /// 48, 64, 80, 96, 112, 128, 160 and so on, and must be below with two standard errors to spare. The image is that
    /// of exactly so many samples: the same bits for any number of threads. For the estimate the samples are drawn in two
    /// halves, so the noise differs from that without it.
    #[arg(long, value_name = "X", value_parser = parse_noise, allow_negative_numbers = true)]
    pub noise: Option<f32>,
    /// Stop rendering after that time: seconds, or with a unit, 90s, 5min, 2h; at most after `--spp`, or 65536 samples
    /// per pixel. The image is that of a whole number of samples per pixel, at least 1.
    #[arg(long, value_name = "TIME", value_parser = parse_time, allow_hyphen_values = true)]
    pub time: Option<Duration>,
    /// Edge of the tiles in pixels; changes no bit of the image.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub tile: Option<u32>,
    /// At the end, one line of statistics on standard output.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ViewArgs {
    /// As for `render`: a scene, `--set`, `--asset-root`, `--size`; and what else the window's program `penombre-view`
    /// takes. `penombre-view --help` lists it.
    #[arg(value_name = "SCENE, OPTIONS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<OsString>,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// For programs.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// For programs: a list of faults.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The image or scene and its new name; with `-o`, one or several.
    ///
    /// Scenes, meshes and built-in scenes become .toml or .json: all in one file, with what `--set` changes, but without
    /// comments. A mesh becomes the scene that is made around it. Files that a scene names stay where they are.
    ///
    /// Of images are read PNG, JPEG, PPM/PGM/PBM, PFM, OpenEXR, Radiance, TGA, BMP, WebP, and the first frame of GIF, told by their
    /// content. The new name's extension is the format: .png .jpg .ppm .pgm .pfm .exr .hdr .tga .bmp .webp. Texts in the file
    /// are kept where the format has a place for them, alpha in .png .exr .tga .bmp .webp, layers from .exr to .exr.
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Write this file, repeatable; or a folder, with `--format`: each image or scene is written there under its name.
    #[arg(short, long, value_name = "FILE|FOLDER")]
    pub output: Vec<PathBuf>,
    /// Extension of the files in the folder, for example png or json.
    #[arg(long, value_name = "EXTENSION", requires = "output")]
    pub format: Option<String>,
    /// Tone curve of 8-bit outputs, as for `render`: srgb, raw, agx, aces, pbr-neutral or filmic; default: srgb, which gives
    /// an 8-bit image the same bytes.
    #[arg(long, value_name = "CURVE")]
    pub tone: Option<ToneCurve>,
    /// Brightness of 8-bit outputs in powers of two.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_finite)]
    pub exposure: f32,
    /// What the numbers of the image mean: auto, linear or srgb.
    ///
    /// auto: as the format says, whole numbers are sRGB and become linear light, floats are linear. linear: as they are, for
    /// normal maps and masks; to keep them so in 8 bits, add `--tone raw`. srgb: encoded whatever the format says.
    #[arg(long, value_name = "SPACE", default_value = "auto", value_parser = parse_color_space)]
    pub color_space: ColorSpace,
    /// Of scenes: override a parameter, as for `render`; repeatable.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Of scenes: also allow files below this folder; repeatable.
    #[arg(long, value_name = "DIR")]
    pub asset_root: Vec<PathBuf>,
}

#[derive(Debug, Args)]
pub struct DiffArgs {
    /// The image in question.
    pub a: PathBuf,
    /// The reference.
    pub b: PathBuf,
    /// For programs.
    #[arg(long)]
    pub json: bool,
    /// Write a picture of where they differ.
    #[arg(short, long, value_name = "HEATMAP")]
    pub output: Option<PathBuf>,
    /// Images count as equal if no value differs by more.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = parse_tolerance, allow_negative_numbers = true)]
    pub tolerance: f32,
}

#[derive(Debug, Args)]
pub struct TraceArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Column and row of the pixel, from 0 at the upper left.
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, allow_hyphen_values = true)]
    pub pixel: [u32; 2],
    /// Index of the sample, from 0.
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub sample: u32,
    /// For programs.
    #[arg(long)]
    pub json: bool,
}

fn parse_pixel(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(',').ok_or("expected X,Y, for example 120,80")?;
    let number =
        |s: &str| s.trim().parse::<u32>().map_err(|_| format!("found `{s}`, expected a whole number"));
    Ok([number(parts.0)?, number(parts.1)?])
}

fn parse_layer(text: &str) -> Result<FilmLayer, String> {
    FilmLayer::from_name(text).ok_or_else(|| penombre_scene::help_for(text, "layers", FilmLayer::NAMES))
}

fn parse_color_space(text: &str) -> Result<ColorSpace, String> {
    match text {
        "auto" => Ok(ColorSpace::Auto),
        "linear" => Ok(ColorSpace::Linear),
        "srgb" => Ok(ColorSpace::Srgb),
        _ => Err("expected one of auto, linear, srgb".to_owned()),
    }
}

fn parse_finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err("expected a number from -1e38 to 1e38".to_owned()),
    }
}

fn parse_tolerance(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(v) if v >= 0.0 => Ok(v),
        _ => Err("expected a number, 0 or more".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_sound() {
        <Cli as clap::CommandFactory>::command().debug_assert();
    }

    #[test]
    fn help_lists_all_tone_curves() {
        let mut command = <Cli as clap::CommandFactory>::command();
        for command_name in ["render", "convert"] {
            let command = command.find_subcommand_mut(command_name).unwrap();
            for help in [command.render_help().to_string(), command.render_long_help().to_string()] {
                for name in ToneCurve::NAMES {
                    assert!(help.contains(name), "{command_name}: {name}");
                }
            }
        }
    }

    #[test]
    fn help_lists_all_layers() {
        let mut command = <Cli as clap::CommandFactory>::command();
        let help = command.find_subcommand_mut("render").unwrap().render_help().to_string();
        for name in FilmLayer::NAMES {
            assert!(help.contains(name), "{name}");
        }
    }

    #[test]
    fn layers_are_suggested() {
        assert_eq!(parse_layer("object-id"), Ok(FilmLayer::ObjectId));
        assert!(parse_layer("normals").unwrap_err().contains("did you mean `normal`"));
    }

    #[test]
    fn pixels_are_read_strictly() {
        assert_eq!(parse_pixel("3,4"), Ok([3, 4]));
        assert!(parse_pixel("3").is_err() && parse_pixel("3,-4").is_err());
    }
}
