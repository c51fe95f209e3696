//! What a scene says, in one number.

use crate::assets::Assets;
use crate::description::{Node, NodeId, Param, SceneDescription, Value, ValueKind};
use std::collections::BTreeMap;

impl SceneDescription {
    /// BLAKE3 hash, in hexadecimal, of everything that the scene says and of the contents of its files: equal for
    /// scenes that differ only in places, in the order of parameters, or in the names of files. The order of nodes
    /// counts, for what is built follows it.
    pub fn digest(&self, assets: &Assets) -> String {
        let mut writer = Writer { hasher: blake3::Hasher::new() };
        let files: BTreeMap<NodeId, [u8; 32]> = assets.content_hashes().collect();
        writer.text("penombre scene 1");
        writer.count(self.len());
        for (id, node) in self.iter() {
            writer.node(node, files.get(&id));
        }
        writer.hasher.finalize().to_hex().to_string()
    }
}

/// Writes values so that no two lists of values give the same bytes: each is preceded by its kind or length.
struct Writer {
    hasher: blake3::Hasher,
}

impl Writer {
    fn bytes(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
    }

    fn count(&mut self, n: usize) {
        self.bytes(&(n as u64).to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.count(text.len());
        self.bytes(text.as_bytes());
    }

    fn node(&mut self, node: &Node, file: Option<&[u8; 32]>) {
        self.text(node.role.name());
        self.text(&node.type_name);
        self.text(&node.name);
        self.count(node.children.len());
        node.children.iter().for_each(|child| self.count(child.0 as usize));
        // Where the content of the file is known, its name says nothing more.
        let said = |p: &&Param| file.is_none() || p.name != "file";
        self.params(node.params.iter().filter(said).collect());
        self.bytes(&[u8::from(file.is_some())]);
        self.bytes(file.map_or(&[], |hash| hash));
    }

    fn params(&mut self, mut params: Vec<&Param>) {
        params.sort_by(|a, b| a.name.cmp(&b.name));
        self.count(params.len());
        for param in params {
            self.text(&param.name);
            self.value(&param.value);
        }
    }

    fn value(&mut self, value: &Value) {
        match &value.kind {
            ValueKind::Bool(b) => self.bytes(&[0, u8::from(*b)]),
            ValueKind::Int(i) => {
                self.bytes(&[1]);
                self.bytes(&i.to_le_bytes());
            }
            ValueKind::Float(v) => {
                self.bytes(&[2]);
                self.bytes(&v.to_bits().to_le_bytes());
            }
            ValueKind::String(s) => {
                self.bytes(&[3]);
                self.text(s);
            }
            ValueKind::Array(list) => {
                self.bytes(&[4]);
                self.count(list.len());
                list.iter().for_each(|v| self.value(v));
            }
            ValueKind::Table(entries) => {
                self.bytes(&[5]);
                self.params(entries.iter().collect());
            }
        }
    }
}
