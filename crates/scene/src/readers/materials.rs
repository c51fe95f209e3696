//! Materials of OBJ files as nodes.

use super::faults::Faults;
use super::lexer::Token;
use super::looks::{Known, Looks};
use super::map::Map;
use super::mtl::{self, MtlMaterial};
use super::obj::ObjFile;
use super::{Folders, MeshTexture};
use crate::assets::{PathFault, UNREADABLE_HELP};
use crate::description::{Node, Role, Value};
use crate::diagnostic::Severity;
use crate::printable::harmless;
use crate::suggest::help_for;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Diffuse, specular and shininess of what has no material.
const PLAIN: ([f32; 3], [f32; 3], f32) = ([0.8; 3], [0.04; 3], 32.0);

/// Most materials that a file may use: each takes some kilobytes, and a word in the file.
const MOST_SLOTS: usize = 1 << 16;

/// What is used of surfaces about which nothing is said.
fn unsaid() -> Known {
    let (diffuse, specular, shininess) = PLAIN;
    (MtlMaterial { diffuse, specular, shininess, ..MtlMaterial::named(String::new()) }, Vec::new())
}

/// The material of surfaces about which nothing is said.
pub(super) fn plain(prefix: &str) -> Node {
    let (diffuse, specular, shininess) = PLAIN;
    Node::new(Role::Material, "phong", format!("{prefix}/default"))
        .with("diffuse", rgb(diffuse))
        .with("specular", rgb(specular))
        .with("shininess", short(shininess))
        .with("ambient", rgb(diffuse))
}

/// A colour as a value.
pub(super) fn rgb(color: [f32; 3]) -> Value {
    color.map(short).into()
}

/// The number with the fewest digits that rounds to `v`: what the file said, most likely.
pub(super) fn short(v: f32) -> f64 {
    v.to_string().parse().unwrap_or(f64::from(v))
}

/// Reads the libraries of an OBJ file and makes the nodes: those of its slots, what they are made of, and the images
/// that they use. `None` after an error.
pub(super) fn of_obj(
    file: &ObjFile<'_>,
    path: &Path,
    prefix: &str,
    folders: &Folders,
    faults: &mut Faults<'_>,
) -> Option<(Vec<Node>, Vec<MeshTexture>)> {
    if let Some(Some(first)) = file.slots.get(MOST_SLOTS) {
        let message = format!("found {} materials in use, expected at most {MOST_SLOTS}", file.slots.len());
        faults.error("obj::material", *first, message, "let surfaces that look alike share a material");
        return None;
    }
    let mut known: Vec<Known> = Vec::new();
    let mut sound = true;
    let (mut read, mut said, mut names) = (HashSet::new(), HashSet::new(), HashSet::new());
    for line in file.libraries.iter().filter(|line| said.insert(line.text)) {
        for library in libraries(*line, path, folders, faults) {
            if read.insert(library.clone()) {
                sound &= read_library(&library, (path, folders), faults, &mut known, &mut names);
            }
        }
    }
    let mut by_name: HashMap<&str, &Known> = HashMap::new();
    for material in &known {
        by_name.entry(&material.0.name).or_insert(material);
    }
    let unsaid = unsaid();
    let mut looks = Looks::new(file.slots.len(), prefix, folders);
    for slot in &file.slots {
        let Some(name) = slot else {
            looks.add(&unsaid, "default");
            continue;
        };
        let name_text = name.lossy();
        let material = by_name.get(name_text.as_str()).copied();
        if material.is_none() {
            undefined(*name, !file.libraries.is_empty(), &known, faults);
        }
        looks.add(material.unwrap_or(&unsaid), &name_text);
    }
    (sound && !faults.failed()).then(|| looks.finish())
}

fn undefined(name: Token<'_>, has_library: bool, known: &[Known], faults: &mut Faults<'_>) {
    if faults.is_hushed() {
        return;
    }
    let shown = match name.shortened() {
        unnamed if unnamed.is_empty() => "without a name".to_owned(),
        name => format!("`{name}`"),
    };
    let message = format!("the material {shown} is not defined: its faces are grey");
    let names: Vec<&str> = known.iter().map(|(m, _)| m.name.as_str()).collect();
    let help = match (has_library, names.is_empty()) {
        (false, _) => "the file names no library: add a line `mtllib FILE.mtl`".to_owned(),
        (true, true) => {
            "its libraries are missing or define nothing: a material begins with `newmtl NAME`".to_owned()
        }
        (true, false) => help_for(&name.lossy(), "its libraries define", &names),
    };
    faults.warning("obj::material", name, message, help);
}

/// `prefix/name`, with a number if another slot has that name. `taken`: the names so far, and the last number that
/// was given to others of that name.
pub(super) fn unique(name: &str, prefix: &str, taken: &mut HashMap<String, u32>) -> String {
    let shown: String =
        name.chars().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect();
    let shown = if shown.is_empty() { "unnamed" } else { &shown };
    let first = format!("{prefix}/{shown}");
    let mut wanted = first.clone();
    let mut number = taken.get(&first).copied().unwrap_or(1);
    while taken.contains_key(&wanted) {
        number += 1;
        wanted = format!("{first}-{number}");
    }
    taken.insert(first, number);
    taken.insert(wanted.clone(), 1);
    wanted
}

/// The libraries that a `mtllib` line names: the whole rest of the line if there is such a file, else names that end
/// in `.mtl`, else single words. What is not found gives a warning, what may not be read an error.
fn libraries(line: Token<'_>, obj: &Path, folders: &Folders, faults: &mut Faults<'_>) -> Vec<PathBuf> {
    let base = obj.parent().unwrap_or(Path::new(""));
    match find(&line.lossy(), base, folders) {
        Ok(path) => return vec![path],
        Err(fault) if fault.is_refusal() => {
            faults.error(fault.code(), line, fault.to_string(), fault.help());
            return Vec::new();
        }
        Err(_) => {}
    }
    let mut found = Vec::new();
    for name in parts(line) {
        let text = name.lossy();
        let exact = find(&text, base, folders);
        let is_exact = exact.is_ok();
        match exact.or_else(|e| beside(&text, base, folders, e)) {
            Ok(path) => {
                if !is_exact && let Some(message) = elsewhere(&name.shortened(), &path, folders, faults) {
                    faults.warning("obj::library", name, message, ELSEWHERE_HELP);
                }
                found.push(path);
            }
            Err(fault) if fault.is_refusal() => {
                faults.error(fault.code(), name, fault.to_string(), fault.help());
            }
            Err(_) if faults.is_hushed() => {}
            Err(fault) => {
                let message = format!("the material library is not read, its materials are grey: {fault}");
                faults.warning("obj::library", name, message, fault.help());
            }
        }
    }
    found
}

/// Finds a file; back slashes separate folders as on Windows.
fn find(name: &str, base: &Path, folders: &Folders) -> Result<PathBuf, PathFault> {
    folders.resolve(base, &name.replace('\\', "/"))
}

/// Tries something else after a file was not found. The first fault stays if that fails too.
fn if_missing(
    fault: PathFault,
    other: impl FnOnce() -> Result<PathBuf, PathFault>,
) -> Result<PathBuf, PathFault> {
    match fault {
        PathFault::Missing { .. } => other().map_err(|_| fault),
        fault => Err(fault),
    }
}

/// Finds a missing file by its last name beside the one that names it: files are often moved without their folder.
fn beside(name: &str, base: &Path, folders: &Folders, fault: PathFault) -> Result<PathBuf, PathFault> {
    let forward = name.replace('\\', "/");
    let Some((_, last)) = forward.rsplit_once('/') else { return Err(fault) };
    if_missing(fault, || folders.resolve(base, last))
}

const ELSEWHERE_HELP: &str = "name it relative to the file that names it";

/// What is said, once for each file, if it was found by its last name only.
fn elsewhere(name: &str, path: &Path, folders: &Folders, faults: &mut Faults<'_>) -> Option<String> {
    let found = folders.name_of(path);
    let is_new = faults.first(&format!("\nelsewhere {found}"));
    is_new.then(|| format!("there is no file `{name}`: `{found}` is used, which has its last name"))
}

/// Splits `my a.mtl b.mtl` into `my a.mtl` and `b.mtl`.
fn parts(line: Token<'_>) -> Vec<Token<'_>> {
    let mut parts = Vec::new();
    let mut start = 0;
    while start < line.text.len() {
        let rest = &line.text[start..];
        let blank = |b: &u8| b.is_ascii_whitespace();
        let ends =
            (0..rest.len()).filter(|i| rest.get(i + 1).is_none_or(blank) && !blank(&rest[*i])).map(|i| i + 1);
        let end = ends.clone().find(|end| rest[..*end].to_ascii_lowercase().ends_with(b".mtl"));
        let end = end.or_else(|| ends.clone().next()).unwrap_or(rest.len());
        parts.push(Token { text: &rest[..end], at: line.at + start });
        start += end + rest[end..].iter().take_while(|b| blank(b)).count();
    }
    parts
}

/// Reads a library that an OBJ file names, and finds the images of its materials. `names`: those of the materials so far.
/// False after an error.
fn read_library(
    path: &Path,
    (obj, folders): (&Path, &Folders),
    faults: &mut Faults<'_>,
    known: &mut Vec<Known>,
    names: &mut HashSet<String>,
) -> bool {
    let name = folders.name_of(path);
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(e) => {
            let end = faults.end();
            let message = format!("the material library `{name}` cannot be read: {e}");
            faults.warning("obj::library", end, message, UNREADABLE_HELP);
            return true;
        }
    };
    let mut faults = faults.companion(&bytes, path, &name);
    for material in mtl::parse(&bytes, names, &mut faults) {
        let find = |map: &Map| Some((map.clone(), image_of(map, path, obj, folders, &mut faults)?));
        let images = material.maps.iter().filter_map(find).collect();
        known.push((material, images));
    }
    !faults.failed()
}

/// Finds the image of a map: relative to the library, else to the OBJ file, else by its last name beside either.
fn image_of(
    map: &Map,
    library: &Path,
    obj: &Path,
    folders: &Folders,
    faults: &mut Faults<'_>,
) -> Option<PathBuf> {
    let folder = |file: &Path| file.parent().unwrap_or(Path::new("")).to_owned();
    let (near, far) = (folder(library), folder(obj));
    let found = folders
        .resolve(&near, &map.file)
        .or_else(|fault| if_missing(fault, || folders.resolve(&far, &map.file)));
    let is_exact = found.is_ok();
    let found = found
        .or_else(|fault| beside(&map.file, &near, folders, fault))
        .or_else(|fault| beside(&map.file, &far, folders, fault));
    match found {
        Ok(path) => {
            if !is_exact && let Some(message) = elsewhere(&harmless(&map.file), &path, folders, faults) {
                faults.at_span(Severity::Warning, "mtl::image", map.span, message, ELSEWHERE_HELP);
            }
            Some(path)
        }
        Err(fault) if fault.is_refusal() => {
            faults.at_span(Severity::Error, fault.code(), map.span, fault.to_string(), fault.help());
            None
        }
        Err(_) if faults.is_hushed() => None,
        Err(fault) => {
            let message = format!("{fault}: the plain {} is used", map.of.what());
            faults.at_span(Severity::Warning, "mtl::image", map.span, message, fault.help());
            None
        }
    }
}
