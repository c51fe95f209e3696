//! `penombre check`.

use crate::args::{CheckArgs, Verbosity};
use crate::memory::Use;
use crate::scene::examine;
use crate::{Exit, report, terminal};
use penombre_scene::report::to_json;
use penombre_scene::{Severity, harmless};

/// Prints all faults and advice about a scene and renders nothing.
pub fn run(args: &CheckArgs, verbosity: &Verbosity) -> Exit {
    let mut loaded = examine(&args.scene, Use::Tell, verbosity).loaded;
    loaded.diagnostics.sort_by_place();
    let count = |severity| loaded.diagnostics.count(severity);
    let errors = count(Severity::Error);
    if args.json {
        let faults: Vec<_> = loaded.diagnostics.iter().map(|d| to_json(d, &loaded.sources)).collect();
        terminal::out(&serde_json::Value::from(faults).to_string());
    } else {
        report::print(&loaded.diagnostics, &loaded.sources, verbosity.quiet);
        let part = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let (warnings, advice) = (part(count(Severity::Warning), "warning"), count(Severity::Advice));
        let scene = harmless(&args.scene.scene);
        let summary = format!("{scene}: {}, {warnings}, {advice} advice", part(errors, "error"));
        if !verbosity.quiet {
            terminal::out(&summary);
        }
    }
    if errors > 0 { Exit::Usage } else { Exit::Done }
}
