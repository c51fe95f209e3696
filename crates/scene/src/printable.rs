//! Text that does a terminal, and who reads there, no harm: names in scenes and meshes may hold anything.

use std::borrow::Cow;
use std::fmt::Write;

/// True for characters that are not seen and change how others are: directions of writing and byte order
/// marks.
fn is_hidden(c: char) -> bool {
    matches!(c, '\u{61C}' | '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}' | '\u{FEFF}')
}

/// The text with control characters replaced and hidden ones escaped, as `\u{202e}`.
pub fn harmless(text: &str) -> Cow<'_, str> {
    if !text.contains(|c: char| c.is_control() || is_hidden(c)) {
        return text.into();
    }
    let mut shown = String::new();
    for c in text.chars() {
        push(&mut shown, c);
    }
    shown.into()
}

/// Adds a character as [`harmless`] shows it.
pub(crate) fn push(shown: &mut String, c: char) {
    match c {
        c if c.is_control() => shown.push(char::REPLACEMENT_CHARACTER),
        c if is_hidden(c) => write!(shown, "{}", c.escape_unicode()).expect("strings take all"),
        c => shown.push(c),
    }
}

/// A harmless character of as many bytes, so that places in the text stay. Line ends and tabs stay too.
pub(crate) fn of_one_length(c: char) -> char {
    match c {
        '\n' | '\r' | '\t' => c,
        c if c.is_ascii_control() => '?',
        c if c.is_control() || is_hidden(c) => {
            if c.len_utf8() == 2 {
                '·'
            } else {
                char::REPLACEMENT_CHARACTER
            }
        }
        c => c,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_hidden_is_shown() {
        assert_eq!(harmless("plain é ☃"), "plain é ☃");
        assert_eq!(
            harmless("a\u{202e}b\u{feff}\u{1b}[2J\u{2066}\n"),
            "a\\u{202e}b\\u{feff}\u{fffd}[2J\\u{2066}\u{fffd}"
        );
        for c in ('\0'..='\u{FFFF}').filter(|c| c.is_control() || is_hidden(*c)) {
            assert!(!harmless(&c.to_string()).contains(c));
            let one = of_one_length(c);
            assert_eq!(one.len_utf8(), c.len_utf8());
            assert_eq!(one == c, ['\n', '\r', '\t'].contains(&c), "{c:?}");
        }
    }
}
