//! The two things this program reads from the one flat line that `penombre render --json` prints.

/// The text value of `key`, which must hold no escapes (digests do not).
pub fn text<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let rest = value(line, key)?.strip_prefix('"')?;
    rest.split('"').next()
}

/// The number value of `key`.
pub fn number(line: &str, key: &str) -> Option<f64> {
    let rest = value(line, key)?;
    let end = rest.find([',', '}', ' ', '\n']).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

fn value<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let quoted = format!("\"{key}\"");
    let rest = &line[line.find(&quoted)? + quoted.len()..];
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_numbers_and_texts_and_misses_nothing_in_silence() {
        let line = r#"{"scene":"cornell","render_s": 1.25,"mrays_per_s":3e1,"digest":"ab01"}"#;
        assert_eq!(text(line, "digest"), Some("ab01"));
        assert_eq!(number(line, "render_s"), Some(1.25));
        assert_eq!(number(line, "mrays_per_s"), Some(30.0));
        assert_eq!(number(line, "digest"), None);
        assert_eq!(text(line, "render_s"), None);
        assert_eq!(number(line, "spp"), None);
    }
}
