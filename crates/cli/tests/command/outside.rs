//! What the command opens: files of the scene, its outputs and what every program needs of the system, and no socket.

use super::corpus::textured;
use super::{Folder, test_data};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the runtime of a program reads: shared libraries, how they are found, and how much memory and how many processors it
/// may use.
const SYSTEM: [&str; 8] = [
    "/etc/ld.so.cache",
    "/lib/",
    "/lib64/",
    "/usr/lib/",
    "/usr/lib64/",
    "/proc/self/",
    "/proc/meminfo",
    "/sys/fs/cgroup/",
];

/// What `strace` saw of a run of the command.
struct Seen {
    status: Option<i32>,
    opened: Vec<PathBuf>,
    sockets: Vec<String>,
}

fn has_strace() -> bool {
    let found = Command::new("strace").arg("-V").output().is_ok_and(|o| o.status.success());
    if !found {
        eprintln!("NOT RUN: strace is not there, so what the command opens was not looked at");
    }
    found
}

fn seen(folder: &Folder, arguments: &[&str]) -> Seen {
    let log = tempfile::NamedTempFile::new().unwrap();
    let calls = "trace=open,openat,openat2,creat,socket,connect,execve";
    let output = Command::new("strace")
        .args(["-f", "-qq", "-s", "4096", "-e", calls, "-e", "signal=none", "-o"])
        .arg(log.path())
        .arg(env!("CARGO_BIN_EXE_penombre"))
        .args(arguments)
        // Cargo's folders, in which the system would look for libraries.
        .env_remove("LD_LIBRARY_PATH")
        .current_dir(folder.0.path())
        .output()
        .unwrap();
    let text = std::fs::read_to_string(log.path()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.iter().any(|l| l.contains("execve(")), "{text}");
    let programs = lines.iter().filter(|l| l.contains("execve(")).count();
    assert_eq!(programs, 1, "another program was started: {text}");
    let opens = |l: &str| ["open(", "openat(", "openat2(", "creat("].iter().any(|call| l.contains(call));
    let opened = lines.iter().filter(|l| opens(l) && !l.contains("execve(")).map(|line| {
        let name = line.split('"').nth(1).unwrap_or_else(|| panic!("a call without a name: {line}"));
        folder.0.path().join(name)
    });
    let sockets = lines.iter().filter(|l| l.contains("socket(") || l.contains("connect("));
    Seen {
        status: output.status.code(),
        opened: opened.collect(),
        sockets: sockets.map(|l| (*l).to_owned()).collect(),
    }
}

/// Checks that nothing was opened but what lies in the folders or belongs to the system.
fn assert_inside(seen: &Seen, folders: &[&Path], run: &[&str]) {
    assert!(seen.sockets.is_empty(), "{run:?}: {:?}", seen.sockets);
    assert!(seen.status.is_some(), "{run:?}: a signal");
    for path in &seen.opened {
        let is_of_system = SYSTEM.iter().any(|known| path.to_string_lossy().starts_with(known));
        let goes_up = path.components().any(|part| part.as_os_str() == "..");
        let is_inside = !goes_up && folders.iter().any(|folder| path.starts_with(folder));
        assert!(is_of_system || is_inside, "{run:?} opened {}", path.display());
    }
}

#[test]
fn nothing_outside_of_the_scenes_folder_is_opened() {
    if !cfg!(target_os = "linux") || !has_strace() {
        return;
    }
    let outside = Folder::new();
    outside.write("secret.mtl", "newmtl secret\n");
    let folder = Folder::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let picture = penombre_image::Image::from_data(1, 1, 3, vec![0.5; 3]).unwrap();
    penombre_image::save(&folder.path("good.png"), &picture, &Default::default()).unwrap();
    let secret = outside.path("secret.mtl");
    let secret = secret.to_str().unwrap();
    folder.write("good.obj", &format!("mtllib good.mtl\nusemtl a\n{triangle}"));
    folder.write("good.mtl", "newmtl a\nKd 1 1 1\nmap_Kd good.png\n");
    folder.write("good.toml", &textured("good.png"));
    folder.write("library.obj", &format!("mtllib ../../../../etc/passwd {secret}\nusemtl a\n{triangle}"));
    folder.write("map.obj", &format!("mtllib map.mtl\nusemtl a\n{triangle}"));
    folder.write(
        "map.mtl",
        "newmtl a\nmap_Kd /etc/passwd\nmap_Ks file:///etc/passwd\nmap_d \\\\host\\share\\a.png\n",
    );
    folder.write("absolute.toml", &textured(secret));
    folder.write("address.toml", &textured("http://127.0.0.1:9/a.png"));
    folder.write("up.toml", &textured("sub/../../x.png"));
    folder.write("device.toml", &textured("/dev/zero"));
    folder.write(
        "include.toml",
        "penombre = 1\ninclude = [\"../../etc/hostname\", \"https://a.example/b.toml\"]\n",
    );
    folder.write("link.toml", &textured("link.png"));
    #[cfg(unix)]
    std::os::unix::fs::symlink(secret, folder.path("link.png")).unwrap();
    let cases = [("good.obj", 0), ("good.toml", 0), ("cornell", 0), ("library.obj", 2), ("map.obj", 2)];
    let more =
        [("absolute.toml", 2), ("address.toml", 2), ("up.toml", 2), ("device.toml", 2), ("include.toml", 2)];
    for (scene, status) in cases.into_iter().chain(more).chain([("link.toml", 2)]) {
        let run = ["render", scene, "--size", "16x12", "--spp", "1", "-o", "out.png"];
        let seen = seen(&folder, &run);
        assert_eq!(seen.status, Some(status), "{scene}");
        assert_inside(&seen, &[folder.0.path()], &run);
        // The measure sees what is opened.
        let file = if scene == "cornell" { "out.png" } else { scene };
        assert!(seen.opened.iter().any(|p| p.to_string_lossy().contains(file)), "{:?}", seen.opened);
    }
    let run = ["convert", "good.png", "out.exr"];
    assert_inside(&seen(&folder, &run), &[folder.0.path()], &run);
    // A folder that is allowed is read, and the measure finds that it is another one.
    let root = outside.0.path().to_str().unwrap();
    let run =
        ["render", "library.obj", "--asset-root", root, "--size", "16x12", "--spp", "1", "-o", "out.png"];
    assert_inside(&seen(&folder, &run), &[folder.0.path(), outside.0.path()], &run);
}

/// The whole corpus. Long: with `PENOMBRE_SLOW` only.
#[test]
fn no_broken_file_makes_it_look_outside() {
    if std::env::var_os("PENOMBRE_SLOW").is_none() || !cfg!(target_os = "linux") || !has_strace() {
        return;
    }
    let Some(inputs) = test_data("bad-inputs") else { return };
    let folder = Folder::new();
    let index = std::fs::read_to_string(inputs.join("INDEX.tsv")).unwrap();
    let mut count = 0;
    for line in index.lines().filter(|l| !l.starts_with('#') && l.contains('\t')) {
        let path = inputs.canonicalize().unwrap().join(line.split('\t').next().unwrap());
        let own = path.parent().unwrap().to_owned();
        let path = path.to_str().unwrap();
        let mut runs = vec![vec!["render", path, "--size", "8x8", "--spp", "1", "-o", "out.png"]];
        if line.starts_with("images/") {
            runs.push(vec!["convert", path, "out.exr"]);
        }
        for run in runs {
            assert_inside(&seen(&folder, &run), &[folder.0.path(), &own], &run);
            count += 1;
        }
    }
    assert!(count > 300, "{count}");
}
