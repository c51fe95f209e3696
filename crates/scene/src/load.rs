//! From the word on the command line to a description with its assets.

mod kind;
#[cfg(test)]
mod tests;

use crate::assets::{Assets, LoadObserver, PathFault, UNREADABLE_HELP, check_regular};
use crate::auto;
use crate::builtin;
use crate::description::{Node, NodeId, SceneDescription};
use crate::diagnostic::Diagnostics;
use crate::json::read_json;
use crate::native::Include;
use crate::readers::{Folders, MeshFormat, without_gz};
use crate::set;
use crate::span::{FileId, Sources, Span};
use crate::suggest::{help_for, nearest_file};
use crate::toml::read_toml;
use kind::{Content, FileKind};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Longest chain of files that include each other.
const LONGEST_CHAIN: usize = 64;
/// Largest scene file, bytes: big geometry belongs into mesh files, and places in texts are counted in 32 bits.
const LARGEST_SCENE: u64 = 1 << 30;

/// What the command line says about reading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// Further folders below which files may be read (`--asset-root`).
    pub asset_roots: Vec<PathBuf>,
    /// Changes of parameters (`--set PATH=VALUE`), applied in this order.
    pub sets: Vec<String>,
}

/// A scene as read, with everything that it names.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// The nodes, included files and changes from the command line applied.
    pub description: SceneDescription,
    /// The files that they name.
    pub assets: Assets,
    /// The texts that places point into.
    pub sources: Sources,
    /// The folders below which files were read.
    pub folders: Folders,
    /// Nodes that came with mesh files, as the files have them.
    pub(crate) brought: BTreeMap<NodeId, Arc<Node>>,
    /// All faults found so far.
    pub diagnostics: Diagnostics,
    /// What people call the scene: the built-in's name, or the file's name without folder and ending.
    pub name: String,
    /// True if the source is a mesh file, around which a scene was made.
    pub bare_mesh: bool,
    /// False if the source could not be read as a scene at all. The description is then no one's scene: to build
    /// it would only add faults that nobody made.
    pub readable: bool,
}

/// Loads a scene: a file (`.toml`, or a mesh, `.obj`, `.off`, `.ply` or `.stl`, perhaps with `.gz`), or a built-in by
/// its name. Never fails: faults are in the result.
pub fn load(source: &str, options: &LoadOptions) -> Loaded {
    load_observed(source, options, &())
}

/// The same; `observer` hears of the files that the scene names, and may forbid to decode them.
pub fn load_observed(source: &str, options: &LoadOptions, observer: &dyn LoadObserver) -> Loaded {
    let mut loader = Loader {
        loaded: Loaded::default(),
        folders: Folders::default(),
        chain: Vec::new(),
        done: Vec::new(),
        source,
        observer,
    };
    loader.folders.asset_roots.clone_from(&options.asset_roots);
    loader.loaded.name = source.to_owned();
    if let Some(scene) = builtin::builtin(source) {
        loader.loaded.description = scene;
        loader.loaded.readable = true;
    } else {
        loader.file(source);
    }
    loader.finish(&options.sets);
    loader.loaded
}

struct Loader<'a> {
    loaded: Loaded,
    folders: Folders,
    /// The files being read, each included by the one before it: canonical path and name.
    chain: Vec<(PathBuf, String)>,
    /// Canonical paths of all files read.
    done: Vec<PathBuf>,
    /// What the command line names.
    source: &'a str,
    observer: &'a dyn LoadObserver,
}

impl Loader<'_> {
    fn error(&mut self, code: &'static str, span: Span, message: String, help: String) {
        self.loaded.diagnostics.error(code, span, message).help = help;
    }

    /// The file that the command line names.
    fn file(&mut self, source: &str) {
        let path = Path::new(source);
        let plain = if MeshFormat::of_path(path).is_some() { without_gz(path) } else { path };
        self.loaded.name = plain.file_stem().map_or(source.into(), |s| s.to_string_lossy()).into_owned();
        if let Err(fault) = check_regular(path, source) {
            self.not_a_file(source, &fault);
            return;
        }
        let path = &self.root_at(path);
        let Some(bytes) = self.read(path, source, Span::NONE) else { return };
        match kind::of_file(path, &bytes) {
            Ok(FileKind { content: Content::Scene, guessed }) => {
                if guessed {
                    let message = format!("`{source}` is read as a scene, as its content suggests");
                    self.loaded.diagnostics.warning("load::no-ending", Span::NONE, message).help =
                        "give it a name that ends in .toml".to_owned();
                }
                self.loaded.readable = self.scene(path, source, &bytes, Span::NONE);
            }
            Ok(FileKind { content: Content::Mesh, .. }) => {
                let name = path.file_name().map_or(source.into(), |n| n.to_string_lossy());
                self.loaded.description = auto::bare_mesh(&name);
                (self.loaded.bare_mesh, self.loaded.readable) = (true, true);
            }
            Err(unreadable) => {
                self.error(
                    "load::kind",
                    Span::NONE,
                    format!("`{source}`: byte 0: {}", unreadable.message),
                    unreadable.help,
                );
            }
        }
    }

    /// Makes the file's folder the root. A symbolic link to another folder is followed, for what a file names stands
    /// beside the file itself and not beside a link to it. Returns the path of the file in its folder.
    fn root_at(&mut self, given: &Path) -> PathBuf {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
        let whole = |folder: &Path| {
            if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.canonicalize()
        };
        let (own, real) = (folder(given), given.canonicalize().unwrap_or_else(|_| given.to_owned()));
        let is_here = whole(&own).is_ok_and(|own| own == folder(&real));
        let path = if is_here { given.to_owned() } else { real };
        self.folders.root = folder(&path);
        path
    }

    fn not_a_file(&mut self, source: &str, fault: &PathFault) {
        if !matches!(fault, PathFault::Missing { .. }) {
            let message =
                fault.to_string().replace("expected a file", "expected a scene file or a built-in scene");
            let help = match fault {
                PathFault::Unreadable { .. } => fault.help(),
                _ => format!("{}; built-in scenes: {}", kind::KNOWN, builtin::NAMES.join(", ")),
            };
            self.error("load::not-a-file", Span::NONE, message, help);
            return;
        }
        let path = Path::new(source);
        let bare = path.components().count() == 1 && path.extension().is_none();
        let what = if bare { "file or built-in scene" } else { "file" };
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty() && !f.is_dir());
        let help = match (folder, nearest_file(path)) {
            (Some(folder), _) => format!("there is no folder `{}`", folder.display()),
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) => help_for(source, "built-in scenes", &builtin::NAMES),
        };
        self.error("load::missing", Span::NONE, format!("there is no {what} `{source}`"), help);
    }

    /// All bytes of a scene file.
    fn read(&mut self, path: &Path, name: &str, span: Span) -> Option<Vec<u8>> {
        let size = path.metadata().map_or(0, |m| m.len());
        let is_mesh = MeshFormat::of_path(path).is_some();
        if size > LARGEST_SCENE && !is_mesh {
            let message =
                format!("`{name}` has {size} bytes, expected a scene file of at most {LARGEST_SCENE}");
            self.error("load::too-large", span, message, "put big geometry into mesh files".to_owned());
            return None;
        }
        let bytes = if is_mesh { read_head(path) } else { std::fs::read(path) };
        if let Err(e) = &bytes {
            let message = format!("`{name}` cannot be read: {e}");
            self.error("load::unreadable", span, message, UNREADABLE_HELP.to_owned());
        }
        bytes.ok()
    }

    /// Reads a scene file with all that it includes; `at` is the place that includes it. False if it is neither TOML nor JSON.
    fn scene(&mut self, path: &Path, name: &str, bytes: &[u8], at: Span) -> bool {
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(e) => {
                self.not_text(path, name, bytes, e.valid_up_to());
                return false;
            }
        };
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        self.done.push(canonical.clone());
        self.chain.push((canonical, name.to_owned()));
        let file = self.loaded.sources.add(path, name, text.as_str());
        let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let read = if is_json { read_json } else { read_toml };
        let scene = read(&text, file, &mut self.loaded.diagnostics);
        let mut readable = scene.readable;
        if self.chain.len() > LONGEST_CHAIN && !scene.includes.is_empty() {
            let message =
                format!("`{name}` is the end of a chain of {LONGEST_CHAIN} includes, expected a shorter one");
            let help = "let one file include all the others".to_owned();
            self.error("load::include-depth", at, message, help);
        } else {
            for include in &scene.includes {
                readable &= self.include(path, include);
            }
        }
        self.merge(scene.description);
        self.chain.pop();
        readable
    }

    fn not_text(&mut self, path: &Path, name: &str, bytes: &[u8], at: usize) {
        // Replacement characters follow the valid part only, so the place is the same in the shown text.
        let shown = String::from_utf8_lossy(bytes);
        let file = self.loaded.sources.add(path, name, shown.as_ref());
        let span = Span { file, start: u32::try_from(at).unwrap_or(u32::MAX), len: 3 };
        let message = format!("`{name}`: byte {at}: found 0x{:02x}, expected text in UTF-8", bytes[at]);
        self.error("load::encoding", span, message, "save the file as UTF-8".to_owned());
    }

    /// Reads an included file, once. False if it cannot be read.
    fn include(&mut self, from: &Path, include: &Include) -> bool {
        let base = from.parent().unwrap_or(Path::new(""));
        let path = match self.folders.resolve(base, &include.name) {
            Ok(path) => path,
            Err(fault) => {
                self.error(fault.code(), include.span, fault.to_string(), fault.help());
                return false;
            }
        };
        if let Some(start) = self.chain.iter().position(|(p, _)| *p == path) {
            let mut chain: Vec<&str> = self.chain[start..].iter().map(|(_, name)| name.as_str()).collect();
            chain.push(chain[0]);
            let message = format!("`{}` includes itself: {}", chain[0], chain.join(" → "));
            self.error(
                "load::include-cycle",
                include.span,
                message,
                "remove one of these includes".to_owned(),
            );
            return false;
        }
        if self.done.contains(&path) {
            return true;
        }
        let name = self.name_of(&path);
        let Some(bytes) = self.read(&path, &name, include.span) else { return false };
        match kind::of_file(&path, &bytes) {
            Ok(FileKind { content: Content::Scene, .. }) => self.scene(&path, &name, &bytes, include.span),
            Ok(_) => {
                let message = format!("`{name}`: byte 0: found a mesh, expected a scene file");
                let help = "name it by `file` of a shape of type mesh".to_owned();
                self.error("load::kind", include.span, message, help);
                false
            }
            Err(fault) => {
                self.error(
                    "load::kind",
                    include.span,
                    format!("`{name}`: byte 0: {}", fault.message),
                    fault.help,
                );
                false
            }
        }
    }

    /// How messages call an included file: as seen from where the command was given, where that is possible.
    fn name_of(&self, path: &Path) -> String {
        let relative = self.folders.name_of(path);
        if Path::new(&relative).is_absolute() {
            return relative;
        }
        self.folders.root.join(relative).to_string_lossy().into_owned()
    }

    /// Adds the nodes of a file; two nodes of one role and name are a fault.
    fn merge(&mut self, description: SceneDescription) {
        for (id, node) in description.iter() {
            let Some(first) = self.loaded.description.find(node.role, &node.name) else {
                self.loaded.description.add_shared(description.shared(id).clone());
                continue;
            };
            let first = self.loaded.description.node(first).span;
            let place = self.loaded.sources.locate(first);
            let place = place.map_or(String::new(), |at| format!(": first in {}:{}", at.name, at.line));
            let message = format!("`{}` is defined twice{place}", node.path());
            let help = "rename or remove one of them; to change single values use --set".to_owned();
            self.error("load::defined-twice", node.span, message, help);
        }
    }

    /// Changes from the command line and assets.
    fn finish(&mut self, sets: &[String]) {
        if !self.loaded.readable {
            return;
        }
        self.loaded.folders = self.folders.clone();
        let Loaded { description, assets, sources, diagnostics, bare_mesh, brought, .. } = &mut self.loaded;
        let mut late: Vec<(&String, FileId)> = Vec::new();
        let mut early_faults = Diagnostics::default();
        for argument in sets {
            let file = sources.add(Path::new(""), set::SOURCE_NAME, argument.as_str());
            let mut faults = Diagnostics::default();
            set::apply(argument, file, description, &mut faults);
            // It may be about a node that comes with a mesh file.
            if faults.has_errors() {
                late.push((argument, file));
                early_faults.extend(faults);
            }
        }
        let nodes = description.len();
        *assets = Assets::load_observed(description, &self.folders, sources, diagnostics, self.observer);
        let ids = description.iter().map(|(id, _)| id).skip(nodes);
        *brought = ids.map(|id| (id, description.shared(id).clone())).collect();
        if *bare_mesh && let Err(bounds) = auto::complete(description, assets) {
            let message = format!("`{}`: byte 0: {}", self.source, auto::too_far(&bounds));
            diagnostics.error("mesh::too-far", Span::NONE, message).help = auto::TOO_FAR_HELP.to_owned();
        }
        if description.len() == nodes {
            diagnostics.extend(early_faults);
            return;
        }
        for (argument, file) in late {
            set::apply(argument, file, description, diagnostics);
        }
    }
}

/// The first bytes of a mesh file, enough to tell what it is: its reader reads it again.
fn read_head(path: &Path) -> std::io::Result<Vec<u8>> {
    use std::io::Read;
    let mut head = Vec::new();
    std::fs::File::open(path)?.take(64).read_to_end(&mut head)?;
    Ok(head)
}
