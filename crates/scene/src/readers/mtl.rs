//! MTL, Wavefront's material libraries \[WavefrontMtl\], and what other programs have added: numbers for physically
//! based rendering (`Pr`, `Pm`) and emission (`Ke`).
//!
//! Read: `newmtl`, `Kd`, `Ks`, `Ke`, `Ns`, `d`, `Tr`, `Tf`, `Ni`, `illum`, `Pr`, `Pm`, and the images `map_Kd`, `map_Ks`,
//! `map_Ke`, `map_d`, `map_Tr`, `map_Pr`, `map_Pm` with their options; what becomes of them says [`super::looks`]. An
//! image replaces its number. `Tr` is 1 − `d`; `d` counts if they contradict each other. `Ka` is not used: programs
//! write it without meaning; the answer to ambient light is that to other light. What the renderer does not have, such
//! as bump maps, is left out with one warning for each kind.

use super::faults::Faults;
use super::lexer::{Lexer, Number, Token, integer, number};
use super::map::{Map, MapUse, not_applied};
use crate::diagnostic::Severity;
use std::collections::HashSet;

/// One material of a library.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlMaterial {
    pub name: String,
    pub diffuse: [f32; 3],
    pub specular: [f32; 3],
    pub shininess: f32,
    pub emission: [f32; 3],
    /// Share of the surface that is there.
    pub opacity: f32,
    /// Factor of the light that passes.
    pub filter: Option<[f32; 3]>,
    /// Index of refraction, if it is said and one.
    pub ior: Option<f32>,
    /// Number of the illumination model.
    pub model: Option<u8>,
    /// Roughness, the square root of GGX's α.
    pub roughness: Option<f32>,
    /// Share of metal.
    pub metal: Option<f32>,
    /// At most one for each use.
    pub maps: Vec<Map>,
}

impl MtlMaterial {
    /// A material of that name about which nothing is said.
    pub fn named(name: String) -> Self {
        Self {
            name,
            diffuse: [0.8; 3],
            specular: [0.0; 3],
            shininess: 16.0,
            emission: [0.0; 3],
            opacity: 1.0,
            filter: None,
            ior: None,
            model: None,
            roughness: None,
            metal: None,
            maps: Vec::new(),
        }
    }
}

/// Statements that are never missed.
const SILENT: [&str; 5] = ["Ka", "map_Ka", "sharpness", "map_aat", "Pcr"];
/// What a renderer could show and this one does not, by kind, and the statements for it.
const LEFT_OUT: [(&str, &[&str]); 8] = [
    ("bump and normal maps", &["bump", "map_bump", "map_Bump", "norm", "map_norm", "map_Norm", "map_Kn"]),
    ("displacement maps", &["disp", "map_disp", "map_Disp"]),
    ("decals", &["decal", "map_decal"]),
    ("reflection maps", &["refl", "map_refl"]),
    ("maps of `Ns`", &["map_Ns"]),
    ("sheen and its maps", &["Ps", "map_Ps"]),
    ("clear coats and anisotropy", &["Pc", "map_Pc", "map_Pcr", "aniso", "anisor", "map_aniso"]),
    ("factors of transmission and reflection", &["Kt", "Kr", "Km"]),
];

/// What is said about transparency in two ways.
#[derive(Clone, Copy, Default)]
struct Said<'a> {
    d: Option<(f32, Token<'a>)>,
    tr: Option<(f32, Token<'a>)>,
}

/// Reads a library. Faults are warnings: what cannot be read keeps its default. `names`: those of the materials before,
/// also of other libraries.
pub(super) fn parse(bytes: &[u8], names: &mut HashSet<String>, faults: &mut Faults<'_>) -> Vec<MtlMaterial> {
    let mut lexer = Lexer::new(bytes, true);
    let mut materials: Vec<MtlMaterial> = Vec::new();
    let mut said: Vec<Said<'_>> = Vec::new();
    while lexer.next_word_line() {
        let Some(word) = lexer.token() else { continue };
        match (word.text, materials.last_mut(), said.last_mut()) {
            (b"newmtl", _, _) => {
                materials.push(MtlMaterial::named(name(&mut lexer, word, names, faults)));
                said.push(Said::default());
            }
            (b"d", Some(_), Some(s)) => s.d = dissolve(&mut lexer, word, faults).or(s.d),
            (b"Tr", Some(_), Some(s)) => s.tr = dissolve(&mut lexer, word, faults).or(s.tr),
            (_, Some(m), _) => statement(&mut lexer, word, m, faults),
            (_, None, _) => before_material(word, faults),
        }
        lexer.next_line();
    }
    for (material, said) in materials.iter_mut().zip(said) {
        finish(material, said, faults);
    }
    materials
}

/// Reads the name of a material.
fn name(
    lexer: &mut Lexer<'_>,
    word: Token<'_>,
    names: &mut HashSet<String>,
    faults: &mut Faults<'_>,
) -> String {
    let found = lexer.rest();
    let name = found.map_or_else(String::new, |t| t.lossy());
    if found.is_none() {
        let help = "write `newmtl NAME`; faces behind a `usemtl` without a name get it";
        faults.warning("mtl::name", word, "found `newmtl` without a name, expected one", help);
    }
    if !names.insert(name.clone()) {
        let at = found.unwrap_or(word);
        let message = format!("the material `{}` is defined twice: the first counts", at.shortened());
        faults.warning("mtl::twice", at, message, "rename or remove one of them");
    }
    name
}

/// Reads what stands behind a word that begins neither a material nor tells of its transparency.
fn statement(lexer: &mut Lexer<'_>, word: Token<'_>, m: &mut MtlMaterial, faults: &mut Faults<'_>) {
    match word.text {
        b"Kd" => m.diffuse = shares(lexer, word, faults).unwrap_or(m.diffuse),
        b"Ks" => m.specular = shares(lexer, word, faults).unwrap_or(m.specular),
        b"Ke" => m.emission = color(lexer, word, faults).unwrap_or(m.emission),
        b"Tf" => m.filter = shares(lexer, word, faults).or(m.filter),
        b"Ns" => m.shininess = any(lexer, word, faults).unwrap_or(m.shininess),
        b"Ni" => m.ior = index(lexer, word, faults),
        b"Pr" => m.roughness = share(lexer, word, faults).map(|(v, _)| v).or(m.roughness),
        b"Pm" => m.metal = share(lexer, word, faults).map(|(v, _)| v).or(m.metal),
        b"illum" => m.model = model(lexer, word, faults),
        text => match MapUse::of_statement(text) {
            Some(of) => {
                if let Some(map) = Map::read(lexer, word, of, faults) {
                    m.maps.retain(|other| other.of != map.of);
                    m.maps.push(map);
                }
            }
            None => other(lexer, word, faults),
        },
    }
}

/// Settles what depends on several statements.
fn finish(material: &mut MtlMaterial, said: Said<'_>, faults: &mut Faults<'_>) {
    // Models without a highlight.
    if matches!(material.model, Some(0 | 1)) {
        material.specular = [0.0; 3];
        material.maps.retain(|map| map.of != MapUse::Specular);
    }
    material.opacity = opacity(material, said, faults);
    if material.opacity == 0.0 && !material.has_map(MapUse::Opacity) && !material.is_glass() {
        tell_invisible(material, said, faults);
    }
    drop_roughness(material, faults);
}

/// Share of the surface that is there.
fn opacity(material: &MtlMaterial, said: Said<'_>, faults: &mut Faults<'_>) -> f32 {
    match (said.d, said.tr) {
        (Some((d, at)), Some((tr, _))) => {
            if (1.0 - tr - d).abs() > 0.01 && faults.first("\nTr") {
                let message = format!(
                    "`{}` has `d {d}` and `Tr {tr}`, expected `Tr` to be 1 − `d`: `Tr` is not used",
                    shown(material)
                );
                let help =
                    "`d` is the share of the surface that is there, `Tr` that of the holes; remove one";
                faults.warning("mtl::transparency", at, message, help);
            }
            d
        }
        (Some((d, _)), None) => d,
        (None, Some((tr, _))) => 1.0 - tr,
        (None, None) => 1.0,
    }
}

fn tell_invisible(material: &MtlMaterial, said: Said<'_>, faults: &mut Faults<'_>) {
    if let Some((_, at)) = said.d.or(said.tr)
        && faults.first("\ninvisible")
    {
        let message = format!("`{}` is wholly transparent: its faces are not seen", shown(material));
        faults.warning("mtl::transparency", at, message, "`d 1` and `Tr 0` are opaque");
    }
}

/// Only metal and glass have a roughness that an image may tell of.
fn drop_roughness(material: &mut MtlMaterial, faults: &mut Faults<'_>) {
    let Some(at) = material.maps.iter().position(|map| map.of == MapUse::Roughness) else { return };
    if material.is_metal() || material.is_glass() {
        return;
    }
    let map = material.maps.remove(at);
    if faults.first("\nmap_Pr") {
        let message = "maps of the roughness are rendered for metal and glass alone, and left out here";
        let help = "`Pm 1` makes metal; without the map the roughness is that of `Pr` or `Ns`";
        faults.at_span(Severity::Warning, "mtl::left-out", map.span, message, help);
    }
}

/// The material's name for a message.
fn shown(material: &MtlMaterial) -> String {
    Token { text: material.name.as_bytes(), at: 0 }.shortened()
}

fn before_material(word: Token<'_>, faults: &mut Faults<'_>) {
    if faults.first("\nnewmtl") {
        let message = format!("found `{}` before any `newmtl`: passed over", word.shortened());
        faults.warning("mtl::order", word, message, "begin each material with a line `newmtl NAME`");
    }
}

/// Says what is left out; nothing about numbers that are all zero, which ask for nothing.
fn other(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) {
    let text = word.shortened();
    if SILENT.contains(&text.as_str()) {
        return;
    }
    let Some((kind, _)) = LEFT_OUT.iter().find(|(_, words)| words.contains(&text.as_str())) else {
        if faults.first(&text) {
            let message = format!("`{text}` is no statement of MTL that is known here");
            let help = "it is passed over; materials are made of newmtl, Kd, Ks, Ns, d, Ke, Pr, Pm, map_Kd and so on";
            let span = faults.span(word.at, word.text.len());
            faults.at_span(Severity::Advice, "mtl::unknown", span, message, help);
        }
        return;
    };
    if std::iter::from_fn(|| lexer.token()).all(|v| number(v.text) == Number::Finite(0.0)) {
        return;
    }
    if faults.first(kind) {
        let message = format!("`{text}`: {kind} are not rendered and left out");
        faults.warning("mtl::left-out", word, message, "the material is rendered without them");
    }
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
            let message = format!("`{}`: found {n} numbers, expected 3: r g b", word.lossy());
            let help = "write three numbers from 0 to 1, or one for grey; the default is used";
            faults.warning("mtl::numbers", word, message, help);
            None
        }
    }
}

/// Reads a colour of numbers from 0 to 1; larger ones are taken as 1 with a warning.
fn shares(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<[f32; 3]> {
    let first = lexer.clone().token();
    let color = color(lexer, word, faults)?;
    if let (Some(at), Some(v)) = (first, color.into_iter().find(|v| *v > 1.0)) {
        let message = format!("`{}` is {v:?}, expected numbers from 0 to 1", word.lossy());
        faults.warning("mtl::number", at, message, "larger ones are taken as 1");
    }
    Some(color.map(|v| v.min(1.0)))
}

/// Reads an index of refraction.
fn index(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<f32> {
    let at = lexer.clone().token().unwrap_or(word);
    let found = any(lexer, word, faults)?;
    if found > 0.0 && found <= 1000.0 {
        return Some(found);
    }
    let message = format!("`Ni` is {}, expected a number above 0, at most 1000", at.shortened());
    faults.warning("mtl::number", at, message, "it is not used; air has 1, glass 1.5");
    None
}

/// Reads the number of an illumination model.
fn model(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<u8> {
    let Some(text) = lexer.token() else {
        missing(word, "0 to 10", faults);
        return None;
    };
    let found = integer(text.text).and_then(|n| u8::try_from(n).ok()).filter(|n| *n <= 10);
    if found.is_none() {
        let message = format!("`illum` is `{}`, expected a whole number from 0 to 10", text.shortened());
        faults.warning("mtl::number", text, message, "it is not used; 2 is a surface with a highlight");
    }
    found
}

/// Reads one number that must not be negative.
fn any(lexer: &mut Lexer<'_>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<f32> {
    match lexer.token() {
        Some(text) => value(text, faults),
        None => {
            missing(word, "0 to 1000", faults);
            None
        }
    }
}

/// Reads a number from 0 to 1; larger ones are taken as 1 with a warning.
fn share<'a>(lexer: &mut Lexer<'a>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<(f32, Token<'a>)> {
    let Some(text) = lexer.token() else {
        missing(word, "0 to 1", faults);
        return None;
    };
    let v = value(text, faults)?;
    if v > 1.0 {
        let message = format!("`{}` is {}, expected 0 to 1", word.lossy(), text.shortened());
        faults.warning("mtl::number", text, message, "it is taken as 1");
    }
    Some((v.min(1.0), text))
}

/// Reads the share behind `d` or `Tr`.
fn dissolve<'a>(lexer: &mut Lexer<'a>, word: Token<'_>, faults: &mut Faults<'_>) -> Option<(f32, Token<'a>)> {
    let mut ahead = lexer.clone();
    if let Some(option) = ahead.token()
        && option.text == b"-halo"
    {
        not_applied(option, faults);
        *lexer = ahead;
    }
    share(lexer, word, faults)
}

fn missing(word: Token<'_>, range: &str, faults: &mut Faults<'_>) {
    let name = word.lossy();
    let message = format!("`{name}` has no number, expected one from {range}");
    faults.warning("mtl::numbers", word, message, format!("write `{name} 1`; the default is used"));
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
