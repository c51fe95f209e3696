//! The graph of the rooms inside the crate `penombre`.

use super::Finding;
use super::scan::{closing, is_word_at, line_of};
use super::tree::{File, Tree};

/// A room imports only rooms before it.
const ROOMS: &[&str] = &[
    "texture",
    "shape",
    "bsdf",
    "material",
    "medium",
    "light",
    "camera",
    "scene",
    "sampler",
    "film",
    "integrator",
    "render",
];
/// Modules of the crate that are no rooms: they serve all of them.
const COMMON: &[&str] = &["registry", "lib"];
const HOME: &str = "crates/penombre/src/";

/// Each room of `penombre` uses only rooms before it; tests are free.
pub fn imports(tree: &Tree) -> Vec<Finding> {
    let exports = tree.get(&format!("{HOME}lib.rs")).map(|f| exports(&f.product)).unwrap_or_default();
    let mut findings = Vec::new();
    for file in tree.rust().filter(|f| f.path.starts_with(HOME)) {
        let module = file.path[HOME.len()..].trim_end_matches(".rs");
        let room = module.split('/').next().unwrap_or_default();
        let Some(place) = ROOMS.iter().position(|&r| r == room) else {
            let only_for_tests = file.product.trim().is_empty();
            if !COMMON.contains(&room) && !only_for_tests {
                let message = format!("`{room}` is no room of the crate: {}", ROOMS.join(", "));
                findings.push(Finding::new(&file.path, 1, message));
            }
            continue;
        };
        for (at, name) in crate_paths(file, module) {
            let target =
                exports.iter().find(|(export, _)| *export == name).map_or(name.as_str(), |(_, room)| room);
            if ROOMS.iter().position(|&r| r == target).is_some_and(|other| other > place) {
                let message = format!("room `{room}` must not use `{target}`, which comes after it");
                findings.push(Finding::new(&file.path, line_of(&file.product, at), message));
            }
        }
    }
    findings
}

/// Names at the crate's root that a file uses: offset and first segment behind `crate::` or enough `super::`.
fn crate_paths(file: &File, module: &str) -> Vec<(usize, String)> {
    let code = &file.product;
    let depth = module.split('/').filter(|&part| part != "mod").count();
    let mut found = Vec::new();
    for (prefix, text) in [("crate", "crate::".to_owned()), ("super", "super::".repeat(depth))] {
        for (at, _) in code.match_indices(&text) {
            let deeper = code[..at].ends_with("::") || code[at + text.len()..].starts_with("super");
            if !deeper && is_word_at(code, at, prefix) {
                found.extend(first_segments(code, at + text.len()).into_iter().map(|name| (at, name)));
            }
        }
    }
    found
}

/// `a` of `a::b`, or `a` and `c` of `{a::b, c}`.
fn first_segments(code: &str, at: usize) -> Vec<String> {
    if !code[at..].starts_with('{') {
        return vec![word(&code[at..])];
    }
    let group = &code[at + 1..closing(code, at).saturating_sub(1).max(at + 1)];
    split_top(group).iter().map(|part| word(part.trim())).collect()
}

fn word(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Parts between commas that lie in no inner group.
fn split_top(group: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0_usize, 0, Vec::new());
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&group[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&group[start..]);
    parts
}

/// Names that the crate's root re-exports, each with the room it comes from.
fn exports(code: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for line in code.split(';').map(str::trim) {
        let Some((room, names)) = line.rsplit_once("pub use ").and_then(|(_, path)| path.split_once("::"))
        else {
            continue;
        };
        let names = names.trim_matches(['{', '}']);
        found.extend(split_top(names).iter().map(|n| (last_name(n), room.to_owned())));
    }
    found
}

/// `c` of `a::b as c` and of `a::c`.
fn last_name(path: &str) -> String {
    let renamed = path.rsplit(" as ").next().unwrap_or(path);
    renamed.rsplit("::").next().unwrap_or(renamed).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(path: &str, text: &str) -> usize {
        let root = "pub use render::{Event, Job};\npub use scene::Scene;";
        let files = vec![("lib.rs", root), (path, text)];
        let files = files.into_iter().map(|(p, t)| (format!("{HOME}{p}"), t.to_owned())).collect();
        imports(&Tree::of(files)).len()
    }

    #[test]
    fn rooms_use_rooms_before_them() {
        assert_eq!(found("light/quad.rs", "use crate::shape::Quad;\nuse crate::light::X;"), 0);
        assert_eq!(found("light/quad.rs", "use crate::scene::Scene;"), 1);
        assert_eq!(found("light.rs", "fn f() { crate::render::go() }"), 1);
        assert_eq!(found("light/quad.rs", "// crate::scene\nlet a = \"crate::scene\";"), 0);
    }

    #[test]
    fn groups_supers_and_reexports_are_no_way_out() {
        assert_eq!(found("light/quad.rs", "use crate::{shape::{A, B}, film::F, render::R};"), 2);
        assert_eq!(found("light/quad.rs", "use super::super::scene::Scene;"), 1);
        assert_eq!(found("light/mod.rs", "use super::scene::Scene;"), 1);
        assert_eq!(found("light/quad.rs", "use super::scene::Local;"), 0);
        assert_eq!(found("light/quad.rs", "use crate::Scene;"), 1);
        assert_eq!(found("render/mod.rs", "use crate::Scene;"), 0);
        assert_eq!(found("film/mod.rs", "use crate::{Job, Event};"), 2);
    }

    #[test]
    fn tests_are_free_and_new_rooms_are_told() {
        assert_eq!(found("light/quad.rs", "#[cfg(test)]\nmod tests { use crate::scene::Scene; }"), 0);
        assert_eq!(found("cellar/mod.rs", "fn a() {}"), 1);
        assert_eq!(found("cellar/tests.rs", "fn a() {}"), 0);
        assert_eq!(found("registry.rs", "use crate::scene::Scene;"), 0);
    }
}
