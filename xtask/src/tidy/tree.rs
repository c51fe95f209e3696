//! The files of the workspace in memory, so that rules are pure functions and their tests need no disk.

use std::collections::BTreeSet;
use std::path::Path;

use super::scan;

/// Folders that hold nothing of ours to check.
const SKIPPED: &[&str] = &["target", "data", "__pycache__", "images", "corpus"];
/// Files that rules look at.
const SUFFIXES: &[&str] = &[".rs", ".py", ".toml", ".md", ".sh", ".yml"];

/// One text file.
#[derive(Debug)]
pub struct File {
    /// Path from the root, with `/`.
    pub path: String,
    /// The whole text.
    pub text: String,
    /// Rust only: code without comments and literals.
    pub code: String,
    /// Rust only: the same with tests blanked too (all of it in test files).
    pub product: String,
    /// Rust only: comments.
    pub comments: String,
}

/// All text files of the workspace.
#[derive(Debug)]
pub struct Tree {
    /// Sorted by path.
    pub files: Vec<File>,
    /// Absolute paths of this machine that must not occur in any file.
    pub machine_paths: Vec<String>,
}

impl Tree {
    /// Reads the workspace.
    ///
    /// # Errors
    /// A message that names the folder or file that cannot be read.
    pub fn read(root: &Path) -> Result<Self, String> {
        let mut found = Vec::new();
        walk(root, "", &mut found)?;
        let mut tree = Self::of(found);
        let folders = [Some(root), root.parent()].into_iter().flatten();
        let absolute = folders.filter(|f| f.components().count() > 1);
        tree.machine_paths.extend(absolute.map(|f| format!("{}/", f.display())));
        Ok(tree)
    }

    /// A tree of paths and texts.
    pub fn of(mut found: Vec<(String, String)>) -> Self {
        found.sort();
        let mut files: Vec<File> = found.into_iter().map(|(path, text)| file(path, text)).collect();
        let tests: BTreeSet<String> = files.iter().flat_map(test_modules).collect();
        for file in &mut files {
            if is_test_path(&file.path) || tests.iter().any(|t| is_module_file(&file.path, t)) {
                file.product = blank(&file.product);
            }
        }
        Self { files, machine_paths: Vec::new() }
    }

    /// The Rust files.
    pub fn rust(&self) -> impl Iterator<Item = &File> {
        self.files.iter().filter(|f| f.path.ends_with(".rs"))
    }

    /// The file at `path`.
    pub fn get(&self, path: &str) -> Option<&File> {
        self.files.iter().find(|f| f.path == path)
    }
}

fn file(path: String, text: String) -> File {
    if !path.ends_with(".rs") {
        return File { path, text, code: String::new(), product: String::new(), comments: String::new() };
    }
    let layers = scan::split(&text);
    let product = without_test_items(&layers.code);
    File { path, text, code: layers.code, product, comments: layers.comments }
}

fn walk(folder: &Path, path: &str, found: &mut Vec<(String, String)>) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let inner = if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
        let kind = entry.file_type().map_err(failed)?;
        if name.starts_with('.') || kind.is_symlink() {
            continue;
        }
        if kind.is_dir() && !SKIPPED.contains(&name.as_str()) {
            walk(&entry.path(), &inner, found)?;
        } else if kind.is_file() && SUFFIXES.iter().any(|s| name.ends_with(s)) {
            let text = std::fs::read_to_string(entry.path()).map_err(|e| format!("{inner}: {e}"))?;
            found.push((inner, text));
        }
    }
    Ok(())
}

fn is_test_path(path: &str) -> bool {
    let folders = ["/tests/", "/benches/", "/examples/"];
    path.ends_with("/tests.rs") || path.starts_with("tests/") || folders.iter().any(|f| path.contains(f))
}

fn blank(text: &str) -> String {
    text.chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect()
}

/// Offsets of every `#[cfg(test)]` or `#[cfg(all(test, …))]` and of the end of the item behind it.
fn test_items(code: &str) -> Vec<(usize, usize)> {
    let mut items = Vec::new();
    let plain = code.match_indices("#[cfg(test)]");
    for (at, attribute) in plain.chain(code.match_indices("#[cfg(all(test,")) {
        let start = at + attribute.len();
        let end = code[start..].find(['{', ';']).map_or(code.len(), |i| start + i);
        let end =
            if code[end..].starts_with('{') { scan::closing(code, end) } else { (end + 1).min(code.len()) };
        items.push((at, end));
    }
    items.sort_unstable();
    items
}

fn without_test_items(code: &str) -> String {
    let mut product = String::with_capacity(code.len());
    let mut at = 0;
    for (start, end) in test_items(code) {
        if start >= at {
            product.push_str(&code[at..start]);
            product.push_str(&blank(&code[start..end]));
            at = end;
        }
    }
    product.push_str(&code[at..]);
    product
}

/// Modules that a file declares for tests only: `#[cfg(test)] mod name;` as the path without `.rs` or `/mod.rs`.
fn test_modules(file: &File) -> Vec<String> {
    let folder = module_folder(&file.path);
    let names = test_items(&file.code).into_iter().filter_map(|(start, end)| {
        let item = file.code[start..end].strip_prefix("#[cfg(test)]")?.trim();
        let name = item.strip_suffix(';')?.rsplit_once("mod ")?.1;
        Some(format!("{folder}/{}", name.trim()))
    });
    names.collect()
}

/// Folder that holds the child modules of the module in `path`.
fn module_folder(path: &str) -> String {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    match name {
        "lib.rs" | "main.rs" | "mod.rs" => folder.to_owned(),
        _ => format!("{folder}/{}", name.trim_end_matches(".rs")),
    }
}

fn is_module_file(path: &str, module: &str) -> bool {
    path.strip_prefix(module).is_some_and(|rest| rest == ".rs" || rest.starts_with('/'))
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A tree of one file.
    pub fn one(path: &str, text: &str) -> Tree {
        Tree::of(vec![(path.to_owned(), text.to_owned())])
    }

    #[test]
    fn tests_are_blank_in_the_product() {
        let tree = one("crates/a/src/b.rs", "fn a() {}\n#[cfg(test)]\nmod tests { fn b() {} }\nfn c() {}");
        let product = &tree.files[0].product;
        assert!(product.contains("fn a") && product.contains("fn c") && !product.contains("fn b"));
        assert_eq!(product.lines().count(), 4);
    }

    #[test]
    fn modules_for_tests_in_files_of_their_own_are_blank_too() {
        let parent = ("crates/a/src/b.rs".to_owned(), "#[cfg(test)]\nmod brute;\nmod kept;".to_owned());
        let files = ["b/brute.rs", "b/brute/deep.rs", "b/kept.rs", "b/tests.rs"];
        let children = files.map(|f| (format!("crates/a/src/{f}"), "fn x() {}".to_owned()));
        let tree = Tree::of(std::iter::once(parent).chain(children).collect());
        let has_product =
            |f: &str| !tree.get(&format!("crates/a/src/{f}")).unwrap().product.trim().is_empty();
        assert_eq!(files.map(has_product), [false, false, true, false]);
    }
}
