//! Finding strace, by which a test sees what the command opens.

use super::apt;
use crate::run::Call;

/// True if strace works; on Debian, as root, it is installed if it is missing. There is none but on Linux.
pub fn is_there_or_installed() -> bool {
    let works = || Call::new("strace", &["-V"]).succeeds();
    !cfg!(target_os = "linux") || works() || (apt::install("strace", &["strace"]) && works())
}
