//! "Did you mean": the known name nearest to a misspelt one.

use std::path::Path;

/// Names longer than this many characters are not compared: no known name is as long.
const LONGEST: usize = 64;
/// Names compared: scenes may have very many.
const MOST_COMPARED: usize = 4096;

/// The name among `names` that `wanted` probably means: equal but for case or the choice between `-` and `_`, or at
/// most a third of its letters away (at least one). `None` if none is near; ties go to the one nearer in upper and
/// lower case, then to the first.
pub fn nearest<'a>(wanted: &str, names: &[&'a str]) -> Option<&'a str> {
    let length = wanted.chars().count();
    if length == 0 || length > LONGEST {
        return None;
    }
    let plain = folded(wanted);
    let limit = (length / 3).max(1);
    let near =
        names.iter().take(MOST_COMPARED).map(|n| (strsim::damerau_levenshtein(&plain, &folded(n)), *n));
    near.filter(|(d, _)| *d <= limit)
        .min_by_key(|(d, n)| (*d, strsim::damerau_levenshtein(wanted, n)))
        .map(|(_, n)| n)
}

fn folded(name: &str) -> String {
    name.to_lowercase().replace('_', "-")
}

/// The help of a message about an unknown name: "did you mean `x`? " if one is near, then all that are known.
pub fn help_for(wanted: &str, what: &str, names: &[&str]) -> String {
    let known = match names {
        [] => format!("there are no {what}"),
        _ => format!("{what}: {}", listed(names)),
    };
    match nearest(wanted, names) {
        Some(name) => format!("did you mean `{name}`? {known}"),
        None => known,
    }
}

/// The name in the folder of `path` that is nearest to the file's. `None` if none is near.
pub fn nearest_file(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_str()?;
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).ok()?.take(MOST_COMPARED);
    let mut names: Vec<String> = entries.filter_map(|e| e.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    nearest(wanted, &names).map(str::to_owned)
}

/// At most 24 names, each cut after 64 characters, separated by commas, and how many more there are.
fn listed(names: &[&str]) -> String {
    const MOST: usize = 24;
    let short = |name: &&str| match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => (*name).to_owned(),
    };
    let mut text = names.iter().take(MOST).map(short).collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        text.push_str(&format!(" and {} more", names.len() - MOST));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_misspellings_and_leaves_strangers_alone() {
        let names = ["radius", "center", "material", "shadow_samples"];
        assert_eq!(nearest("radus", &names), Some("radius"));
        assert_eq!(nearest("Center", &names), Some("center"));
        assert_eq!(nearest("centre", &names), Some("center"));
        assert_eq!(nearest("shadow-samples", &names), Some("shadow_samples"));
        assert_eq!(nearest("fov", &names), None);
        assert_eq!(nearest("cub.obj", &["CUBE.OBJ", "Cube.obj", "cube.obj"]), Some("cube.obj"));
        assert_eq!(nearest("CUB.OBJ", &["cube.obj", "CUBE.OBJ"]), Some("CUBE.OBJ"));
        assert_eq!(nearest("", &names), None);
        assert_eq!(nearest(&"x".repeat(1000), &names), None);
    }

    #[test]
    fn help_lists_what_is_known() {
        assert_eq!(help_for("rad", "names", &["red"]), "did you mean `red`? names: red");
        assert_eq!(help_for("green", "names", &["red", "blue"]), "names: red, blue");
        assert_eq!(help_for("green", "textures", &[]), "there are no textures");
        let many: Vec<String> = (0..30).map(|i| format!("long-name-{i}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert!(help_for("x", "names", &many).ends_with("long-name-23 and 6 more"));
        assert_eq!(help_for("x", "names", &[&"é".repeat(65)]), format!("names: {}…", "é".repeat(64)));
    }
}
