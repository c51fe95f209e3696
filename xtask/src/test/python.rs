//! Finding a Python for the oracle and for the tests of the window.

use super::apt;
use crate::run::Call;

/// A working `python3`; on Debian, as root, installed if it is missing.
pub fn find_or_install() -> Option<String> {
    find().or_else(|| apt::install("python3", &["python3"]).then(find).flatten())
}

/// A working `python3` of 3.11 or newer.
pub fn find() -> Option<String> {
    let works = |name: &&str| {
        Call::new(*name, &["-c", "import sys; sys.exit(sys.version_info < (3, 11))"]).succeeds()
    };
    ["python3", "python"].iter().find(|name| works(name)).map(|&name| name.to_owned())
}
