//! Calls and words that must not stand in the project's code.

use super::Finding;
use super::scan::{is_word_at, line_of};
use super::tree::{File, Tree};

/// Macros and attributes of unfinished work.
const UNFINISHED: &[&str] =
    &["todo!", "unimplemented!", "dbg!", "#[ignore", "allow(dead_code", "expect(dead_code"];
/// Macros that print.
const PRINTING: &[&str] = &["println!", "print!", "eprintln!", "eprint!"];
/// Crates that talk to a person.
const SPEAKING: &[&str] = &["crates/cli/", "crates/view/", "xtask/"];
/// Functions of `f32` and `f64` whose last bits are the platform's, or that fuse operations.
const TRANSCENDENTAL: &[&str] = &[
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sin_cos", "sinh", "cosh", "tanh", "asinh",
    "acosh", "atanh", "exp", "exp2", "exp_m1", "ln", "ln_1p", "log", "log2", "log10", "powf", "powi", "cbrt",
    "hypot", "mul_add",
];
/// Crates whose numbers reach no image: statistics for tests, and this one.
const FREE_NUMBERS: &[&str] = &["crates/lab/", "xtask/"];

/// Nothing unfinished, in tests neither.
pub fn unfinished(tree: &Tree) -> Vec<Finding> {
    tree.rust().flat_map(|f| words(f, &f.code, UNFINISHED, "has no place in finished code")).collect()
}

/// Libraries do not print; tests may.
pub fn printing(tree: &Tree) -> Vec<Finding> {
    let silent = tree.rust().filter(|f| !SPEAKING.iter().any(|s| f.path.starts_with(s)));
    silent.flat_map(|f| words(f, &f.product, PRINTING, "in a library: only the command prints")).collect()
}

/// Elementary functions come from `penombre_math::float`, which gives the same bits everywhere; tests are free.
pub fn transcendental(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in tree.rust().filter(|f| !FREE_NUMBERS.iter().any(|s| f.path.starts_with(s))) {
        for name in TRANSCENDENTAL {
            for call in [format!(".{name}("), format!("f32::{name}"), format!("f64::{name}")] {
                findings.extend(platform_calls(file, name, &call));
            }
        }
    }
    findings
}

fn platform_calls(file: &File, name: &str, call: &str) -> Vec<Finding> {
    let code = &file.product;
    let whole = |at: &usize| {
        code[at + call.len()..].chars().next().is_none_or(|c| !(c.is_alphanumeric() || c == '_'))
    };
    let at = code.match_indices(call).map(|(at, _)| at).filter(|at| call.ends_with('(') || whole(at));
    let message = format!("the platform's `{name}` differs between machines: use penombre_math::float");
    at.map(|at| Finding::new(&file.path, line_of(code, at), message.clone())).collect()
}

/// No file names a folder of the machine it was written on.
pub fn machine_paths(tree: &Tree) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in &tree.files {
        for path in &tree.machine_paths {
            let message = format!("`{path}` is a path of one machine");
            let places = file.text.match_indices(path.as_str());
            findings.extend(
                places.map(|(at, _)| Finding::new(&file.path, line_of(&file.text, at), message.clone())),
            );
        }
    }
    findings
}

fn words(file: &File, code: &str, words: &[&str], why: &str) -> Vec<Finding> {
    let mut findings = Vec::new();
    for word in words {
        let start = word.trim_end_matches('!');
        for (at, _) in code.match_indices(word) {
            if word.starts_with('#') || is_word_at(code, at, start) || !word.ends_with('!') {
                findings.push(Finding::new(&file.path, line_of(code, at), format!("`{word}` {why}")));
            }
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::super::tree::tests::one;
    use super::*;

    const LIBRARY: &str = "crates/math/src/a.rs";

    #[test]
    fn unfinished_work_is_found_outside_comments() {
        let text =
            "// todo!()\nfn a() { todo!() }\n#[ignore = \"x\"]\n#[allow(dead_code)]\nfn b() { dbg!(1) }\n";
        let lines: Vec<usize> = unfinished(&one(LIBRARY, text)).iter().map(|f| f.line).collect();
        assert_eq!(lines, [2, 5, 3, 4]);
        assert!(unfinished(&one(LIBRARY, "my_todo!(); let a = \"dbg!\";")).is_empty());
    }

    #[test]
    fn libraries_do_not_print() {
        let text = "fn a() { println!() }\n#[cfg(test)]\nmod tests { fn b() { eprintln!() } }";
        assert_eq!(printing(&one(LIBRARY, text)).len(), 1);
        assert!(printing(&one("crates/cli/src/main.rs", text)).is_empty());
        assert!(printing(&one("crates/math/tests/a.rs", text)).is_empty());
    }

    #[test]
    fn platform_functions_are_found_as_method_and_as_path() {
        let count = |text: &str| transcendental(&one(LIBRARY, text)).len();
        assert_eq!(count("x.sin(); x.mul_add(y, z); a.map(f32::exp); f64::powi(x, 2);"), 4);
        assert_eq!(
            count("float::sin(x); x.sqrt(); x.sine(); f32::EPSILON; self.exponent(); f32::exponent(x);"),
            0
        );
        assert_eq!(count("#[cfg(test)]\nmod tests { fn a() { x.sin(); } }"), 0);
        assert!(transcendental(&one("crates/lab/src/lib.rs", "x.ln()")).is_empty());
    }

    #[test]
    fn paths_of_one_machine_are_found_in_any_file() {
        let mut tree = one("docs/a.md", "x\nsee /home/somebody/penombre/b\n");
        tree.machine_paths = vec!["/home/somebody/".to_owned()];
        assert_eq!(machine_paths(&tree)[0].line, 2);
        tree.machine_paths = vec!["/elsewhere/".to_owned()];
        assert!(machine_paths(&tree).is_empty());
    }
}
