//! A scanner of Rust source that knows just enough to tell code from comments and literals.

/// Source text split in two layers of the same shape: what is not of a layer is blank in it, so line and column
/// agree with the source.
#[derive(Debug, Default)]
pub struct Layers {
    /// Code, with comments and the insides of text and character literals blanked.
    pub code: String,
    /// Comments only.
    pub comments: String,
}

#[derive(Clone, Copy, PartialEq)]
enum Layer {
    Code,
    Comment,
    Literal,
}

/// Splits Rust source.
pub fn split(source: &str) -> Layers {
    let text: Vec<char> = source.chars().collect();
    let mut layers = Layers::default();
    let mut at = 0;
    while at < text.len() {
        let (layer, length) = token(&text, at);
        for &c in &text[at..at + length] {
            let blank = if c == '\n' { '\n' } else { ' ' };
            layers.code.push(if layer == Layer::Code { c } else { blank });
            layers.comments.push(if layer == Layer::Comment { c } else { blank });
        }
        at += length;
    }
    layers
}

/// Layer and length of what begins at `at`.
fn token(text: &[char], at: usize) -> (Layer, usize) {
    let next = text.get(at + 1).copied();
    match text[at] {
        '/' if next == Some('/') => (Layer::Comment, distance_to(text, at, '\n')),
        '/' if next == Some('*') => (Layer::Comment, block_comment(text, at)),
        '"' => (Layer::Literal, text_literal(text, at)),
        'r' | 'b' | 'c' if !continues_word(text, at) => match raw_literal(text, at) {
            Some(length) => (Layer::Literal, length),
            None => (Layer::Code, 1),
        },
        '\'' => match char_literal(text, at) {
            Some(length) => (Layer::Literal, length),
            None => (Layer::Code, 1),
        },
        _ => (Layer::Code, 1),
    }
}

fn continues_word(text: &[char], at: usize) -> bool {
    at > 0 && (text[at - 1].is_alphanumeric() || text[at - 1] == '_')
}

fn distance_to(text: &[char], at: usize, end: char) -> usize {
    text[at..].iter().position(|&c| c == end).unwrap_or(text.len() - at)
}

/// Block comments nest.
fn block_comment(text: &[char], at: usize) -> usize {
    let (mut depth, mut i) = (0_usize, at);
    while i < text.len() {
        match (text[i], text.get(i + 1)) {
            ('/', Some('*')) => (depth, i) = (depth + 1, i + 2),
            ('*', Some('/')) => (depth, i) = (depth - 1, i + 2),
            _ => i += 1,
        }
        if depth == 0 {
            break;
        }
    }
    i.min(text.len()) - at
}

fn text_literal(text: &[char], at: usize) -> usize {
    let mut i = at + 1;
    while i < text.len() && text[i] != '"' {
        i += if text[i] == '\\' { 2 } else { 1 };
    }
    (i + 1).min(text.len()) - at
}

/// `r"…"`, `r#"…"#`, `br"…"`, `cr"…"`; the prefix of `b"…"` and `c"…"` is left to the plain literal.
fn raw_literal(text: &[char], at: usize) -> Option<usize> {
    let start = if text[at] == 'r' { at } else { at + 1 };
    if text.get(start) != Some(&'r') {
        return None;
    }
    let hashes = text[start + 1..].iter().take_while(|&&c| c == '#').count();
    let open = start + 1 + hashes;
    if text.get(open) != Some(&'"') {
        return None;
    }
    let closes =
        |i: &usize| text[*i] == '"' && text[i + 1..].iter().take_while(|&&c| c == '#').count() >= hashes;
    let end = (open + 1..text.len()).find(closes).map_or(text.len(), |i| i + 1 + hashes);
    Some(end - at)
}

/// A character literal, as opposed to a lifetime.
fn char_literal(text: &[char], at: usize) -> Option<usize> {
    match (text.get(at + 1)?, text.get(at + 2)) {
        ('\\', _) => Some((at + 3..text.len()).find(|&i| text[i] == '\'')? + 1 - at),
        (_, Some('\'')) => Some(3),
        _ => None,
    }
}

/// Whether `word` stands at `at` in `text` with no word character on either side.
pub fn is_word_at(text: &str, at: usize, word: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let before = text[..at].chars().next_back();
    let after = text[at + word.len()..].chars().next();
    !before.is_some_and(is_word) && !after.is_some_and(is_word)
}

/// Byte offset just behind the bracket that closes the one at `open` (which may be `{`, `(` or `[`).
pub fn closing(code: &str, open: usize) -> usize {
    let mut depth = 0_usize;
    for (i, c) in code[open..].char_indices() {
        match c {
            '{' | '(' | '[' => depth += 1,
            '}' | ')' | ']' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return open + i + c.len_utf8();
        }
    }
    code.len()
}

/// Line, from 1, of a byte offset.
pub fn line_of(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_literals_leave_the_code() {
        let layers = split("a(); // b()\n/* c /* d */ e */ f(\"g{\\\"\", '{', '\\'');");
        assert!(layers.code.contains("a();") && layers.code.contains("f("));
        for gone in ["b()", "c", "d", "e", "g", "{"] {
            assert!(!layers.code.contains(gone), "{gone} in {:?}", layers.code);
        }
        assert!(layers.comments.contains("// b()") && layers.comments.contains("e */"));
        assert_eq!(layers.code.lines().count(), 2);
    }

    #[test]
    fn lifetimes_are_code_and_raw_literals_are_not() {
        let layers = split("fn f<'a>(x: &'a str) { r#\"}\"} x\"#; br\"y\"; 'z'; for_r(\"w\") }");
        assert!(layers.code.contains("<'a>(x: &'a str)"));
        assert_eq!(layers.code.matches('}').count(), 1);
        for gone in ["y", "z", "w"] {
            assert!(!layers.code.contains(gone), "{gone} in {:?}", layers.code);
        }
    }

    #[test]
    fn columns_survive_wide_characters() {
        let source = "let a = \"é\"; // ü\nb";
        let layers = split(source);
        assert_eq!(layers.code.chars().count(), source.chars().count());
        assert_eq!(layers.code.lines().nth(1), Some("b"));
    }

    #[test]
    fn broken_source_does_not_panic() {
        for source in ["\"", "'", "r#\"", "/*", "b", "'\\", "\"\\"] {
            split(source);
        }
    }

    #[test]
    fn closing_brackets_nest() {
        assert_eq!(closing("{ (a) [b] } c", 0), 11);
        assert_eq!(closing("{ {", 0), 3);
    }
}
