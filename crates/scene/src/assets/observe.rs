//! What a caller may learn and decide while files are read.

use super::AssetMemory;
use crate::description::SceneDescription;
use crate::diagnostic::Diagnostic;
use std::time::Duration;

/// Hears of the files that a scene names, and may forbid to decode them.
pub trait LoadObserver: Sync {
    /// Asked before files are decoded, perhaps twice: what images the mesh files name is known only when these are read.
    /// The description is as the files and the command line say; `memory` tells what the assets will take, estimated: it
    /// looks into all of the files. With an answer nothing more is decoded; it goes to the diagnostics.
    fn approve(
        &self,
        _description: &SceneDescription,
        _memory: &dyn Fn() -> AssetMemory,
    ) -> Option<Diagnostic> {
        None
    }

    /// Called as things happen, from any thread.
    fn on(&self, _event: LoadEvent<'_>) {}
}

/// Hears and forbids nothing.
impl LoadObserver for () {}

/// What happens while files are read.
#[derive(Clone, Copy, Debug)]
pub enum LoadEvent<'a> {
    /// So many further files will be read, of so many bytes.
    Found {
        /// Number of files.
        files: usize,
        /// Their length, bytes.
        bytes: u64,
    },
    /// A file was read, or could not be.
    Read(FileRead<'a>),
}

/// A file that was read.
#[derive(Clone, Copy, Debug)]
pub struct FileRead<'a> {
    /// How messages call it.
    pub name: &'a str,
    /// Its length, bytes.
    pub bytes: u64,
    /// What is in it.
    pub content: FileContent,
    /// How long that took.
    pub time: Duration,
}

/// What is in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileContent {
    /// A mesh of so many triangles.
    Mesh {
        /// Number of triangles.
        triangles: usize,
    },
    /// An image.
    Image {
        /// Width and height, pixels.
        size: [u32; 2],
    },
    /// The same bytes as another file's, whose content is used.
    Copy,
    /// Nothing that can be used.
    Fault,
}
