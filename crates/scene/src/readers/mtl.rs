//! MTL, Wavefront's material libraries \[WavefrontMtl\].
//!
//! Used: `newmtl`, `Kd`, `Ks`, `Ns`, `illum` 0 and 1 (no highlight), `map_Kd` with `-s` and `-clamp`. A map replaces
//! `Kd`. `Ka` is not used: programs write it without meaning; the answer to ambient light is that to other light.

use super::faults::Faults;
use super::lexer::{Lexer, Number, Token, number};
use crate::diagnostic::Severity;
use crate::span::Span;

/// One material of a library.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlMaterial {
    pub name: String,
    pub diffuse: [f32; 3],
    pub specular: [f32; 3],
    pub shininess: f32,
    pub map: Option<Map>,
}

/// An image for the diffuse colour.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// The file as the library names it, with forward slashes.
    pub file: String,
    pub span: Span,
    /// Repetitions per unit of u and v.
    pub scale: [f32; 2],
    pub clamp: bool,
}

impl MtlMaterial {
    /// A material of that name about which nothing is said.
    pub fn named(name: String) -> Self {
        Self { name, diffuse: [0.8; 3], specular: [0.0; 3], shininess: 16.0, map: None }
    }
}

/// Statements that mean the same as what is rendered without them, with that value.
const NEUTRAL: [(&str, &str); 5] = [("d", "1"), ("Tr", "0"), ("Ke", "0"), ("Pm", "0"), ("aniso", "0")];
/// Statements that are never missed.
const SILENT: [&str; 6] = ["Ka", "Ni", "map_Ka", "illum", "sharpness", "map_aat"];
/// Statements that a renderer could use and this version does not.
const UNUSED: [&str; 33] = [
    "d",
    "Tr",
    "Tf",
    "Ke",
    "Kt",
    "Kr",
    "map_Ks",
    "map_Ns",
    "map_Ke",
    "map_d",
    "map_bump",
    "map_Bump",
    "bump",
    "disp",
    "decal",
    "refl",
    "norm",
    "Pr",
    "Pm",
    "Ps",
    "Pc",
    "Pcr",
    "aniso",
    "anisor",
    "map_Pr",
    "map_Pm",
    "map_Ps",
    "map_Tr",
    "map_refl",
    "map_Disp",
    "map_disp",
    "map_opacity",
    "Km",
];

/// Reads a library. Faults are warnings: what cannot be read keeps its default.
pub(super) fn parse(bytes: &[u8], faults: &mut Faults<'_>) -> Vec<MtlMaterial> {
    let mut lexer = Lexer::new(bytes, true);
    let mut materials: Vec<MtlMaterial> = Vec::new();
    let mut unused: Vec<(Token<'_>, String)> = Vec::new();
    let mut matte = Vec::new();
    while lexer.next_word_line() {
        let Some(word) = lexer.token() else { continue };
        match (word.text, materials.last_mut()) {
            (b"newmtl", _) => {
                let name = lexer.rest().map_or_else(String::new, |t| t.lossy());
                materials.push(MtlMaterial::named(name));
                matte.push(false);
            }
            (b"Kd", Some(m)) => m.diffuse = color(&mut lexer, word, faults).unwrap_or(m.diffuse),
            (b"Ks", Some(m)) => m.specular = color(&mut lexer, word, faults).unwrap_or(m.specular),
            (b"Ns", Some(m)) => m.shininess = shininess(&mut lexer, word, faults).unwrap_or(m.shininess),
            (b"map_Kd", Some(m)) => m.map = map(&mut lexer, word, faults).or(m.map.take()),
            (b"illum", Some(_)) => {
                let model = lexer.token();
                *matte.last_mut().expect("one per material") =
                    model.is_some_and(|t| matches!(t.text, b"0" | b"1"));
            }
            (_, None) => before_material(word, faults),
            (_, Some(_)) => other(&mut lexer, word, &mut unused, faults),
        }
        lexer.next_line();
    }
    for (material, _) in materials.iter_mut().zip(&matte).filter(|(_, matte)| **matte) {
        material.specular = [0.0; 3];
    }
    tell_unused(&unused, faults);
    materials
}

fn before_material(word: Token<'_>, faults: &mut Faults<'_>) {
    if faults.first("\nnewmtl") {
        let message = format!("found `{}` before any `newmtl`: passed over", word.shortened());
        faults.warning("mtl::order", word, message, "begin each material with a line `newmtl NAME`");
    }
}

fn other<'a>(
    lexer: &mut Lexer<'a>,
    word: Token<'a>,
    unused: &mut Vec<(Token<'a>, String)>,
    faults: &mut Faults<'_>,
) {
    let text = word.shortened();
    if SILENT.contains(&text.as_str()) {
        return;
    }
    if !UNUSED.contains(&text.as_str()) {
        if faults.first(&text) {
            let message = format!("`{text}` is no statement of MTL that is known here");
            let help = "it is passed over; what is read is newmtl, Kd, Ks, Ns, illum and map_Kd";
            advice("mtl::unknown", word, message, help, faults);
        }
        return;
    }
    let zero_or_one = NEUTRAL.iter().find(|(name, _)| *name == text);
    let neutral: Option<f32> = zero_or_one.and_then(|(_, value)| value.parse().ok());
    let mut values = std::iter::from_fn(|| lexer.token());
    if let Some(neutral) = neutral
        && values.all(|v| number(v.text) == Number::Finite(neutral))
    {
        return;
    }
    if !unused.iter().any(|(_, known)| *known == text) {
        unused.push((word, text));
    }
}

fn advice(code: &'static str, word: Token<'_>, message: String, help: &str, faults: &mut Faults<'_>) {
    let span = faults.span(word.at, word.text.len());
    faults.at_span(Severity::Advice, code, span, message, help);
}

/// One remark per library about all that would change the picture and is not used.
fn tell_unused(unused: &[(Token<'_>, String)], faults: &mut Faults<'_>) {
    let Some((first, _)) = unused.first() else { return };
    let names: Vec<&str> = unused.iter().map(|(_, name)| name.as_str()).collect();
    let message = format!("not used by this version: {}", names.join(", "));
    let help = "for mirrors, glass and the like give the shape a `material` of the scene";
    advice("mtl::unused", *first, message, help, faults);
}

/// Reads `r g b` or one number for grey. `None` after a fault.
fn color(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<[f32; 3]> {
    let mut values = [0.0f32; 3];
    let mut found = 0;
    while let (true, Some(text)) = (found < 3, lexer.token()) {
        values[found] = value(text, faults)?;
        found += 1;
    }
    match found {
        1 => Some([values[0]; 3]),
        3 => Some(values),
        n => {
            let message = format!("`{}` has {n} numbers, expected 3: r g b", word.lossy());
            let help = "write three numbers from 0 to 1, or one for grey; the default is used";
            faults.warning("mtl::numbers", word, message, help);
            None
        }
    }
}

fn shininess(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<f32> {
    match lexer.token() {
        Some(text) => value(text, faults),
        None => {
            let message = "`Ns` has no number, expected one from 0 to 1000";
            faults.warning("mtl::numbers", word, message, "write `Ns 30`; the default is used");
            None
        }
    }
}

/// Reads a number that must not be negative.
fn value(text: Token<'_>, faults: &mut Faults<'_>) -> Option<f32> {
    match number(text.text) {
        Number::Finite(v) if v >= 0.0 => Some(v),
        _ => {
            let message = format!("found `{}`, expected a number, 0 or more", text.shortened());
            faults.warning("mtl::number", text, message, "numbers look like 0.5; the default is used");
            None
        }
    }
}

/// Reads the options and the file name of a map.
fn map(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<Map> {
    let mut found = Map { file: String::new(), span: Span::NONE, scale: [1.0; 2], clamp: false };
    loop {
        let mut ahead = lexer.clone();
        match ahead.token() {
            Some(option) if option.text.starts_with(b"-") => {
                *lexer = ahead;
                option_of(lexer, option, &mut found, faults);
            }
            _ => break,
        }
    }
    let Some(name) = lexer.rest() else {
        let message = format!("`{}` names no file", word.lossy());
        faults.warning("mtl::map", word, message, "write `map_Kd FILE.png`; the plain colour is used");
        return None;
    };
    let text = name.lossy();
    let unquoted = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')).unwrap_or(&text);
    found.file = unquoted.replace('\\', "/");
    found.span = faults.span(name.at, name.text.len());
    Some(found)
}

/// Reads the arguments of one option.
fn option_of(lexer: &mut Lexer<'_>, option: Token<'_>, map: &mut Map, faults: &mut Faults<'_>) {
    match option.text {
        b"-s" => {
            let [u, v, _] = up_to_three(lexer, 1.0);
            map.scale = [u, v];
        }
        b"-clamp" => map.clamp = lexer.token().is_some_and(|t| t.text == b"on"),
        b"-o" | b"-t" => {
            if up_to_three(lexer, 0.0) != [0.0; 3] {
                not_applied(option, faults);
            }
        }
        b"-mm" => {
            if (one(lexer), one(lexer)) != (Some(0.0), Some(1.0)) {
                not_applied(option, faults);
            }
        }
        b"-blendu" | b"-blendv" => {
            if lexer.token().is_none_or(|t| t.text != b"on") {
                not_applied(option, faults);
            }
        }
        b"-boost" | b"-cc" | b"-texres" | b"-bm" | b"-imfchan" | b"-type" => {
            lexer.token();
            not_applied(option, faults);
        }
        _ => {
            let message = format!("`{}` is no option of a map", option.shortened());
            let help = "it is passed over with the word behind it; what is read is -s and -clamp";
            faults.warning("mtl::option", option, message, help);
            lexer.token();
        }
    }
}

fn not_applied(option: Token<'_>, faults: &mut Faults<'_>) {
    if faults.first(&option.lossy()) {
        let message = format!("the option `{}` of a map is not applied by this version", option.lossy());
        faults.warning("mtl::option", option, message, "the image is used without it");
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
