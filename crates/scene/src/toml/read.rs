//! From a TOML text to nodes.

use super::syntax::report_syntax;
use super::values::params;
use crate::diagnostic::Diagnostics;
use crate::native::{self, NativeScene, Syntax};
use crate::span::FileId;
use ::toml::de::DeTable;

/// Reads a scene file and reports all its faults to `out`. Spans count in `text`, under the name `file`. The
/// types of nodes and their parameters are not checked here.
pub fn read_toml(text: &str, file: FileId, out: &mut Diagnostics) -> NativeScene {
    let (root, errors) = DeTable::parse_recoverable(text);
    if report_syntax(file, text, &errors, out) {
        return NativeScene::default();
    }
    native::read(params(file, root.get_ref()), text, file, Syntax::Toml, out)
}
