//! Words, numbers and lines of text formats, from bytes.
//!
//! Nothing here counts lines: a fault names its byte, and [`super::faults`] finds the line when it needs it.

use crate::printable::push;

/// A word and where it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Token<'a> {
    /// The bytes of the word; never empty.
    pub text: &'a [u8],
    /// Offset of its first byte in the file.
    pub at: usize,
}

impl Token<'_> {
    /// The word as text; bytes that are no UTF-8 are replaced.
    pub fn lossy(&self) -> String {
        String::from_utf8_lossy(self.text).into_owned()
    }

    /// The word for a message: at most 40 characters, those that are not seen replaced or escaped.
    pub fn shortened(&self) -> String {
        const MOST: usize = 40;
        let text = self.lossy();
        let mut shown = String::new();
        text.chars().take(MOST).for_each(|c| push(&mut shown, c));
        if text.chars().nth(MOST).is_some() {
            shown.push('…');
        }
        shown
    }
}

/// A cursor over the bytes of a file.
#[derive(Clone, Debug)]
pub(super) struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
    /// True if a backslash at the end of a line joins it with the next one (OBJ).
    joins_lines: bool,
}

/// The bytes that end a word; a backslash does only at the end of a line.
const MAY_END_WORD: [bool; 256] = {
    let mut ends = [false; 256];
    let mut b = 0u8;
    while b < 128 {
        ends[b as usize] = b.is_ascii_whitespace() || b == b'\\';
        b += 1;
    }
    ends
};

/// Byte order mark of UTF-8.
pub(super) const MARK: &[u8] = b"\xEF\xBB\xBF";

impl<'a> Lexer<'a> {
    /// Begins after the byte order mark, if there is one.
    pub fn new(bytes: &'a [u8], joins_lines: bool) -> Self {
        Self { bytes, at: if bytes.starts_with(MARK) { MARK.len() } else { 0 }, joins_lines }
    }

    /// Continues elsewhere.
    pub fn at(&self, at: usize) -> Self {
        Self { at: at.min(self.bytes.len()), ..*self }
    }

    /// Offset of the next byte.
    pub fn offset(&self) -> usize {
        self.at
    }

    /// Number of bytes that are left.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next word of this line; `None` at the end of the line, of the file or at a comment.
    #[inline]
    pub fn token(&mut self) -> Option<Token<'a>> {
        self.skip_blanks();
        let start = self.at;
        if self.bytes.get(start) == Some(&b'#') {
            return None;
        }
        loop {
            let rest = &self.bytes[self.at..];
            self.at += rest.iter().position(|b| MAY_END_WORD[usize::from(*b)]).unwrap_or(rest.len());
            if self.bytes.get(self.at) != Some(&b'\\') || self.continuation() > 0 {
                break;
            }
            self.at += 1;
        }
        (self.at > start).then(|| Token { text: &self.bytes[start..self.at], at: start })
    }

    /// The next word of this line as a plain decimal number. `None` if it is anything else: then nothing is passed over.
    #[inline]
    pub fn plain_number(&mut self) -> Option<f32> {
        self.skip_blanks();
        let (v, length) = plain_decimal(&self.bytes[self.at..])?;
        self.pass_word(length).then_some(v)
    }

    /// The next word of this line as up to three whole numbers between slashes, 0 for those that are not there. `None`
    /// if it is anything else, a 0, or a number of more than nine digits: then nothing is passed over.
    #[inline]
    pub fn plain_indices(&mut self) -> Option<[u32; 3]> {
        self.skip_blanks();
        let word = &self.bytes[self.at..];
        let (mut parts, mut at) = ([0u32; 3], 0);
        for (k, part) in parts.iter_mut().enumerate() {
            let start = at;
            while let Some(digit) = word.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
                *part = part.wrapping_mul(10).wrapping_add(u32::from(digit));
                at += 1;
            }
            if at - start > 9 || *part == 0 && at > start {
                return None;
            }
            if k == 2 || word.get(at) != Some(&b'/') {
                break;
            }
            at += 1;
        }
        (at > 0 && self.pass_word(at)).then_some(parts)
    }

    /// Passes over that many bytes if a word ends there. False if it does not.
    #[inline]
    fn pass_word(&mut self, length: usize) -> bool {
        let ends = matches!(self.bytes.get(self.at + length), None | Some(b' ' | b'\t' | b'\n' | b'\r'));
        self.at += if ends { length } else { 0 };
        ends
    }

    /// The rest of this line without blanks at its ends, up to a comment that follows a blank. Not joined with
    /// the next line. `None` if nothing is there.
    pub fn rest(&mut self) -> Option<Token<'a>> {
        self.skip_blanks();
        let start = self.at;
        let line = &self.bytes[start..line_end(self.bytes, start)];
        if line.first() == Some(&b'#') {
            return None;
        }
        let comment = line.windows(2).position(|w| is_blank(w[0]) && w[1] == b'#');
        let text = line[..comment.unwrap_or(line.len())].trim_ascii_end();
        self.at = start + text.len();
        (!text.is_empty()).then_some(Token { text, at: start })
    }

    /// Passes over what is left of the line, continuations included.
    pub fn next_line(&mut self) {
        while self.token().is_some() {}
        self.at = line_end(self.bytes, self.at);
        if self.bytes.get(self.at..self.at + 2) == Some(b"\r\n") {
            self.at += 2;
        } else {
            self.at = (self.at + 1).min(self.bytes.len());
        }
    }

    /// The next word, on this line or another; `None` at the end of the file.
    pub fn word(&mut self) -> Option<Token<'a>> {
        if self.next_word_line() { self.token() } else { None }
    }

    /// Goes to the next line that holds a word. False at the end of the file.
    pub fn next_word_line(&mut self) -> bool {
        loop {
            self.skip_blanks();
            match self.bytes.get(self.at) {
                None => return false,
                Some(b'#' | b'\n' | b'\r') => self.next_line(),
                Some(_) => return true,
            }
        }
    }

    #[inline]
    fn skip_blanks(&mut self) {
        while let Some(b) = self.bytes.get(self.at) {
            match *b {
                b if is_blank(b) => self.at += 1,
                b'\r' if self.bytes.get(self.at + 1) == Some(&b'\n') => self.at += 1,
                b'\\' => match self.continuation() {
                    0 => return,
                    length => self.at += length,
                },
                _ => return,
            }
        }
    }

    /// Length of the backslash and line end, or end of the file, here; 0 if there are none.
    fn continuation(&self) -> usize {
        match &self.bytes[self.at..] {
            _ if !self.joins_lines => 0,
            [b'\\', b'\r', b'\n', ..] => 3,
            [b'\\', b'\n' | b'\r', ..] => 2,
            [b'\\'] => 1,
            _ => 0,
        }
    }
}

/// A blank within a line.
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0B | 0x0C)
}

/// Offset of the line end (`\n`, `\r`, `\r\n`) at or after `from`, or of the end of the file.
pub(super) fn line_end(bytes: &[u8], from: usize) -> usize {
    bytes[from..].iter().position(|b| matches!(b, b'\n' | b'\r')).map_or(bytes.len(), |i| from + i)
}

/// What a word says as a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    /// A finite number, rounded once from the decimal text.
    Finite(f32),
    /// A NaN or infinity, in one of the spellings of C libraries.
    NotFinite,
    /// Too large for 32 bits.
    Overflow,
    /// No number.
    None,
}

/// Reads a word as a number.
#[inline]
pub(super) fn number(text: &[u8]) -> Number {
    match plain_decimal(text) {
        Some((v, length)) if length == text.len() => Number::Finite(v),
        _ => any_number(text),
    }
}

/// 10⁰ to 10¹⁸, exact.
const POWERS: [f64; 19] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18];

/// Quickly reads a number such as `-12.345` at the beginning of bytes, rounded once; the second is its length. `None`
/// for all that is rarer.
#[inline]
fn plain_decimal(bytes: &[u8]) -> Option<(f32, usize)> {
    let negative = bytes.first() == Some(&b'-');
    let start = usize::from(negative);
    let (mut mantissa, mut point, mut at) = (0u64, None, start);
    while let Some(b) = bytes.get(at) {
        let digit = b.wrapping_sub(b'0');
        if digit < 10 {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        } else if *b == b'.' && point.is_none() {
            point = Some(at);
        } else {
            break;
        }
        at += 1;
    }
    let digits = at - start - usize::from(point.is_some());
    // Up to 18 digits fit 64 bits.
    if digits == 0 || digits > 18 || mantissa >= 1 << 53 {
        return None;
    }
    let decimals = point.map_or(0, |point| at - 1 - point);
    // Both are exact, so that this is the double nearest to the number. To round it again gives the single nearest to
    // the number, unless it lies midway between two of them. None is too small or too large to be normal.
    let wide = mantissa as f64 / POWERS.get(decimals)?;
    if wide.to_bits() & 0x1FFF_FFFF == 0x1000_0000 {
        return None;
    }
    let v = wide as f32;
    Some((if negative { -v } else { v }, at))
}

fn any_number(text: &[u8]) -> Number {
    let parsed = std::str::from_utf8(text).ok().and_then(|t| t.parse::<f32>().ok());
    match parsed {
        Some(v) if v.is_finite() => Number::Finite(v),
        Some(_) if text.iter().any(u8::is_ascii_digit) => Number::Overflow,
        Some(_) => Number::NotFinite,
        None if is_spelt_not_finite(text) => Number::NotFinite,
        None => Number::None,
    }
}

/// `1.#IND`, `-1.#QNAN`, `1.#INF`, `nan(ind)`, `-nan(0x7f)` as C libraries print them.
fn is_spelt_not_finite(text: &[u8]) -> bool {
    let lower = text.to_ascii_lowercase();
    let unsigned = lower.strip_prefix(b"-").or(lower.strip_prefix(b"+")).unwrap_or(&lower);
    unsigned.starts_with(b"1.#") || unsigned.starts_with(b"nan(")
}

/// Reads a word as a whole number; numbers beyond 64 bits come out as the nearest.
#[inline]
pub(super) fn integer(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let size = digits.iter().fold(0i64, |v, d| v.saturating_mul(10).saturating_add(i64::from(d - b'0')));
    Some(if negative { -size } else { size })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str, joins: bool) -> Vec<Vec<String>> {
        let mut lexer = Lexer::new(text.as_bytes(), joins);
        let mut lines = Vec::new();
        while lexer.next_word_line() {
            lines.push(std::iter::from_fn(|| lexer.token()).map(|t| t.lossy()).collect());
            lexer.next_line();
        }
        lines
    }

    #[test]
    fn splits_into_lines_and_words() {
        let expected = [vec!["a", "b"], vec!["c"], vec!["d#e"], vec!["f"]];
        let text = "\u{feff}a\tb # comment\r\n\n  #only\n c\rd#e\n\x0b f";
        assert_eq!(words(text, false), expected);
    }

    #[test]
    fn joins_lines_only_where_told() {
        assert_eq!(words("f 1 \\\r\n 2\\\n3 a\\b\nx", true), [vec!["f", "1", "2", "3", "a\\b"], vec!["x"]]);
        assert_eq!(words("f 1 2\\", true), [["f", "1", "2"]]);
        assert_eq!(words("a \\\nb", false), [vec!["a", "\\"], vec!["b"]]);
    }

    #[test]
    fn the_rest_of_a_line_keeps_inner_blanks_and_number_signs() {
        let rest = |text: &'static str| Lexer::new(text.as_bytes(), true).rest().map(|t| t.lossy());
        assert_eq!(rest("  my file#1.mtl  # why\nnext"), Some("my file#1.mtl".to_owned()));
        assert_eq!(rest(" a\\b \r\n"), Some("a\\b".to_owned()));
        assert_eq!(rest("   # c"), None);
        assert_eq!(rest(" \n x"), None);
    }

    #[test]
    fn numbers_are_rounded_once_and_faults_told_apart() {
        assert_eq!(number(b"0.1"), Number::Finite(0.1));
        // A double rounding by way of f64 would give 1.
        assert_eq!(number(b"1.00000005960464477540"), Number::Finite(1.000_000_1));
        assert_eq!(number(b"+.5e1"), Number::Finite(5.0));
        for text in ["nan", "-NaN", "inf", "-Infinity", "1.#IND", "-1.#QNAN", "nan(ind)"] {
            assert_eq!(number(text.as_bytes()), Number::NotFinite, "{text}");
        }
        assert_eq!(number(b"1e39"), Number::Overflow);
        assert_eq!(number(b"-1e999"), Number::Overflow);
        for text in ["one", "", "1,5", "0x1", "1e", "\u{661}"] {
            assert_eq!(number(text.as_bytes()), Number::None, "{text}");
        }
    }

    #[test]
    fn plain_decimals_are_what_the_standard_library_reads() {
        let mut state = 5u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let mut quick = 0;
        for i in 0..200_000 {
            let whole = below(10) as u32;
            let mut text = if below(2) == 0 { String::from("-") } else { String::new() };
            text += &below(10u64.pow(whole)).to_string();
            if below(4) > 0 {
                text += ".";
                (0..below(11)).for_each(|_| text += &below(10).to_string());
            }
            if i % 8 == 0 {
                // The middle between two neighbours, and what lies right beside it.
                let low = f32::from_bits(0x3F80_0000 + below(1 << 23) as u32);
                let middle = (f64::from(low) + f64::from(low.next_up())) / 2.0;
                text = format!("{middle:.*}", 13 + below(4) as usize);
            }
            let expected: f32 = text.parse().expect("a number");
            let found = Lexer::new(text.as_bytes(), true).plain_number();
            quick += usize::from(found.is_some());
            assert!(found.is_none_or(|v| v.to_bits() == expected.to_bits()), "{text}: {found:?} {expected}");
            assert_eq!(number(text.as_bytes()), Number::Finite(expected));
        }
        assert!(quick > 150_000, "{quick}");
        for text in
            ["", "-", ".", "-.", "1..2", "--1", "1-", "1e5", "9007199254740993", "1234567890123456789"]
        {
            let mut lexer = Lexer::new(text.as_bytes(), true);
            assert_eq!((lexer.plain_number(), lexer.offset()), (None, 0), "{text}");
        }
        assert_eq!(plain_decimal(b"-0").map(|(v, _)| v.to_bits()), Some((-0.0f32).to_bits()));
        assert_eq!((plain_decimal(b".5"), plain_decimal(b"5. 3")), (Some((0.5, 2)), Some((5.0, 2))));
    }

    #[test]
    fn plain_indices_are_those_of_faces() {
        let read = |text: &str| {
            let mut lexer = Lexer::new(text.as_bytes(), true);
            (lexer.plain_indices(), lexer.offset())
        };
        for (text, expected) in [
            (" 12 3", ([12, 0, 0], 3)),
            ("1/2\n", ([1, 2, 0], 3)),
            ("1//3", ([1, 0, 3], 4)),
            ("1/2/3\r\n", ([1, 2, 3], 5)),
            ("999999999/8/", ([999_999_999, 8, 0], 12)),
            ("/7 ", ([0, 7, 0], 2)),
        ] {
            assert_eq!(read(text), (Some(expected.0), expected.1), "{text}");
        }
        for text in [
            "",
            "-1",
            "0",
            "1/0",
            "1//0 ",
            "1000000000",
            "4294967297",
            "1/2/3/4",
            "1/2/3/",
            "1.5",
            "+1",
            "a",
            "1\\\n2",
            "#",
        ] {
            assert_eq!(read(text), (None, 0), "{text}");
        }
    }

    #[test]
    fn words_are_shown_short_and_without_hidden_characters() {
        let shown = |text: &str| Token { text: text.as_bytes(), at: 0 }.shortened();
        assert_eq!(shown("\u{202e}live\u{1b}"), "\\u{202e}live\u{fffd}");
        assert_eq!(shown(&"é".repeat(41)), format!("{}…", "é".repeat(40)));
    }

    #[test]
    fn integers_saturate() {
        assert_eq!(integer(b"-12"), Some(-12));
        assert_eq!(integer(b"+7"), Some(7));
        assert_eq!(integer(b"99999999999999999999"), Some(i64::MAX));
        for text in ["", "-", "1.0", "a", "1 "] {
            assert_eq!(integer(text.as_bytes()), None, "{text}");
        }
    }
}
