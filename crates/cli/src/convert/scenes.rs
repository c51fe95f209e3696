//! Scenes in other formats.

use super::{Fault, Job, fault, same_file};
use crate::args::{ConvertArgs, SceneArgs, Verbosity};
use crate::memory::Use;
use crate::scene::examine;
use crate::{Exit, report, terminal};
use penombre_image::{ColorSpace, Format};
use penombre_scene::builtin;
use penombre_scene::json::write_json;
use penombre_scene::load::Loaded;
use penombre_scene::readers::MeshFormat;
use penombre_scene::toml::write_toml;
use std::path::{Path, PathBuf};

/// Endings of scenes that are not read, or not written, by this version.
const OTHERS: [&str; 9] = ["gltf", "glb", "pbrt", "xml", "usd", "usda", "usdz", "blend", "fbx"];

fn ending(path: &Path) -> String {
    path.extension().map_or(String::new(), |e| e.to_string_lossy().to_ascii_lowercase())
}

/// How a scene is written into a file of that name.
fn writer(path: &Path) -> Option<fn(&penombre_scene::SceneDescription) -> String> {
    match ending(path).as_str() {
        "toml" => Some(write_toml),
        "json" => Some(write_json),
        _ => None,
    }
}

/// True for names of scenes and meshes.
fn is_scene(path: &Path) -> bool {
    writer(path).is_some() || MeshFormat::of_path(path).is_some() || OTHERS.contains(&ending(path).as_str())
}

/// True if scenes are to be written, and false if images are. Images do not become scenes, nor scenes images.
pub(super) fn are_wanted(jobs: &[Job]) -> Result<bool, Fault> {
    let kinds: Vec<bool> = jobs.iter().flat_map(|job| &job.outputs).map(|output| is_scene(output)).collect();
    for job in jobs {
        let input = job.input.to_string_lossy();
        let from_scene = is_scene(&job.input) || builtin::NAMES.contains(&&*input);
        for output in &job.outputs {
            let to_scene = is_scene(output);
            match (from_scene, to_scene) {
                (true, false) => {
                    let message = format!("{input} is a scene, and {} is not", output.display());
                    let help = format!("`penombre render {input} -o {}` renders it", output.display());
                    return fault(message, help);
                }
                (_, true) if writer(output).is_none() => {
                    let message = format!("{}: scenes are written as .toml or .json only", output.display());
                    return fault(message, "choose another extension");
                }
                (false, true) if Format::from_path(&job.input).is_ok() || ending(&job.input) == "gif" => {
                    let message = format!("{input} is an image, and {} a scene", output.display());
                    let help = "a scene shows an image as the `file` of a texture or of an environment light";
                    return fault(message, help);
                }
                _ => {}
            }
        }
    }
    let wanted = kinds.contains(&true);
    if wanted && kinds.contains(&false) {
        let message = "found images and scenes to be written, expected one of them".to_owned();
        return fault(message, "convert them one after the other");
    }
    Ok(wanted)
}

/// Checks what is for scenes alone.
pub(super) fn check(args: &ConvertArgs) -> Result<(), Fault> {
    if args.tone.is_some() || args.exposure != 0.0 || args.color_space != ColorSpace::Auto {
        let message =
            "`--tone`, `--exposure` and `--color-space` are for images, and these are scenes".to_owned();
        return fault(message, "leave them out");
    }
    Ok(())
}

/// Writes one scene; a scene with errors is not written.
pub(super) fn convert(job: &Job, args: &ConvertArgs, verbosity: &Verbosity) -> Exit {
    let scene = SceneArgs {
        scene: job.input.to_string_lossy().into_owned(),
        set: args.set.clone(),
        asset_root: args.asset_root.clone(),
        ..SceneArgs::default()
    };
    let mut loaded = examine(&scene, Use::Tell, verbosity).loaded;
    loaded.diagnostics.sort_by_place();
    report::print(&loaded.diagnostics, &loaded.sources, verbosity.quiet);
    if loaded.diagnostics.has_errors() {
        terminal::err(&format!("{}: nothing was written", scene.scene));
        return Exit::Usage;
    }
    let mut end = Exit::Done;
    for output in &job.outputs {
        if let Some(part) = loaded.sources.iter().map(|f| &f.path).find(|part| same_file(part, output)) {
            let message = format!("the new file would replace {}, a part of the scene", part.display());
            report::error(&message, "choose another name for the output");
            return Exit::Usage;
        }
        if let Err(error) = write(output, &loaded, verbosity) {
            report::error(&format!("the scene was not saved: {error}"), "");
            end = Exit::Failure;
        }
    }
    end
}

fn write(output: &Path, loaded: &Loaded, verbosity: &Verbosity) -> std::io::Result<()> {
    let portable = loaded.portable(output.parent().unwrap_or(Path::new("")))?;
    let Some(writer) = writer(output) else { return Ok(()) };
    let text = writer(&portable.description);
    penombre_sys::write_atomic(output, |w| w.write_all(text.as_bytes()))?;
    if verbosity.quiet {
        return Ok(());
    }
    terminal::out(&format!(
        "{}  {} nodes, from {}",
        output.display(),
        portable.description.len(),
        loaded.name
    ));
    if !portable.outside.is_empty() {
        let flags = |folders: &[PathBuf]| {
            let flag = |folder: &PathBuf| format!("--asset-root {}", folder.display());
            folders.iter().map(flag).collect::<Vec<_>>().join(" ")
        };
        terminal::err(&format!(
            "warning: {} names files that do not lie below its folder\n  help: render it with {}",
            output.display(),
            flags(&portable.outside)
        ));
    }
    Ok(())
}
