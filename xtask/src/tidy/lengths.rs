//! Files and functions stay short.

use super::Finding;
use super::scan::{closing, is_word_at, line_of};
use super::tree::{File, Tree};

const FILE_LINES: usize = 600;
const FUNCTION_LINES: usize = 120;
const FUNCTION_P90: usize = 35;

/// No source file is longer than 600 lines: it can be read in one sitting.
pub fn files(tree: &Tree) -> Vec<Finding> {
    let sources = tree.files.iter().filter(|f| f.path.ends_with(".rs") || f.path.ends_with(".py"));
    let long = sources.filter_map(|f| {
        let lines = f.text.lines().count();
        let message = format!("{lines} lines, more than {FILE_LINES}: split the file");
        (lines > FILE_LINES).then(|| Finding::new(&f.path, lines, message))
    });
    long.collect()
}

/// No function is longer than 120 lines without a reason in a comment `// long: …` above it.
pub fn functions(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in tree.rust() {
        for f in functions_of(file) {
            if f.lines > FUNCTION_LINES && !has_reason(&file.text, f.line) {
                let message = format!(
                    "function `{}` has {} lines, more than {FUNCTION_LINES}: split it, or say why above it: `// long: …`",
                    f.name, f.lines
                );
                findings.push(Finding::new(&file.path, f.line, message));
            }
        }
    }
    findings
}

/// Nine of ten functions have at most 35 lines.
pub fn percentile(tree: &Tree) -> Vec<Finding> {
    let mut lengths = all_lengths(tree);
    let p90 = percentile_90(&mut lengths);
    if p90 <= FUNCTION_P90 {
        return Vec::new();
    }
    vec![Finding::new(
        "workspace",
        0,
        format!("p90 of function lengths is {p90} lines, more than {FUNCTION_P90}"),
    )]
}

/// One line about the size of the workspace.
pub fn statistics(tree: &Tree) -> String {
    let mut lengths = all_lengths(tree);
    let lines: usize = tree.rust().map(|f| f.text.lines().count()).sum();
    let longest = lengths.iter().max().copied().unwrap_or(0);
    let p90 = percentile_90(&mut lengths);
    let (files, functions) = (tree.rust().count(), lengths.len());
    format!("{files} Rust files, {lines} lines, {functions} functions, p90 {p90} lines, longest {longest}")
}

struct Function {
    name: String,
    line: usize,
    lines: usize,
}

fn all_lengths(tree: &Tree) -> Vec<usize> {
    tree.rust().flat_map(functions_of).map(|f| f.lines).collect()
}

fn percentile_90(lengths: &mut [usize]) -> usize {
    lengths.sort_unstable();
    let rank = (lengths.len() * 9).div_ceil(10);
    if rank == 0 { 0 } else { lengths[rank - 1] }
}

/// All functions with a body, closures not counted.
fn functions_of(file: &File) -> Vec<Function> {
    let code = &file.code;
    let mut found = Vec::new();
    for (at, word) in code.match_indices("fn") {
        if !is_word_at(code, at, word) {
            continue;
        }
        let rest = code[at + 2..].trim_start();
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if name.is_empty() {
            continue;
        }
        if let Some(open) = body(code, at) {
            let line = line_of(code, at);
            let end = line_of(code, closing(code, open) - 1);
            found.push(Function { name, line, lines: end + 1 - line });
        }
    }
    found
}

/// Offset of the brace that opens the body of the function at `at`, past brackets in its signature.
fn body(code: &str, at: usize) -> Option<usize> {
    let mut i = at;
    loop {
        i += code[i..].find(['{', ';', '(', '['])?;
        match code.as_bytes()[i] {
            b'{' => return Some(i),
            b';' => return None,
            _ => i = closing(code, i),
        }
    }
}

/// Looks for `// long: …` among the comments and attributes directly above `line`.
fn has_reason(text: &str, line: usize) -> bool {
    let lines: Vec<&str> = text.lines().take(line - 1).collect();
    let above =
        lines.iter().rev().map(|l| l.trim()).take_while(|l| l.starts_with("//") || l.starts_with("#["));
    above.filter_map(|l| l.strip_prefix("// long:")).any(|reason| !reason.trim().is_empty())
}

#[cfg(test)]
mod tests {
    use super::super::tree::tests::one;
    use super::*;

    fn function_of(lines: usize) -> String {
        format!("fn long(a: [u8; 3]) -> u8 {{\n{}}}\n", "    a();\n".repeat(lines - 2))
    }

    #[test]
    fn long_files_are_found() {
        assert!(files(&one("a.rs", &"\n".repeat(600))).is_empty());
        assert_eq!(files(&one("a.rs", &"\n".repeat(601))).len(), 1);
        assert_eq!(files(&one("a.py", &"\n".repeat(601)))[0].line, 601);
        assert!(files(&one("a.md", &"\n".repeat(601))).is_empty());
    }

    #[test]
    fn long_functions_need_a_reason() {
        assert!(functions(&one("a.rs", &function_of(120))).is_empty());
        let found = functions(&one("a.rs", &format!("// x\n{}", function_of(121))));
        assert_eq!((found.len(), found[0].line), (1, 2));
        let reason = format!("// long: one table\n#[inline]\n{}", function_of(121));
        assert!(functions(&one("a.rs", &reason)).is_empty());
        assert_eq!(functions(&one("a.rs", &format!("// long:\n{}", function_of(121)))).len(), 1);
    }

    #[test]
    fn the_ninetieth_percentile_counts_functions_with_bodies() {
        let short = "fn short() {}\n".repeat(9);
        assert!(percentile(&one("a.rs", &format!("{short}{}", function_of(36)))).is_empty());
        assert_eq!(percentile(&one("a.rs", &format!("{short}{0}{0}", function_of(36)))).len(), 1);
        let tree = one("a.rs", "trait T { fn a(&self); fn b(&self) {} }\n// fn c() {}\nlet f: fn(u8) = g;\n");
        assert_eq!(all_lengths(&tree), [1]);
    }
}
