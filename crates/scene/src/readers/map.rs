//! Images that a material library names, and how they are laid over a surface.

use super::faults::Faults;
use super::lexer::{Lexer, Number, Token, number};
use crate::span::Span;

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MapUse {
    Diffuse,
    Specular,
    Emission,
    Opacity,
    Roughness,
    Metal,
}

/// An image and how it is laid over the surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub of: MapUse,
    /// The file as the library names it, with forward slashes.
    pub file: String,
    pub span: Span,
    /// Repetitions per unit of u and v.
    pub scale: [f32; 2],
    /// What is added to u and v after that.
    pub offset: [f32; 2],
    pub clamp: bool,
    /// The channel that is asked for.
    pub channel: Option<&'static str>,
    /// A value v becomes base + gain · v.
    pub base: f32,
    pub gain: f32,
}

impl MapUse {
    /// What a statement's image is for; the second: it is inverted.
    pub fn of_statement(word: &[u8]) -> Option<(Self, bool)> {
        Some(match word {
            b"map_Kd" => (Self::Diffuse, false),
            b"map_Ks" => (Self::Specular, false),
            b"map_Ke" => (Self::Emission, false),
            b"map_d" | b"map_opacity" => (Self::Opacity, false),
            b"map_Tr" => (Self::Opacity, true),
            b"map_Pr" => (Self::Roughness, false),
            b"map_Pm" => (Self::Metal, false),
            _ => return None,
        })
    }

    /// What messages call it.
    pub fn what(self) -> &'static str {
        match self {
            Self::Diffuse | Self::Specular | Self::Emission => "colour",
            Self::Opacity => "opacity",
            Self::Roughness => "roughness",
            Self::Metal => "share of metal",
        }
    }

    /// The last part of the name of its texture.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Diffuse => "",
            Self::Specular => "/specular",
            Self::Emission => "/emission",
            Self::Opacity => "/opacity",
            Self::Roughness => "/roughness",
            Self::Metal => "/metal",
        }
    }

    /// True if its numbers are light, not sRGB-encoded shares.
    pub fn is_color(self) -> bool {
        matches!(self, Self::Diffuse | Self::Specular | Self::Emission)
    }
}

impl Map {
    fn new(of: MapUse, inverted: bool) -> Self {
        let channel = (of == MapUse::Opacity).then_some("mask");
        let (base, gain) = if inverted { (1.0, -1.0) } else { (0.0, 1.0) };
        let (scale, offset, clamp) = ([1.0; 2], [0.0; 2], false);
        Self { of, file: String::new(), span: Span::NONE, scale, offset, clamp, channel, base, gain }
    }

    /// Reads the options and the file name behind a statement that [`MapUse::of_statement`] knows.
    pub fn read(
        lexer: &mut Lexer<'_>,
        word: Token<'_>,
        (of, inverted): (MapUse, bool),
        faults: &mut Faults<'_>,
    ) -> Option<Self> {
        let mut found = Self::new(of, inverted);
        found.options(lexer, faults);
        let Some(whole) = lexer.rest() else {
            let statement = word.lossy();
            let message = format!("`{statement}` names no file");
            let help = format!("write `{statement} FILE.png`; the plain {} is used", of.what());
            faults.warning("mtl::map", word, message, help);
            return None;
        };
        let name = before_options(lexer, whole);
        if name.text.len() < whole.text.len() {
            let mut behind = lexer.at(name.at + name.text.len());
            found.options(&mut behind, faults);
        }
        let text = name.lossy();
        let unquoted = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')).unwrap_or(&text);
        found.file = unquoted.replace('\\', "/");
        found.span = faults.span(name.at, name.text.len());
        Some(found)
    }

    /// Reads options as long as there are some.
    fn options(&mut self, lexer: &mut Lexer<'_>, faults: &mut Faults<'_>) {
        let mut ahead = lexer.clone();
        while let Some(option) = ahead.token().filter(|word| is_option(*word)) {
            self.option(&mut ahead, option, faults);
            *lexer = ahead.clone();
        }
    }

    /// Reads the arguments of one option.
    fn option(&mut self, lexer: &mut Lexer<'_>, option: Token<'_>, faults: &mut Faults<'_>) {
        match option.text {
            b"-s" => {
                let [u, v, _] = up_to_three(lexer, 1.0);
                self.scale = [u, v];
            }
            b"-o" => {
                let [u, v, _] = up_to_three(lexer, 0.0);
                self.offset = [u, v];
            }
            b"-t" => {
                if up_to_three(lexer, 0.0) != [0.0; 3] {
                    not_applied(option, faults);
                }
            }
            b"-mm" => {
                let (base, gain) = (one(lexer).unwrap_or(0.0), one(lexer).unwrap_or(1.0));
                (self.base, self.gain) = (finite(self.base + self.gain * base), finite(self.gain * gain));
            }
            b"-clamp" => self.clamp = lexer.token().is_some_and(|t| t.text == b"on"),
            b"-imfchan" => match lexer.token().and_then(|t| channel(t.text)) {
                Some(word) => self.channel = Some(word),
                None => not_applied(option, faults),
            },
            b"-blendu" | b"-blendv" => {
                if lexer.token().is_none_or(|t| t.text != b"on") {
                    not_applied(option, faults);
                }
            }
            b"-boost" | b"-cc" | b"-texres" | b"-bm" | b"-type" => {
                lexer.token();
                not_applied(option, faults);
            }
            _ => {
                let message = format!("`{}` is no option of a map", option.shortened());
                let help = "it is passed over with the word behind it; what is read is -s, -o, -mm, -clamp and -imfchan";
                faults.warning("mtl::option", option, message, help);
                lexer.token();
            }
        }
    }
}

/// Products of huge numbers stay numbers that scenes may have.
pub(super) fn finite(v: f32) -> f32 {
    v.clamp(f32::MIN, f32::MAX)
}

/// True for a minus and a letter.
fn is_option(word: Token<'_>) -> bool {
    matches!(word.text, [b'-', letter, ..] if letter.is_ascii_alphabetic())
}

/// The options that maps have.
const OPTIONS: [&[u8]; 13] = [
    b"-s",
    b"-o",
    b"-t",
    b"-mm",
    b"-clamp",
    b"-imfchan",
    b"-blendu",
    b"-blendv",
    b"-boost",
    b"-cc",
    b"-texres",
    b"-bm",
    b"-type",
];

/// The name of a file without the options that some programs write behind it. Names may have blanks, so only what maps
/// have as options counts.
fn before_options<'a>(lexer: &Lexer<'a>, name: Token<'a>) -> Token<'a> {
    let mut words = lexer.at(name.at);
    words.token();
    // Names do not go on behind the end of a line, as words do.
    while let Some(word) = words.token().filter(|word| word.at < name.at + name.text.len()) {
        if OPTIONS.contains(&word.text) {
            return Token { text: name.text[..word.at - name.at].trim_ascii_end(), at: name.at };
        }
    }
    name
}

/// The texture's word for a letter of `-imfchan`. Depth (`z`) is none.
fn channel(letter: &[u8]) -> Option<&'static str> {
    Some(match letter {
        b"r" => "red",
        b"g" => "green",
        b"b" => "blue",
        b"m" => "alpha",
        b"l" => "luminance",
        _ => return None,
    })
}

/// A warning, once for each option, that it is passed over.
pub(super) fn not_applied(option: Token<'_>, faults: &mut Faults<'_>) {
    if faults.first(&option.lossy()) {
        let message = format!("the option `{}` is not applied by this version", option.lossy());
        faults.warning("mtl::option", option, message, "what stands behind it is used without it");
    }
}

fn one(lexer: &mut Lexer<'_>) -> Option<f32> {
    let mut ahead = lexer.clone();
    match ahead.token().map(|t| number(t.text)) {
        Some(Number::Finite(v)) => {
            *lexer = ahead;
            Some(v)
        }
        _ => None,
    }
}

/// Reads one to three numbers; those left out are `default`.
fn up_to_three(lexer: &mut Lexer<'_>, default: f32) -> [f32; 3] {
    std::array::from_fn(|_| one(lexer).unwrap_or(default))
}
