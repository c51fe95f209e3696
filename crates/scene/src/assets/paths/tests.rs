use super::*;
use std::fs;

struct Tree {
    folder: tempfile::TempDir,
}

impl Tree {
    /// `scene/` with a file and a folder, `other/` beside it.
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for name in ["scene/sub", "other", "scene-two"] {
            fs::create_dir_all(folder.path().join(name)).expect("made");
        }
        for name in ["scene/a.png", "scene/sub/b.png", "other/c.png", "scene-two/d.png"] {
            fs::write(folder.path().join(name), name).expect("written");
        }
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().canonicalize().expect("exists").join(name)
    }

    fn find(&self, base: &str, name: &str) -> Result<PathBuf, PathFault> {
        resolve(&self.path("scene"), &[], &self.path(base), name)
    }

    fn find_with_root(&self, base: &str, name: &str) -> Result<PathBuf, PathFault> {
        resolve(
            &self.path("scene"),
            &[self.path("no-such-folder"), self.path("other")],
            &self.path(base),
            name,
        )
    }
}

#[test]
fn finds_files_below_the_roots() {
    let t = Tree::new();
    for (base, name, found) in [
        ("scene", "a.png", "scene/a.png"),
        ("scene", "./sub/../a.png", "scene/a.png"),
        ("scene", "sub/b.png", "scene/sub/b.png"),
        ("scene/sub", "../a.png", "scene/a.png"),
        ("scene/sub", "../../scene/a.png", "scene/a.png"),
    ] {
        assert_eq!(t.find(base, name), Ok(t.path(found)), "{base} {name}");
    }
    assert_eq!(t.find_with_root("scene", "../other/c.png"), Ok(t.path("other/c.png")));
    let absolute = t.path("other/c.png");
    assert_eq!(t.find_with_root("scene", absolute.to_str().expect("UTF-8")), Ok(absolute));
}

#[test]
fn refuses_what_lies_outside_whether_it_exists_or_not() {
    let t = Tree::new();
    let own = t.path("scene/a.png").to_str().expect("UTF-8").to_owned();
    for name in [
        "../other/c.png",
        "../other/no-such-file",
        "sub/../../other/c.png",
        "../scene-two/d.png",
        "../../../../../../etc/passwd",
        "/etc/passwd",
        "/no/such/file",
        "//server/share/x.png",
        "\\\\server\\share\\x.png",
        "C:\\windows\\x.png",
        "c:/x.png",
        "c:",
        own.as_str(),
    ] {
        let fault = t.find("scene", name).expect_err(name);
        assert!(matches!(fault, PathFault::Outside { .. }), "{fault:?}");
        let message = fault.to_string();
        assert!(message.contains(name) && fault.help().contains("--asset-root"), "{message}");
    }
    let fault = t.find("scene", "../other/c.png").expect_err("outside");
    let other = t.path("other");
    let help = format!("copy it there or, if you trust the scene, add `--asset-root {}`", other.display());
    assert_eq!(fault.help(), help);
}

#[test]
fn refuses_addresses() {
    let t = Tree::new();
    for name in [
        "file:///etc/passwd",
        "FILE:a.png",
        "http://h/a.png",
        "https:a",
        "data:image/png;base64,AAAA",
        "s3://b/a",
    ] {
        let fault = t.find("scene", name).expect_err(name);
        assert!(matches!(fault, PathFault::Address { .. }), "{fault:?}");
        assert!(fault.help().contains("--asset-root"));
    }
}

#[test]
fn tells_other_faults_apart() {
    let t = Tree::new();
    assert!(
        matches!(t.find("scene", "b.png"), Err(PathFault::Missing { path, .. }) if path == t.path("scene/b.png"))
    );
    let missing = t.find("scene", "sub/c.png").expect_err("missing");
    let looked_for = t.path("scene/sub/c.png");
    assert_eq!(missing.help(), format!("did you mean `b.png`? looked for {}", looked_for.display()));
    assert!(matches!(t.find("scene", "a.png/x"), Err(PathFault::Missing { .. })));
    assert!(matches!(t.find("scene", "sub"), Err(PathFault::NotAFile { found: "a folder", .. })));
    assert!(matches!(t.find("scene", ""), Err(PathFault::Invalid { .. })));
    let long = t.find("scene", &"n/".repeat(5000)).expect_err("too long").to_string();
    assert!(long.len() < 200 && long.contains("4096"), "{long}");
    let fault = t.find("scene", "a\0.png").expect_err("NUL");
    assert_eq!(
        fault.to_string(),
        "found `a\u{fffd}.png`, expected the name of a file: it has control characters"
    );
}

#[cfg(unix)]
#[test]
fn names_may_have_colons() {
    let t = Tree::new();
    for name in ["a:b.obj", "sub/c:d.obj", "12:30.obj", "sub/e:"] {
        fs::write(t.path("scene").join(name), name).expect("written");
        assert_eq!(t.find("scene", name), Ok(t.path("scene").join(name)));
    }
    for name in ["a:b/../../other/c.png", "a:/../../other/c.png"] {
        assert!(matches!(t.find("scene", name), Err(PathFault::Outside { .. })), "{name}");
    }
    std::os::unix::fs::symlink("../other/c.png", t.path("scene/o:c.png")).expect("linked");
    assert!(matches!(t.find("scene", "o:c.png"), Err(PathFault::Outside { .. })));
}

#[cfg(unix)]
#[test]
fn symbolic_links_may_not_lead_out() {
    let t = Tree::new();
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, t.path(name)).expect("linked");
    link("../other/c.png", "scene/out.png");
    link("../other", "scene/out");
    link("a.png", "scene/in.png");
    link("/dev/zero", "scene/zero.png");
    assert!(matches!(t.find("scene", "out.png"), Err(PathFault::Outside { .. })));
    assert!(matches!(t.find("scene", "out/c.png"), Err(PathFault::Outside { .. })));
    // What is there is not told either.
    assert!(matches!(t.find("scene", "out/none.png"), Err(PathFault::Outside { .. })));
    assert!(matches!(t.find("scene", "out/none/none.png"), Err(PathFault::Outside { .. })));
    assert!(matches!(t.find("scene", "sub/none/none.png"), Err(PathFault::Missing { .. })));
    assert!(matches!(t.find("scene", "zero.png"), Err(PathFault::Outside { .. })));
    assert_eq!(t.find("scene", "in.png"), Ok(t.path("scene/a.png")));
    assert_eq!(t.find_with_root("scene", "out/c.png"), Ok(t.path("other/c.png")));
    assert!(matches!(
        resolve(&t.path("scene"), &[PathBuf::from("/dev")], &t.path("scene"), "/dev/zero"),
        Err(PathFault::NotAFile { found: "a device or a pipe", .. })
    ));
}
