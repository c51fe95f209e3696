//! Installing what Debian has and a check needs.

use crate::run::Call;

/// Installs Debian packages if this is a Debian system and we are its root; says so before. Whether it did.
pub fn install(what: &str, packages: &[&str]) -> bool {
    if !may_install() {
        return false;
    }
    println!("{what}: missing, installing {} with apt-get", packages.join(" "));
    let arguments = [["install", "-y", "--no-install-recommends"].as_slice(), packages].concat();
    Call::new("apt-get", &["update"]).status().is_ok() && Call::new("apt-get", &arguments).status().is_ok()
}

fn may_install() -> bool {
    let root = Call::new("id", &["-u"]).output().is_ok_and(|id| id.trim() == "0");
    root && Call::new("apt-get", &["--version"]).succeeds()
}
