//! Quoting for a POSIX shell.

/// The word as a POSIX shell reads it back: bare if it may be, else in single quotes.
pub fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./,:=@%+-".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_they_must_be() {
        assert_eq!(quote("render.size=3"), "render.size=3");
        assert_eq!(quote("a=[1, 2]"), "'a=[1, 2]'");
        assert_eq!(quote("it's"), r"'it'\''s'");
        assert_eq!(quote(""), "''");
        assert_eq!(quote("$HOME"), "'$HOME'");
        assert_eq!(quote("naïve.toml"), "'naïve.toml'");
    }

    /// The system's own shell reads the words back.
    #[cfg(unix)]
    #[test]
    fn the_shell_reads_the_words_back() {
        for word in
            ["plain", "a b", "it's", "\"q\"", "$x `y` \\z", "*?[a]", "né\ttab", "~", "#x", "!", "a=[1.5,-2]"]
        {
            let script = format!("printf %s {}", quote(word));
            let out = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(out.stdout).unwrap(), word);
        }
    }
}
