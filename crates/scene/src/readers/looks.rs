//! What becomes of the materials of MTL files.
//!
//! - By default a `phong` material of Kd, Ks and Ns, with `opacity` from d or Tr and `emission` from Ke.
//! - Pm or Pr say that it is meant for physically based rendering: a `mix`, by Pm, of a `phong` material and a `metal`
//!   that reflects Kd at all angles, both as rough as Pr says: a highlight of exponent 2/Pr⁴ − 2 \[Walter2007\] and, for
//!   what is no metal, of 4 %, which plastic and varnish reflect. Without Pr the metal's lobe is as wide as that of Ns.
//! - `illum` 3 and 5, reflection, with a Ks that is not black: a `mix`, by Ks, of Kd and a `mirror`; nothing but a
//!   mirror where Kd is black.
//! - `illum` 4, 6, 7 and 9, refraction or glass, with Ni above 1, and with d below 1 (no image of it) or a Tf that is
//!   not black: `glass`, or `rough_glass` if there is Pr above 0. With Tf it is all glass, which lets through Tf; else
//!   d is the share of its surface that is of Kd and Ks. Other programs write `illum` or Ni alone without meaning.

use super::map::{Map, MapUse, finite};
use super::materials::{rgb, short, unique};
use super::mtl::MtlMaterial;
use super::{Folders, MeshTexture};
use crate::description::{Node, Role, Value};
use std::collections::HashMap;
use std::path::PathBuf;

/// Reflectance of what is no metal at normal incidence: that of an index of 1.5.
const PLASTIC: [f32; 3] = [0.04; 3];
/// Largest exponent of a highlight that a roughness gives.
const MOST_SHININESS: f32 = 1e4;

/// A material of a library and the files of its images that were found.
pub(super) type Known = (MtlMaterial, Vec<(Map, PathBuf)>);

/// What a material is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Look {
    Phong,
    /// With Pm, the share of metal; an image may stand for it.
    Metal(f32),
    /// With the share that reflects as a mirror.
    Mirror(f32),
    /// With the index of refraction and the share that is glass.
    Glass(f32, f32),
}

impl MtlMaterial {
    /// True if it becomes glass.
    pub fn is_glass(&self) -> bool {
        matches!(self.look(), Look::Glass(..))
    }

    /// True if it becomes metal, all or in part.
    pub fn is_metal(&self) -> bool {
        matches!(self.look(), Look::Metal(_))
    }

    /// True if it names an image for that.
    pub fn has_map(&self, of: MapUse) -> bool {
        self.maps.iter().any(|map| map.of == of)
    }

    fn look(&self) -> Look {
        let passes = self.filter.is_some_and(|f| largest(f) > 0.0);
        if let (Some(4 | 6 | 7 | 9), Some(ior)) = (self.model, self.ior)
            && ior > 1.0
            && (self.opacity < 1.0 || passes)
            && !self.has_map(MapUse::Opacity)
        {
            return Look::Glass(ior, if passes { 1.0 } else { 1.0 - self.opacity });
        }
        let metal = self.metal.unwrap_or(0.0);
        if metal > 0.0 || self.has_map(MapUse::Metal) {
            return Look::Metal(metal);
        }
        let mirror = largest(self.specular).min(1.0);
        if matches!(self.model, Some(3 | 5)) && mirror > 0.0 && !self.is_physical() {
            let is_black = largest(self.diffuse) == 0.0 && !self.has_map(MapUse::Diffuse);
            return Look::Mirror(if is_black { 1.0 } else { mirror });
        }
        Look::Phong
    }

    /// True if its roughness is said, so that Ks and Ns are of no account.
    fn is_physical(&self) -> bool {
        self.roughness.is_some() || self.has_map(MapUse::Roughness)
    }
}

fn largest(color: [f32; 3]) -> f32 {
    color.into_iter().fold(0.0, f32::max)
}

/// The nodes of a file: one material per slot, and what they use.
pub(super) struct Looks<'a> {
    folders: &'a Folders,
    prefix: &'a str,
    materials: Vec<Node>,
    /// They follow the materials of the slots, whose number this is.
    parts: Vec<Node>,
    slots: usize,
    textures: Vec<MeshTexture>,
    names: HashMap<String, u32>,
    texture_names: HashMap<String, u32>,
}

impl<'a> Looks<'a> {
    /// For a file with that many slots. Names begin with `prefix`.
    pub fn new(slots: usize, prefix: &'a str, folders: &'a Folders) -> Self {
        Self {
            folders,
            prefix,
            materials: Vec::new(),
            parts: Vec::new(),
            slots,
            textures: Vec::new(),
            names: HashMap::new(),
            texture_names: HashMap::new(),
        }
    }

    /// The materials, those of the slots first, and their textures.
    pub fn finish(mut self) -> (Vec<Node>, Vec<MeshTexture>) {
        self.materials.append(&mut self.parts);
        (self.materials, self.textures)
    }

    /// Adds the material of the next slot.
    pub fn add(&mut self, (said, images): &Known, wanted: &str) {
        let name = unique(wanted, self.prefix, &mut self.names);
        let mut one = One { at: self.materials.len(), wanted, said, images, textures: Vec::new() };
        self.materials.push(Node::new(Role::Material, "phong", name));
        match said.look() {
            Look::Phong => one.phong(self, one.at),
            Look::Metal(amount) => one.metal(self, amount),
            Look::Mirror(share) => one.mirror(self, share),
            Look::Glass(ior, share) => one.glass(self, ior, share),
        }
        one.common(self);
    }

    /// Adds a material that others are made of; its index.
    fn part(&mut self, type_name: &str, wanted: &str, suffix: &str) -> usize {
        let name = unique(&format!("{wanted}/{suffix}"), self.prefix, &mut self.names);
        self.parts.push(Node::new(Role::Material, type_name, name));
        self.slots + self.parts.len() - 1
    }

    fn node(&mut self, at: usize) -> &mut Node {
        if at < self.slots { &mut self.materials[at] } else { &mut self.parts[at - self.slots] }
    }

    fn set(&mut self, at: usize, name: &str, value: impl Into<Value>) {
        self.node(at).set(name, value.into());
    }
}

/// One material on its way to become nodes.
struct One<'a> {
    /// Index of its node.
    at: usize,
    /// Its name without prefix.
    wanted: &'a str,
    said: &'a MtlMaterial,
    images: &'a [(Map, PathBuf)],
    /// The textures that it has so far.
    textures: Vec<(MapUse, usize)>,
}

impl One<'_> {
    fn is_mapped(&self, of: MapUse) -> bool {
        self.images.iter().any(|(map, _)| map.of == of)
    }

    /// Sets a parameter to the material's image for it, or to a value if there is none.
    fn put(
        &mut self,
        to: &mut Looks<'_>,
        at: usize,
        name: &'static str,
        of: MapUse,
        plain: impl Into<Value>,
    ) {
        let plain = plain.into();
        let Some((map, path)) = self.images.iter().find(|(map, _)| map.of == of) else {
            return to.set(at, name, plain);
        };
        let index = match self.textures.iter().find(|(known, _)| *known == of) {
            Some((_, index)) => *index,
            None => {
                let wanted = format!("{}{}", self.wanted, of.suffix());
                let node_name = unique(&wanted, to.prefix, &mut to.texture_names);
                let mut node = texture_node(map, path, node_name, to.folders);
                // Images are made of shares: a lamp's brightness is in its number.
                let brightness = largest(self.said.emission);
                if of == MapUse::Emission && brightness > 1.0 {
                    node.set("gain", short(finite(map.gain * brightness)).into());
                }
                let (path, what) = (path.clone(), of.what());
                to.textures.push(MeshTexture { node, path, uses: Vec::new(), what, plain });
                self.textures.push((of, to.textures.len() - 1));
                to.textures.len() - 1
            }
        };
        let texture = &mut to.textures[index];
        texture.uses.push((at, name));
        let reference: Value = [("texture", Value::from(texture.node.name.as_str()))].into();
        to.set(at, name, reference);
    }

    /// Phong's factors. It answers ambient light as it answers other light.
    fn factors(&mut self, to: &mut Looks<'_>, at: usize, diffuse: [f32; 3]) {
        self.put(to, at, "diffuse", MapUse::Diffuse, rgb(diffuse));
        let (specular, shininess) = self.highlight();
        self.put(to, at, "specular", MapUse::Specular, rgb(specular));
        to.set(at, "shininess", short(shininess));
        self.put(to, at, "ambient", MapUse::Diffuse, rgb(diffuse));
    }

    /// Factor and exponent of the highlight.
    fn highlight(&self) -> ([f32; 3], f32) {
        let has_none = matches!(self.said.model, Some(0 | 1));
        match self.said.roughness {
            Some(r) => {
                let squared_alpha = (r * r * r * r).max(1e-8);
                let shininess = (2.0 / squared_alpha - 2.0).min(MOST_SHININESS);
                (if has_none { [0.0; 3] } else { PLASTIC }, shininess)
            }
            None => (self.said.specular, self.said.shininess),
        }
    }

    fn phong(&mut self, to: &mut Looks<'_>, at: usize) {
        self.factors(to, at, self.said.diffuse);
    }

    fn mix(to: &mut Looks<'_>, at: usize, [a, b]: [usize; 2]) {
        to.node(at).type_name = "mix".to_owned();
        let names = [a, b].map(|part| to.node(part).name.clone());
        to.set(at, "a", names[0].as_str());
        to.set(at, "b", names[1].as_str());
    }

    fn metal(&mut self, to: &mut Looks<'_>, amount: f32) {
        let is_whole = amount >= 1.0 && !self.is_mapped(MapUse::Metal);
        let at = if is_whole {
            to.node(self.at).type_name = "metal".to_owned();
            self.at
        } else {
            let base = to.part("phong", self.wanted, "base");
            let metal = to.part("metal", self.wanted, "metal");
            self.phong(to, base);
            Self::mix(to, self.at, [base, metal]);
            self.put(to, self.at, "amount", MapUse::Metal, short(amount));
            metal
        };
        // n = 0: reflects everything, times its tint.
        to.set(at, "n", [0.0; 3]);
        to.set(at, "k", [1.0; 3]);
        self.put(to, at, "tint", MapUse::Diffuse, rgb(self.said.diffuse.map(|c| c.min(1.0))));
        // α² = 2/(Ns + 2), and the roughness is the root of α.
        let of_exponent = (2.0 / (self.said.shininess + 2.0)).sqrt().sqrt();
        let roughness = self.said.roughness.unwrap_or(of_exponent);
        self.put(to, at, "roughness", MapUse::Roughness, short(roughness));
    }

    fn mirror(&mut self, to: &mut Looks<'_>, share: f32) {
        let at = if share >= 1.0 {
            to.node(self.at).type_name = "mirror".to_owned();
            self.factors(to, self.at, self.said.diffuse);
            self.at
        } else {
            let base = to.part("phong", self.wanted, "base");
            let mirror = to.part("mirror", self.wanted, "mirror");
            let diffuse = self.said.diffuse.map(|c| (c / (1.0 - share)).min(1.0));
            self.put(to, base, "diffuse", MapUse::Diffuse, rgb(diffuse));
            self.put(to, base, "ambient", MapUse::Diffuse, rgb(diffuse));
            Self::mix(to, self.at, [base, mirror]);
            to.set(self.at, "amount", short(share));
            to.set(mirror, "diffuse", [0.0; 3]);
            mirror
        };
        let whole = largest(self.said.specular).max(f32::MIN_POSITIVE);
        let reflectance = self.said.specular.map(|c| if share < 1.0 { c / whole } else { c }.min(1.0));
        self.put(to, at, "reflectance", MapUse::Specular, rgb(reflectance));
    }

    fn glass(&mut self, to: &mut Looks<'_>, ior: f32, share: f32) {
        let is_rough = self.said.roughness.is_some_and(|r| r > 0.0) || self.is_mapped(MapUse::Roughness);
        let type_name = if is_rough { "rough_glass" } else { "glass" };
        let at = if share >= 1.0 {
            to.node(self.at).type_name = type_name.to_owned();
            self.at
        } else {
            let base = to.part("phong", self.wanted, "base");
            let glass = to.part(type_name, self.wanted, "glass");
            self.phong(to, base);
            Self::mix(to, self.at, [base, glass]);
            to.set(self.at, "amount", short(share));
            glass
        };
        to.set(at, "ior", short(ior));
        to.set(at, "transmit", rgb(self.said.filter.unwrap_or([1.0; 3]).map(|c| c.min(1.0))));
        if is_rough {
            self.put(to, at, "roughness", MapUse::Roughness, short(self.said.roughness.unwrap_or(0.0)));
        } else {
            self.factors(to, at, self.said.diffuse);
        }
    }

    /// What every material has.
    fn common(&mut self, to: &mut Looks<'_>) {
        let opacity = self.said.opacity;
        if self.is_mapped(MapUse::Opacity) || (opacity < 1.0 && !self.said.is_glass()) {
            self.put(to, self.at, "opacity", MapUse::Opacity, short(opacity));
        }
        if self.is_mapped(MapUse::Emission) || largest(self.said.emission) > 0.0 {
            self.put(to, self.at, "emission", MapUse::Emission, rgb(self.said.emission));
        }
    }
}

fn texture_node(map: &Map, path: &std::path::Path, name: String, folders: &Folders) -> Node {
    let mut file = Value::from(folders.name_of(path));
    file.span = map.span;
    let mut node = Node::new(Role::Texture, "image", name).with("file", file);
    if map.scale != [1.0; 2] {
        node = node.with("scale", map.scale.map(short));
    }
    if map.offset != [0.0; 2] {
        node = node.with("offset", map.offset.map(short));
    }
    if map.clamp {
        node = node.with("wrap", "clamp");
    }
    if !map.of.is_color() {
        node = node.with("encoding", "linear");
    }
    if let Some(channel) = map.channel {
        node = node.with("channel", channel);
    }
    for (param, value, neutral) in [("base", map.base, 0.0), ("gain", map.gain, 1.0)] {
        if value != neutral {
            node = node.with(param, short(value));
        }
    }
    node
}
