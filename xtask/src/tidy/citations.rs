//! Every source that a comment cites is in the bibliography.

use super::Finding;
use super::scan::line_of;
use super::tree::Tree;

const BIBLIOGRAPHY: &str = "docs/bibliography.md";

/// A citation in a comment, a name and a year in (escaped) brackets, needs an entry with the same key in the
/// bibliography.
pub fn entries(tree: &Tree) -> Vec<Finding> {
    let bibliography = tree.get(BIBLIOGRAPHY).map_or("", |f| f.text.as_str());
    let mut findings = Vec::new();
    for file in tree.rust() {
        for (at, key) in citations(&file.comments) {
            if !has_entry(bibliography, &key) {
                let message = format!("`[{key}]` has no entry in {BIBLIOGRAPHY}");
                findings.push(Finding::new(&file.path, line_of(&file.comments, at), message));
            }
        }
    }
    findings
}

/// An entry begins a line of the bibliography, perhaps as a list item.
fn has_entry(bibliography: &str, key: &str) -> bool {
    let begins = |line: &str| {
        let line = line.trim_start_matches(['-', '*', '#', ' ']).trim_start_matches("<a id=\"");
        line.trim_start_matches(['\\', '['])
            .strip_prefix(key)
            .is_some_and(|rest| rest.starts_with(['\\', ']']))
    };
    bibliography.lines().any(begins)
}

/// Offset and key of every citation.
fn citations(comments: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (at, _) in comments.match_indices('[') {
        let key: String = comments[at + 1..].chars().take_while(char::is_ascii_alphanumeric).collect();
        let rest = &comments[at + 1 + key.len()..];
        let escaped = comments[..at].ends_with('\\') && rest.starts_with("\\]");
        if (escaped || rest.starts_with(']')) && is_key(&key, escaped) {
            found.push((at, key));
        }
    }
    found
}

/// A capital, letters, digits, perhaps one letter. Unescaped brackets may be a link to a type such as `Vec3`, so
/// there a year of four digits is asked for.
fn is_key(key: &str, escaped: bool) -> bool {
    let stem = key.trim_end_matches(|c: char| c.is_ascii_lowercase());
    let stem = if key.len() - stem.len() <= 1 { stem } else { key };
    let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let letters = &stem[..stem.len() - digits];
    let named = letters.len() >= 2 && letters.starts_with(|c: char| c.is_ascii_uppercase());
    named && letters.chars().all(|c| c.is_ascii_alphabetic()) && digits >= if escaped { 1 } else { 4 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(comments: &str) -> Vec<String> {
        citations(comments).into_iter().map(|(_, key)| key).collect()
    }

    #[test]
    fn citations_are_told_from_links() {
        assert_eq!(
            keys("/// as in \\[PBRT4\\] and \\[Owen1995a\\]; // see [Woop2013]"),
            ["PBRT4", "Owen1995a", "Woop2013"]
        );
        assert!(keys("/// a [`Vec3`], [Vec3], [0, 1], [x], \\[0\\], [Vec3](link)").is_empty());
    }

    #[test]
    fn every_citation_needs_an_entry() {
        let source = (
            "crates/a/src/b.rs".to_owned(),
            "//! x\n/// \\[Woop2013\\] \\[Mine2020\\]\nlet a = b[Other2000];".into(),
        );
        let book =
            (BIBLIOGRAPHY.to_owned(), "# Sources\n- [Woop2013] Sven Woop\nsee [Mine2020]\n".to_owned());
        let found = entries(&Tree::of(vec![source, book]));
        assert_eq!(found.len(), 1);
        assert!(found[0].line == 2 && found[0].message.contains("[Mine2020]"));
        for entry in ["[Mine2020] x", "* \\[Mine2020\\] x", "### [Mine2020]"] {
            assert!(has_entry(entry, "Mine2020"), "{entry}");
        }
    }
}
