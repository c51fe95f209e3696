//! The graph of the workspace's crates, and where `unsafe` may stand.

use super::Finding;
use super::tree::Tree;

/// Folder of a crate, and which of ours it may import.
const IMPORTS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("sys", &[]),
    ("lab", &[]),
    ("image", &["math", "sys"]),
    ("bvh", &["math", "sys"]),
    ("scene", &["math", "sys", "image"]),
    ("penombre", &["math", "sys", "image", "bvh", "scene"]),
    ("cli", &["math", "sys", "image", "bvh", "scene", "penombre"]),
    ("view", &["math", "sys", "image", "bvh", "scene", "penombre"]),
    ("py", &["math", "sys", "image", "bvh", "scene", "penombre"]),
];

/// Crates that hold the project's `unsafe` code.
const UNSAFE: &[&str] = &["bvh", "sys", "py"];

/// A crate imports only crates below it; tests may import `lab` as well.
pub fn imports(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in &tree.files {
        let Some(name) = file.path.strip_prefix("crates/").and_then(|p| p.strip_suffix("/Cargo.toml")) else {
            continue;
        };
        let Some((_, allowed)) = IMPORTS.iter().find(|(folder, _)| *folder == name) else {
            findings.push(Finding::new(
                &file.path,
                1,
                "a crate without a line in the table of xtask's tidy/crates.rs",
            ));
            continue;
        };
        for (line, import, for_tests) in our_imports(&file.text) {
            let fits = allowed.contains(&import.as_str()) || (for_tests && import == "lab");
            if !fits {
                let message = format!("`{name}` must not import `{import}`: crates import downward only");
                findings.push(Finding::new(&file.path, line, message));
            }
        }
    }
    findings
}

/// Line, short name, and whether for tests only, of every dependency on a crate of ours.
fn our_imports(manifest: &str) -> Vec<(usize, String, bool)> {
    let mut found = Vec::new();
    let mut section = "";
    for (i, line) in manifest.lines().map(str::trim).enumerate() {
        let named = if line.starts_with('[') {
            section = line.trim_matches(['[', ']']);
            section.split_once("dependencies.").map(|(_, name)| name)
        } else if section.ends_with("dependencies") || line.starts_with("package") {
            let renamed = line.split_once("package = \"").map(|(_, rest)| rest);
            renamed.or_else(|| line.split(['=', '.', ' ']).next())
        } else {
            None
        };
        let end = |c: char| !(c.is_alphanumeric() || c == '-');
        let Some(name) = named.map(|n| n.trim_matches('"').split(end).next().unwrap_or_default()) else {
            continue;
        };
        if section.contains("dependencies") && (name == "penombre" || name.starts_with("penombre-")) {
            let short = name.strip_prefix("penombre-").unwrap_or(name).to_owned();
            found.push((i + 1, short, section.contains("dev-dependencies")));
        }
    }
    found
}

/// Every crate root forbids `unsafe`, save those that hold it.
pub fn forbid_unsafe(tree: &Tree) -> Vec<Finding> {
    let roots = tree.rust().filter(|f| f.path.ends_with("/src/lib.rs") || f.path.ends_with("/src/main.rs"));
    let missing = roots.filter(|f| {
        let holder = UNSAFE.iter().any(|name| f.path.starts_with(&format!("crates/{name}/")));
        !holder && !f.code.contains("#![forbid(unsafe_code)]")
    });
    missing.map(|f| Finding::new(&f.path, 1, "a crate root without `#![forbid(unsafe_code)]`")).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tree::tests::one;
    use super::*;

    fn lines(manifest: &str) -> Vec<usize> {
        imports(&one("crates/scene/Cargo.toml", manifest)).iter().map(|f| f.line).collect()
    }

    #[test]
    fn upward_imports_are_found_in_every_spelling() {
        let allowed =
            "[dependencies]\npenombre-math.workspace = true\n[dev-dependencies]\npenombre-lab = \"1\"";
        assert!(lines(allowed).is_empty());
        assert_eq!(lines("[dependencies]\npenombre-bvh.workspace = true"), [2]);
        assert_eq!(lines("[dependencies]\npenombre = { path = \"../penombre\" }"), [2]);
        assert_eq!(lines("[dependencies]\nx = { package = \"penombre-bvh\" }"), [2]);
        assert_eq!(lines("[dependencies.penombre-bvh]\nworkspace = true"), [1]);
        assert_eq!(lines("[dependencies.x]\npackage = \"penombre-cli\""), [2]);
        assert_eq!(lines("[target.\"cfg(unix)\".dependencies]\npenombre-cli.workspace = true"), [2]);
        assert_eq!(lines("[dependencies]\npenombre-lab.workspace = true"), [2]);
    }

    #[test]
    fn the_name_of_the_package_itself_is_no_import() {
        assert!(lines("[package]\nname = \"penombre-scene\"\n[[bin]]\nname = \"penombre\"").is_empty());
    }

    #[test]
    fn unknown_crates_need_a_line_in_the_table() {
        assert_eq!(imports(&one("crates/new/Cargo.toml", "")).len(), 1);
    }

    #[test]
    fn crate_roots_forbid_unsafe() {
        assert_eq!(forbid_unsafe(&one("crates/math/src/lib.rs", "// #![forbid(unsafe_code)]")).len(), 1);
        assert!(forbid_unsafe(&one("crates/math/src/lib.rs", "#![forbid(unsafe_code)]")).is_empty());
        assert!(forbid_unsafe(&one("crates/sys/src/lib.rs", "")).is_empty());
        assert!(forbid_unsafe(&one("crates/math/src/other.rs", "")).is_empty());
    }
}
