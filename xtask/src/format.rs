//! `cargo xtask fmt`: rustfmt over every source file.
//!
//! `cargo fmt` follows `mod` lines only, and does not see the modules that the renderer's registries declare.

use crate::run::{Call, Outcome, root};
use crate::tidy::Tree;

/// Formats every Rust file, or with `check` only tells which ones differ.
pub fn run(check: bool) -> Outcome {
    let tree = Tree::read(root())?;
    let mut arguments = vec!["--edition", "2024"];
    if check {
        arguments.push("--check");
    }
    arguments.extend(tree.rust().map(|file| file.path.as_str()));
    Call::new("rustfmt", &arguments).status()
}
