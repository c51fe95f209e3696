//! The window on a virtual screen: what that needs, and the step that drives it.

use std::path::Path;

use super::apt;
use crate::run::{Call, Outcome, built, release_binary};

/// What the window and its tests need of Debian.
const PACKAGES: &[&str] = &[
    "xvfb",
    "mesa-vulkan-drivers",
    "libgl1-mesa-dri",
    "libgl1",
    "libegl1",
    "libxkbcommon-x11-0",
    "libxcursor1",
    "libxi6",
    "libxrandr2",
    "xauth",
    "xdotool",
];
/// Programs that the tests start.
const TOOLS: &[&str] = &["Xvfb", "xdotool"];
/// Libraries that the window or the tests load at run time.
const LIBRARIES: &[&str] = &[
    "libEGL.so.1",
    "libX11-xcb.so.1",
    "libXcursor.so.1",
    "libXi.so.6",
    "libXrandr.so.2",
    "libXtst.so.6",
    "libxkbcommon-x11.so.0",
];
/// Folders in which the loader of Vulkan looks for drivers.
const DRIVER_FOLDERS: &[&str] =
    &["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
/// Where the programs and their tests draw without a graphics card.
const SOFTWARE_DRIVER: &str = "lvp_icd";

/// What this machine has of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Screen {
    /// A driver that draws without a graphics card.
    pub driver: bool,
    /// What else is missing.
    pub missing: Vec<&'static str>,
}

impl Screen {
    /// Looks; on Debian, as root, installs what is missing.
    pub fn find_or_install() -> Self {
        let found = Self::find();
        if found.is_whole() || !apt::install("the window's virtual screen", PACKAGES) {
            return found;
        }
        Self::find()
    }

    /// Whether the window can be driven here.
    pub fn is_whole(&self) -> bool {
        self.driver && self.missing.is_empty()
    }

    /// Why not, for a person.
    pub fn why_not(&self) -> String {
        let driver = (!self.driver).then_some("a software driver for Vulkan");
        let missing = driver.iter().chain(&self.missing).copied().collect::<Vec<_>>();
        format!("missing: {} (Debian: apt-get install {})", missing.join(", "), PACKAGES.join(" "))
    }

    fn find() -> Self {
        let libraries =
            ["ldconfig", "/sbin/ldconfig"].iter().find_map(|l| Call::new(*l, &["-p"]).output().ok());
        let libraries = libraries.unwrap_or_default();
        let tools = TOOLS.iter().filter(|tool| !is_program(tool));
        let missing = tools.chain(LIBRARIES.iter().filter(|l| !names_library(&libraries, l))).copied();
        Self { driver: DRIVER_FOLDERS.iter().any(has_driver), missing: missing.collect() }
    }
}

/// Drives the window program that the tests of the workspace have built: building it by itself would compile its
/// libraries once more, with fewer features.
pub fn drive(drive: &Call) -> Outcome {
    Call::cargo(&["test", "--workspace", "--no-run", "--quiet"]).status()?;
    drive.status()
}

/// The call that drives the built programs.
pub fn drive_call(python: &str) -> Call {
    let call = Call::new(python, &["-B", "tests/window/drive.py"]);
    let view = built("debug", "penombre-view");
    call.env("PENOMBRE_VIEW_BIN", view).env("PENOMBRE_BIN", release_binary())
}

fn is_program(name: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(name).is_file())
}

/// Whether a line of `ldconfig -p` begins with that library.
fn names_library(list: &str, library: &str) -> bool {
    list.lines().any(|line| line.split_whitespace().next() == Some(library))
}

fn has_driver(folder: impl AsRef<Path>) -> bool {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|e| e.file_name()).any(|name| name.to_string_lossy().starts_with(SOFTWARE_DRIVER))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_are_found_by_their_whole_name() {
        let list =
            "2 libs found in cache\n\tlibXi.so.6 (libc6,x86-64) => /lib/libXi.so.6\n\tlibEGL.so.10 (x)\n";
        assert!(names_library(list, "libXi.so.6"));
        assert!(!names_library(list, "libEGL.so.1") && !names_library(list, "libXi"));
    }

    #[test]
    fn everything_that_is_missing_is_named() {
        let nothing = Screen { driver: false, missing: vec!["Xvfb"] };
        assert!(!nothing.is_whole());
        assert!(nothing.why_not().starts_with("missing: a software driver for Vulkan, Xvfb (Debian"));
        assert!(Screen { driver: true, missing: Vec::new() }.is_whole());
        assert!(!Screen { driver: true, missing: vec!["xdotool"] }.is_whole());
    }
}
