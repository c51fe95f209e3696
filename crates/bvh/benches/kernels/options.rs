//! The command line.

use std::path::PathBuf;

const USAGE: &str =
    "cargo xtask bench kernels|agree [--only NAME-PART] [--mesh FILE]… [--rays N] [--reps N] [--json]";

/// What the person asked for.
pub struct Options {
    /// Built-in meshes run if their name contains this; `None`: all of them.
    only: Option<String>,
    /// Files to be measured as well.
    pub meshes: Vec<PathBuf>,
    /// Rays of each kind, about.
    pub rays: usize,
    /// How often each kernel traces them.
    pub reps: usize,
    /// Lines for a program instead of a table for a person.
    pub json: bool,
}

impl Options {
    /// Reads the words after the program's name; `rays` unless they say otherwise. Cargo adds `--bench`, which says
    /// nothing.
    pub fn parse(mut words: impl Iterator<Item = String>, rays: usize) -> Result<Self, String> {
        let mut options = Self { only: None, meshes: Vec::new(), rays, reps: 5, json: false };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| format!("`{word}` needs a value\n\n{USAGE}"));
            match word.as_str() {
                "--only" => options.only = Some(value()?),
                "--mesh" => options.meshes.push(value()?.into()),
                "--rays" => options.rays = count(&value()?)?,
                "--reps" => options.reps = count(&value()?)?,
                "--json" => options.json = true,
                "--bench" | "--" => {}
                _ => return Err(format!("unknown option `{word}`\n\n{USAGE}")),
            }
        }
        Ok(options)
    }

    /// Whether the built-in mesh of this name is to run.
    pub fn wants(&self, name: &str) -> bool {
        self.only.as_ref().is_none_or(|part| name.contains(part.as_str()))
    }
}

/// A whole number above 0.
pub fn count(text: &str) -> Result<usize, String> {
    let number = text.replace('_', "").parse().ok().filter(|n| *n > 0);
    number.ok_or_else(|| format!("`{text}` is no whole number above 0"))
}
