//! `cargo xtask tidy`: the house rules that a compiler does not know. Each rule is one function from the
//! [`tree::Tree`] to findings; `cargo test` runs them too.

mod calls;
mod citations;
mod crates;
mod lengths;
mod rooms;
mod scan;
mod tree;

use std::fmt;

use crate::run::{Outcome, root};
pub use tree::Tree;

/// One breach of a rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// File, from the root of the workspace.
    pub path: String,
    /// Line, from 1; 0 for the whole file.
    pub line: usize,
    /// What was found and why it is not wanted.
    pub message: String,
}

impl Finding {
    fn new(path: &str, line: usize, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), line, message: message.into() }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.path, self.line, self.message)
    }
}

/// Runs all rules over the workspace and prints what they find.
pub fn run() -> Outcome {
    let tree = Tree::read(root())?;
    let findings = check(&tree);
    for finding in &findings {
        println!("{finding}");
    }
    println!("tidy: {}", lengths::statistics(&tree));
    match findings.len() {
        0 => Ok(()),
        1 => Err("one breach of the house rules".into()),
        n => Err(format!("{n} breaches of the house rules")),
    }
}

/// All findings of all rules, by file and line.
fn check(tree: &Tree) -> Vec<Finding> {
    let rules: [fn(&Tree) -> Vec<Finding>; 11] = [
        crates::imports,
        crates::forbid_unsafe,
        rooms::imports,
        lengths::files,
        lengths::functions,
        lengths::percentile,
        calls::unfinished,
        calls::printing,
        calls::transcendental,
        calls::machine_paths,
        citations::entries,
    ];
    let mut findings: Vec<Finding> = rules.iter().flat_map(|rule| rule(tree)).collect();
    findings.sort_by(|a, b| (&a.path, a.line).cmp(&(&b.path, b.line)));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workspace_keeps_the_house_rules() {
        let tree = Tree::read(root()).unwrap();
        let findings = check(&tree);
        let lines: Vec<String> = findings.iter().map(Finding::to_string).collect();
        assert!(findings.is_empty(), "{} breaches:\n{}", findings.len(), lines.join("\n"));
    }

    #[test]
    fn findings_read_like_a_compilers() {
        assert_eq!(Finding::new("a/b.rs", 3, "too long").to_string(), "a/b.rs:3: too long");
    }
}
