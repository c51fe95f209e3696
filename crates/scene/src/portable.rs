//! A loaded scene as it is written into a file of its own.

use crate::assets::base_folder;
use crate::description::{Node, Role, SceneDescription, ValueKind};
use crate::load::Loaded;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// What is to be written into a scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Portable {
    /// The nodes. Names of files are relative to the folder of the new file.
    pub description: SceneDescription,
    /// Folders that do not lie below the new file's, although files in them are needed: to be allowed by
    /// `--asset-root` when it is read.
    pub outside: Vec<PathBuf>,
}

impl Loaded {
    /// The scene as a file in `folder` says it: included files and changes from the command line are part of it; what
    /// mesh files bring is not, but for nodes that were changed.
    ///
    /// # Errors
    /// If a folder cannot be found.
    pub fn portable(&self, folder: &Path) -> std::io::Result<Portable> {
        let folder = whole(folder).canonicalize()?;
        let mut portable = Portable::default();
        for (id, node) in self.description.iter() {
            let brought = self.brought.get(&id);
            if brought.is_some_and(|brought| Arc::ptr_eq(brought, self.description.shared(id))) {
                continue;
            }
            // What a mesh file says has been made relative to the scene's folder.
            let said_in = match brought {
                Some(_) => self.folders.root.clone(),
                None => base_folder(node, &self.sources, &self.folders),
            };
            let mut node = node.clone();
            if let Some(name) = file_of(&node)
                && whole(&said_in).canonicalize()? != folder
            {
                let name = portable
                    .moved(&self.folders.resolve(&said_in, name).map_err(std::io::Error::other)?, &folder);
                node.set("file", name.into());
            }
            portable.description.add(node);
        }
        Ok(portable)
    }
}

impl Portable {
    /// The name of a file as seen from another folder.
    fn moved(&mut self, path: &Path, folder: &Path) -> String {
        let name = relative(path, folder);
        if let Some(own) =
            path.parent().filter(|own| !own.starts_with(folder) && !self.outside.iter().any(|o| o == own))
        {
            self.outside.push(own.to_owned());
        }
        name
    }
}

/// The file that a node names, if its role has files.
fn file_of(node: &Node) -> Option<&str> {
    let has_files = matches!(node.role, Role::Shape | Role::Texture | Role::Light);
    match &node.param("file").filter(|_| has_files)?.value.kind {
        ValueKind::String(name) => Some(name),
        _ => None,
    }
}

fn whole(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// A path as seen from a folder, both canonical, with forward slashes. It stays absolute if they have only the root of
/// the file system in common.
fn relative(path: &Path, folder: &Path) -> String {
    let common = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let is_named = |c: &Component<'_>| matches!(c, Component::Normal(_));
    if !path.components().take(common).any(|c| is_named(&c)) {
        return path.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(common).map(|_| "..".into());
    let down = path.components().skip(common).map(|c| c.as_os_str().to_string_lossy());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_told_from_where_one_stands() {
        let from = |path: &str, folder: &str| relative(Path::new(path), Path::new(folder));
        assert_eq!(from("/a/b/c.ply", "/a/b"), "c.ply");
        assert_eq!(from("/a/b/m/c.ply", "/a/b"), "m/c.ply");
        assert_eq!(from("/a/m/c.ply", "/a/b/x"), "../../m/c.ply");
        assert_eq!(from("/m/c.ply", "/a/b"), "/m/c.ply");
    }
}
