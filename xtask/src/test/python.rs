//! Finding a Python for the oracle.

use crate::run::Call;

/// A working `python3`; on Debian, as root, installed if it is missing.
pub fn find_or_install() -> Option<String> {
    find().or_else(|| {
        if !may_install() {
            return None;
        }
        println!("python3 is missing: installing it with apt-get");
        Call::new("apt-get", &["update"]).status().ok()?;
        Call::new("apt-get", &["install", "-y", "python3"]).status().ok()?;
        find()
    })
}

fn find() -> Option<String> {
    let works = |name: &&str| {
        Call::new(*name, &["-c", "import sys; sys.exit(sys.version_info < (3, 11))"]).succeeds()
    };
    ["python3", "python"].iter().find(|name| works(name)).map(|&name| name.to_owned())
}

/// Whether this is a Debian system and we are its root.
fn may_install() -> bool {
    let root = Call::new("id", &["-u"]).output().is_ok_and(|id| id.trim() == "0");
    root && Call::new("apt-get", &["--version"]).succeeds()
}
