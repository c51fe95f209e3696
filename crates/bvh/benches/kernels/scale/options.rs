//! The command line.

use crate::options::count;
use std::path::PathBuf;

const USAGE: &str =
    "cargo xtask bench scale [--largest N] [--instances N] [--rays N] [--reps N] [--svg FILE] [--json]";

/// What the person asked for.
pub struct Options {
    /// Triangles of the largest mesh.
    pub largest: usize,
    /// Instances of the field; 0: none.
    pub instances: usize,
    /// Rays of each kind, about.
    pub rays: usize,
    /// How often each kernel traces them.
    pub reps: usize,
    /// Where a plot is to go.
    pub svg: Option<PathBuf>,
    /// Lines for a program instead of a table for a person.
    pub json: bool,
}

impl Options {
    /// Reads the words after the benchmark's name.
    pub fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self {
            largest: 10_000_000,
            instances: 1_000_000,
            rays: 200_000,
            reps: 5,
            svg: None,
            json: false,
        };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| format!("`{word}` needs a value\n\n{USAGE}"));
            match word.as_str() {
                "--largest" => options.largest = count(&value()?)?,
                "--instances" => {
                    let text = value()?;
                    options.instances = if text == "0" { 0 } else { count(&text)? };
                }
                "--rays" => options.rays = count(&value()?)?,
                "--reps" => options.reps = count(&value()?)?,
                "--svg" => options.svg = Some(value()?.into()),
                "--json" => options.json = true,
                "--" => {}
                _ => return Err(format!("unknown option `{word}`\n\n{USAGE}")),
            }
        }
        Ok(options)
    }
}
