//! The native scene format in JSON: the same keys as in TOML, for programs that write scenes.
//!
//! ```json
//! {
//!   "penombre": 1,
//!   "render": { "spp": 64 },
//!   "shape": { "ball": { "type": "sphere", "radius": 1 } }
//! }
//! ```
//!
//! JSON as in RFC 8259, with `Infinity` and `-Infinity` beside the numbers. A key may stand once in an object. `$schema` at the top
//! tells editors where the schema lies that `penombre schema` prints.

mod parse;
#[cfg(test)]
mod tests;
mod write;

use crate::description::ValueKind;
use crate::diagnostic::Diagnostics;
use crate::native::{self, NativeScene, Syntax};
use crate::span::{FileId, Span};

pub use write::write_json;

/// Reads a scene file and reports all its faults to `out`: of faults of syntax the first. Spans count in `text`, under the
/// name `file`. The types of nodes and their parameters are not checked here.
pub fn read_json(text: &str, file: FileId, out: &mut Diagnostics) -> NativeScene {
    let value = match parse::parse(text, file) {
        Ok(value) => value,
        Err(fault) => {
            out.error("json::syntax", fault.span, fault.message).help = fault.help;
            return NativeScene::default();
        }
    };
    match value.kind {
        ValueKind::Table(root) => native::read(root, text, file, Syntax::Json, out),
        _ => {
            let message = format!("the file holds {}, expected an object", crate::params::found(&value));
            let at = Span { len: 1, ..value.span };
            out.error("json::no-object", at, message).help = "write { \"penombre\": 1, … }".to_owned();
            NativeScene::default()
        }
    }
}
