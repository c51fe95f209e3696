//! OBJ, Wavefront's object files \[WavefrontObj\].
//!
//! Read: `v` (with w, which surfaces do not need, or with colours after the position), `vt`, `vn`, `f` in all its
//! forms with positive and negative indices, polygons, `usemtl`, `mtllib`, and `s` for faces without normals. Groups
//! and objects change nothing. Points, lines and free-form surfaces are passed over with a warning. Colours after a
//! position are taken as sRGB and made linear.

mod pieces;

use super::colors::{ColorScale, linear};
use super::encoding;
use super::faults::{Faults, Tally};
use super::lexer::{Lexer, Number, Token, integer, number};
use super::smoothing::Group;
use super::soup::{Corner, NONE, Soup};
use crate::mesh::TriangleMesh;
use penombre_math::{Vec2, Vec3};
use std::collections::HashMap;

/// What an OBJ file holds, before its libraries are read.
pub(super) struct ObjFile<'a> {
    pub mesh: TriangleMesh,
    /// Per slot the word of `usemtl`; `None` for faces before the first one.
    pub slots: Vec<Option<Token<'a>>>,
    /// The rests of the `mtllib` lines.
    pub libraries: Vec<Token<'a>>,
}

/// What the faces from here on are made of.
#[derive(Clone, Copy)]
enum Current<'a> {
    /// As the last `usemtl` says; no face has followed yet.
    Named(Option<Token<'a>>),
    Slot(u32),
}

struct Reader<'a, 'f, 's> {
    lexer: Lexer<'a>,
    faults: &'f mut Faults<'s>,
    soup: Soup<'a>,
    colors: Vec<[f32; 3]>,
    color_scale: ColorScale,
    current: Current<'a>,
    slots: Vec<Option<Token<'a>>>,
    slot_of: HashMap<Option<&'a [u8]>, u32>,
    libraries: Vec<Token<'a>>,
    /// Number of lines whose first word is one of OBJ's.
    known: usize,
    unknown: Tally<'a>,
    tallies: Tallies<'a>,
    not_text: bool,
    /// An index was counted back from the last one.
    counts_back: bool,
}

/// Faults that are reported once for all places.
#[derive(Default)]
struct Tallies<'a> {
    thin: Tally<'a>,
    colors: Tally<'a>,
    normals: Tally<'a>,
    numbers: Tally<'a>,
    attributes: Tally<'a>,
    nul: Tally<'a>,
    names: Tally<'a>,
}

/// Statements of OBJ that are passed over with a warning, and what they are.
const UNUSED: [(&str, &[&str]); 4] = [
    ("points and lines", &["p", "l"]),
    (
        "free-form curves and surfaces",
        &[
            "vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv",
            "sp", "end", "con", "bzp", "bsp", "cdc", "cdp", "res", "ctech", "stech",
        ],
    ),
    ("bone weights", &["vw"]),
    ("scripts and texture libraries", &["call", "csh", "maplib", "usemap"]),
];
/// Statements that change nothing here.
const SILENT: [&str; 7] = ["mg", "bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj"];

const LINES_HELP: &str =
    "lines of OBJ begin with v, vt, vn, f, o, g, s, usemtl, mtllib or, as comments, with #";
const COUNT_HELP: &str = "OBJ counts vertices from 1; negative numbers count back from the last one so far";
const CORNER_HELP: &str =
    "a corner is vertex/texture/normal, each counted from 1 or back from -1; the last two may be left out";

/// Reads an OBJ file. `None` after errors.
pub(super) fn parse<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<ObjFile<'a>> {
    if encoding::is_refused(bytes, faults) {
        return None;
    }
    faults.hold();
    let file = read(bytes, faults);
    faults.tell_in_order();
    file
}

fn read<'a>(bytes: &'a [u8], faults: &mut Faults<'a>) -> Option<ObjFile<'a>> {
    let mut reader = Reader::new(Lexer::new(bytes, true), faults);
    match pieces::read(bytes) {
        Some(pieces) => pieces.into_iter().for_each(|piece| reader.append(piece)),
        None => while reader.line() {},
    }
    reader.check();
    reader.finish()
}

impl<'a, 'f, 's> Reader<'a, 'f, 's> {
    fn new(lexer: Lexer<'a>, faults: &'f mut Faults<'s>) -> Self {
        Self {
            lexer,
            faults,
            soup: Soup::default(),
            colors: Vec::new(),
            color_scale: ColorScale::default(),
            current: Current::Named(None),
            slots: Vec::new(),
            slot_of: HashMap::new(),
            libraries: Vec::new(),
            known: 0,
            unknown: Tally::default(),
            tallies: Tallies::default(),
            not_text: false,
            counts_back: false,
        }
    }

    /// Reads a line; false at the end, or where it makes no sense to go on.
    fn line(&mut self) -> bool {
        let goes_on = !self.faults.is_full() && !self.not_text && self.lexer.next_word_line();
        if goes_on {
            self.statement();
            self.lexer.next_line();
        }
        goes_on
    }

    fn statement(&mut self) {
        let Some(word) = self.lexer.token() else { return };
        self.known += 1;
        match word.text {
            b"v" => self.vertex(word),
            b"vt" => self.uv(word),
            b"vn" => self.normal(word),
            b"f" | b"fo" => self.face(word),
            b"usemtl" => {
                let name = self.name();
                // `usemtl` without a name is a name too: exporters write both `newmtl` and `usemtl` so.
                self.current = Current::Named(Some(name.unwrap_or(Token { text: b"", at: word.at })));
            }
            b"mtllib" => {
                let name = self.name();
                self.libraries.extend(name);
            }
            b"o" | b"g" => _ = self.name(),
            b"s" => self.smoothing(word),
            text => self.other(word, text),
        }
    }

    /// The rest of the line as a name; names that are no UTF-8 are counted.
    fn name(&mut self) -> Option<Token<'a>> {
        let name = self.lexer.rest()?;
        if std::str::from_utf8(name.text).is_err() {
            self.tallies.names.add(name);
        }
        Some(name)
    }

    fn smoothing(&mut self, word: Token<'a>) {
        let said = self.lexer.token();
        self.soup.group = match said.map(|t| (t.text, integer(t.text))) {
            Some((_, Some(n))) => Group::number(n),
            Some((b"on", _)) => Group::number(1),
            None | Some((b"off" | b"null", _)) => Group::OFF,
            Some(_) => {
                if self.faults.first("s") {
                    let found = said.unwrap_or(word);
                    let message =
                        format!("found `{}`, expected a smoothing group or `off`", found.shortened());
                    self.faults.warning(
                        "obj::smoothing",
                        found,
                        message,
                        "write `s 1` or `s off`; it is off",
                    );
                }
                Group::OFF
            }
        };
    }

    fn other(&mut self, word: Token<'a>, text: &[u8]) {
        let text = std::str::from_utf8(text).unwrap_or("\0");
        if SILENT.contains(&text) {
            return;
        }
        if let Some((what, _)) = UNUSED.iter().find(|(_, words)| words.contains(&text)) {
            if self.faults.first(what) {
                let message = format!("`{text}`: {what} are not rendered and passed over");
                self.faults.warning("obj::unused", word, message, "only faces (`f`) are rendered");
            }
            return;
        }
        self.known -= 1;
        self.unknown.add(word);
        if word.text.iter().all(|b| *b == 0) {
            self.tallies.nul.add(word);
        } else if text.chars().any(char::is_control) {
            self.not_text = true;
            let message =
                format!("this is no text: found `{}`, expected a statement of OBJ", word.shortened());
            self.faults.error("obj::not-text", word, message, LINES_HELP);
        } else if self.faults.first(text) {
            let message = format!("`{}` is no statement of OBJ and is passed over", word.shortened());
            self.faults.warning("obj::unknown", word, message, LINES_HELP);
        }
    }

    /// Reads up to `N` numbers of a line. The number of those found, and whether all are finite; `None` after an
    /// error.
    fn numbers<const N: usize>(&mut self, values: &mut [f32; N]) -> Option<(usize, bool)> {
        let mut finite = true;
        for (found, value) in values.iter_mut().enumerate() {
            if let Some(v) = self.lexer.plain_number() {
                *value = v;
                continue;
            }
            let Some(word) = self.lexer.token() else { return Some((found, finite)) };
            match number(word.text) {
                Number::Finite(v) => *value = v,
                Number::NotFinite => {
                    *value = f32::NAN;
                    finite = false;
                }
                fault => {
                    self.faults.bad_number("obj::number", word, fault);
                    return None;
                }
            }
        }
        Some((N, finite))
    }

    fn too_few(&mut self, word: Token<'a>, what: &str, found: usize, expected: &str) {
        let message = format!("{what}: found {found} numbers, expected {expected}");
        let help = "lines look like `v x y z`, `vt u v` and `vn x y z`, with blanks between the numbers";
        self.faults.error("obj::numbers", word, message, help);
    }

    fn vertex(&mut self, word: Token<'a>) {
        let mut v = [0.0f32; 7];
        let read = self.numbers(&mut v);
        let index = self.soup.positions.len();
        self.soup.positions.push(Vec3::new(v[0], v[1], v[2]));
        match read {
            Some((found @ 0..3, _)) => self.too_few(word, "the vertex", found, "at least 3: x y z"),
            Some((found, false)) if v[..3].iter().any(|x| x.is_nan()) => {
                self.soup.broken.push((index as u32, word));
                self.color(word, index, &v, found);
            }
            Some((found, _)) => self.color(word, index, &v, found),
            None => {}
        }
    }

    /// Takes the colour of a vertex line with six or seven numbers.
    fn color(&mut self, word: Token<'a>, index: usize, v: &[f32; 7], found: usize) {
        if found < 6 {
            return;
        }
        let color = [v[3], v[4], v[5]];
        if color.iter().all(|c| c.is_finite()) {
            self.color_scale.see(color, true);
        } else {
            self.tallies.colors.add(word);
        }
        self.colors.resize(index, [f32::NAN; 3]);
        self.colors.push(color);
    }

    fn uv(&mut self, word: Token<'a>) {
        let mut v = [0.0; 3];
        let read = self.numbers(&mut v);
        match read {
            Some((0, _)) => self.too_few(word, "the texture vertex", 0, "1 to 3: u v w"),
            Some((_, false)) => self.tallies.numbers.add(word),
            _ => {}
        }
        let uv = Vec2::new(v[0], v[1]);
        self.soup.uvs.push(if uv.is_finite() { uv } else { Vec2::ZERO });
    }

    fn normal(&mut self, word: Token<'a>) {
        let mut v = [0.0f32; 3];
        let read = self.numbers(&mut v);
        if let Some((found @ 0..3, _)) = read {
            self.too_few(word, "the normal", found, "3: x y z");
        }
        let unit = Vec3::from_array(v).as_dvec3().normalize_or_zero().as_vec3();
        if unit == Vec3::ZERO && read.is_some() {
            self.tallies.normals.add(word);
        }
        self.soup.normals.push(unit);
    }

    fn face(&mut self, word: Token<'a>) {
        loop {
            let here = self.lexer.clone();
            if let Some(indices) = self.lexer.plain_indices() {
                // They count from 1; 0 says that there is none, and so becomes `NONE`.
                let [position, uv, normal] = indices.map(|i| i.wrapping_sub(1));
                if position != NONE {
                    self.soup.corner(Corner { position, uv, normal });
                    continue;
                }
                self.lexer = here;
            }
            let Some(text) = self.lexer.token() else { break };
            match self.corner(text) {
                Some(corner) => self.soup.corner(corner),
                None => return self.soup.drop_corners(),
            }
        }
        if self.soup.open_corners() < 3 {
            self.tallies.thin.add(word);
            return self.soup.drop_corners();
        }
        let slot = self.slot();
        self.soup.finish_polygon(word.at, slot);
    }

    fn slot(&mut self) -> u32 {
        match self.current {
            Current::Slot(slot) => slot,
            Current::Named(name) => {
                let next = self.slots.len() as u32;
                let slot = *self.slot_of.entry(name.map(|n| n.text)).or_insert(next);
                if slot == next {
                    self.slots.push(name);
                }
                self.current = Current::Slot(slot);
                slot
            }
        }
    }

    /// Reads `p`, `p/t`, `p//n` or `p/t/n`. Empty parts are as if absent.
    fn corner(&mut self, word: Token<'a>) -> Option<Corner> {
        let mut parts = word.text.split(|b| *b == b'/');
        let text = parts.next().unwrap_or(b"");
        let position = integer(text);
        let mut attribute = || match parts.next() {
            None | Some(b"") => Some(None),
            Some(text) => integer(text).map(Some),
        };
        let (uv, normal) = (attribute(), attribute());
        let (Some(position), Some(uv), Some(normal), None) = (position, uv, normal, parts.next()) else {
            let message =
                format!("found `{}`, expected a corner such as 7, 7/1, 7//3 or 7/1/3", word.shortened());
            self.faults.error("obj::corner", word, message, CORNER_HELP);
            return None;
        };
        self.counts_back |= [Some(position), uv, normal].into_iter().flatten().any(|i| i < 0);
        let position = match resolved(position, self.soup.positions.len()) {
            Some(index) => index,
            None => {
                let shown = Token { text, at: word.at }.shortened();
                let message = match (position, self.soup.positions.len()) {
                    (0, _) => "found vertex 0 in the face, expected an index from 1".to_owned(),
                    (_, 0) => format!("found vertex {shown} in the face, expected vertices before it"),
                    (_, n) => {
                        format!("found vertex {shown} in the face, expected -{n} to -1: {n} came before")
                    }
                };
                self.faults.error("obj::index", word, message, COUNT_HELP);
                return None;
            }
        };
        let uv = self.attribute(word, "texture vertex", uv, self.soup.uvs.len())?;
        let normal = self.attribute(word, "normal", normal, self.soup.normals.len())?;
        Some(Corner { position, uv, normal })
    }

    /// The index of an attribute, `NONE` if there is none; `None` after an error. Exporters write indices of attributes
    /// that they leave out of the file, so those beyond the list are only told.
    fn attribute(&mut self, word: Token<'a>, what: &str, index: Option<i64>, count: usize) -> Option<u32> {
        let Some(index) = index else { return Some(NONE) };
        if index == 0 {
            let message = format!("found {what} 0 in the face, expected an index from 1");
            self.faults.error("obj::index", word, message, COUNT_HELP);
            return None;
        }
        let found = resolved(index, count);
        if found.is_none() {
            self.tallies.attributes.add(word);
        }
        Some(found.unwrap_or(NONE))
    }

    /// Checks indices against what the whole file holds: a face may stand before its vertices.
    fn check(&mut self) {
        if self.soup.is_tame() {
            return;
        }
        let positions = self.soup.positions.len();
        let (normals, uvs) = (self.soup.normals.len() as u32, self.soup.uvs.len() as u32);
        let wild = |i: u32, count: u32| i != NONE && i >= count;
        for (line, corners) in self.soup.polygons() {
            if self.faults.is_full() {
                return;
            }
            let corners: Vec<Corner> = corners.collect();
            if let Some(k) = corners.iter().position(|c| c.position as usize >= positions) {
                let word = nth_word(&self.lexer, line, k + 1);
                let text = word.text.split(|b| *b == b'/').next().unwrap_or(b"");
                let index = Token { text, at: word.at }.shortened();
                let message = match positions {
                    0 => format!("found vertex {index} in the face, expected vertices: there are none"),
                    n => format!("found vertex {index} in the face, expected 1 to {n}"),
                };
                self.faults.error("obj::index", word, message, COUNT_HELP);
            } else if let Some(k) = corners.iter().position(|c| wild(c.normal, normals) || wild(c.uv, uvs)) {
                self.tallies.attributes.add(nth_word(&self.lexer, line, k + 1));
            }
        }
    }

    fn finish(mut self) -> Option<ObjFile<'a>> {
        if self.known == 0 && self.unknown.count() > self.tallies.nul.count() && !self.faults.failed() {
            let end = nth_word(&self.lexer, 0, 0);
            let message = "found no statement of OBJ, expected lines that begin with `v` and `f`: this is no OBJ file, or not all of it";
            self.faults.error("obj::not-obj", end, message, LINES_HELP);
        }
        self.summary();
        if self.faults.failed() {
            return None;
        }
        self.soup.drop_wild_attributes();
        self.drop_zero_normals();
        if self.color_scale.is_used() {
            self.colors.resize(self.soup.positions.len(), [f32::NAN; 3]);
            let scale = self.color_scale;
            self.soup.colors = self.colors.iter().map(|c| linear(*c, scale)).collect();
        }
        let lexer = self.lexer;
        let mesh = self.soup.into_mesh(self.faults, |at| nth_word(&lexer, at, 0));
        Some(ObjFile { mesh, slots: self.slots, libraries: self.libraries })
    }

    /// Corners whose normal has no direction have none.
    fn drop_zero_normals(&mut self) {
        if self.tallies.normals.count() > 0 {
            self.soup.drop_zero_normals();
        }
    }

    fn summary(&mut self) {
        let t = &self.tallies;
        let mut say = |code, tally: &Tally<'a>, message, help| self.faults.tally(code, tally, message, help);
        say(
            "obj::thin-face",
            &t.thin,
            "a face with fewer than 3 corners is left out",
            "expected `f` and 3 indices or more",
        );
        let help = "a colour is three numbers behind x y z, each from 0 to 1";
        say("obj::color", &t.colors, "a colour is not finite and taken as white", help);
        let help = "a normal is `vn x y z`, not all of them 0";
        say("obj::normal", &t.normals, "a normal has no direction and is not used", help);
        let help = "texture coordinates are `vt u v`, two finite numbers";
        say("obj::uv", &t.numbers, "texture coordinates are not finite and taken as 0", help);
        let message =
            "a corner refers to a normal or to texture coordinates that the file does not have: not used";
        say("obj::attribute", &t.attributes, message, CORNER_HELP);
        say("obj::nul", &t.nul, "NUL bytes are passed over, expected text", "is the file damaged?");
        say("obj::name", &t.names, "a name is not UTF-8", "write the file in UTF-8");
    }
}

/// The index from 0 of an index of a file: from 1, or negative and counted back from the last. Indices beyond 32
/// bits come out as the largest that no list has.
fn resolved(index: i64, count: usize) -> Option<u32> {
    match index {
        0 => None,
        1.. => Some(u32::try_from(index - 1).unwrap_or(NONE - 1).min(NONE - 1)),
        _ => u32::try_from(count as i64 + index).ok(),
    }
}

/// The word number `n` (from 0) of the line at an offset.
fn nth_word<'a>(lexer: &Lexer<'a>, line: usize, n: usize) -> Token<'a> {
    let mut lexer = lexer.at(line);
    let found = std::iter::from_fn(|| lexer.token()).nth(n);
    found.unwrap_or(Token { text: b"", at: line })
}
