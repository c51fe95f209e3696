//! The promises of `write_atomic`, with files.

use penombre_sys::{TEMPORARY_SUFFIX, check_writable, write_atomic};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

fn leftovers(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder exists").flatten().map(|e| e.path());
    entries.filter(|p| p.to_string_lossy().ends_with(TEMPORARY_SUFFIX)).collect()
}

fn save(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_atomic(path, |w| w.write_all(bytes))
}

#[test]
fn new_and_existing_files_get_the_whole_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    let big: Vec<u8> = (0..300_000u32).map(|i| (i * 7) as u8).collect();
    save(&path, &big).unwrap();
    assert_eq!(fs::read(&path).unwrap(), big);
    save(&path, b"short").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"short");
    assert!(leftovers(folder.path()).is_empty());
}

#[test]
fn very_long_names_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("é".repeat(127));
    check_writable(&path).unwrap();
    save(&path, b"x").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"x");
}

#[test]
fn a_failure_keeps_the_old_file_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    save(&path, b"old").unwrap();
    let error = write_atomic(&path, |w| {
        w.write_all(&[0; 200_000])?;
        Err(io::Error::other("disk full"))
    })
    .unwrap_err();
    assert_eq!(error.to_string(), "disk full");
    let panicked = std::panic::catch_unwind(|| write_atomic(&path, |_| panic!("expected in this test")));
    assert!(panicked.is_err());
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert!(leftovers(folder.path()).is_empty());
}

#[test]
fn missing_folder_and_folder_as_target_are_refused_early() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("none/a.png");
    for result in [check_writable(&missing), save(&missing, b"")] {
        let error = result.unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(error.to_string().contains("none does not exist"), "{error}");
    }
    for result in [check_writable(folder.path()), save(folder.path(), b"")] {
        assert_eq!(result.unwrap_err().kind(), io::ErrorKind::IsADirectory);
    }
    let file = folder.path().join("file");
    save(&file, b"1").unwrap();
    assert!(check_writable(&file.join("below")).is_err());
    check_writable(&file).unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"1", "the check changes nothing");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "the check leaves nothing");
}

#[test]
fn write_protected_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    save(&path, b"old").unwrap();
    let mut permissions = fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).unwrap();
    assert_eq!(check_writable(&path).unwrap_err().kind(), io::ErrorKind::PermissionDenied);
    assert_eq!(save(&path, b"new").unwrap_err().kind(), io::ErrorKind::PermissionDenied);
    assert_eq!(fs::read(&path).unwrap(), b"old");
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    #[test]
    fn permission_bits_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        save(&path, b"old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        save(&path, b"new").unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    fn links_stay_and_their_targets_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (far, near) = (folder.path().join("far"), folder.path().join("near"));
        fs::create_dir(&far).unwrap();
        symlink("far/real.bin", &near).unwrap();
        for content in [&b"one"[..], b"two"] {
            save(&near, content).unwrap();
            assert!(fs::symlink_metadata(&near).unwrap().is_symlink());
            assert_eq!(fs::read(far.join("real.bin")).unwrap(), content);
        }
        symlink("loop", folder.path().join("loop")).unwrap();
        assert!(save(&folder.path().join("loop"), b"").is_err());
    }

    #[test]
    fn devices_are_written_in_place() {
        save(Path::new("/dev/null"), b"gone").unwrap();
        check_writable(Path::new("/dev/null")).unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        if cfg!(target_os = "linux") {
            assert_eq!(save(Path::new("/dev/full"), b"x").unwrap_err().kind(), io::ErrorKind::StorageFull);
        }
    }

    /// Not a test of its own: the other process of the tests below, chosen by the environment.
    #[test]
    fn child_process() {
        match std::env::var("PENOMBRE_SYS_CHILD").as_deref() {
            Ok("slow") => {
                let path = PathBuf::from(std::env::var_os("PENOMBRE_SYS_PATH").unwrap());
                let _ = write_atomic(&path, |w| {
                    w.write_all(&[1; 100_000])?;
                    std::thread::sleep(Duration::from_secs(60));
                    Ok(())
                });
            }
            Ok("stdout") => save(Path::new("/dev/stdout"), b"<picture>").unwrap(),
            _ => {}
        }
    }

    fn child(mode: &str, path: &Path) -> Command {
        let mut command = Command::new(std::env::current_exe().expect("the test has a file"));
        command.args(["--exact", "unix::child_process", "--nocapture", "--test-threads=1"]);
        command.env("PENOMBRE_SYS_CHILD", mode).env("PENOMBRE_SYS_PATH", path);
        command
    }

    #[test]
    fn a_killed_save_keeps_the_old_file_and_the_next_save_cleans_up() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        save(&path, b"old").unwrap();
        let mut process = child("slow", &path).stdout(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while !leftovers(folder.path()).iter().any(|p| fs::metadata(p).is_ok_and(|m| m.len() > 0)) {
            assert!(start.elapsed() < Duration::from_secs(20), "the other process never began to write");
            std::thread::sleep(Duration::from_millis(5));
        }
        let theirs = leftovers(folder.path());
        check_writable(&path).unwrap();
        save(&path, b"mine").unwrap();
        assert_eq!(leftovers(folder.path()), theirs, "a living process keeps its temporary file");
        process.kill().unwrap();
        process.wait().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"mine");
        assert_eq!(leftovers(folder.path()).len(), 1);
        save(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!(leftovers(folder.path()).is_empty(), "the dead process's file is gone");
    }

    #[test]
    fn standard_output_is_appended_to_wherever_it_goes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        fs::write(&path, "before ").unwrap();
        let out = fs::OpenOptions::new().append(true).open(&path).unwrap();
        assert!(child("stdout", &path).stdout(out).status().unwrap().success());
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("before ") && text.contains("<picture>"), "{text}");
        let piped = child("stdout", &path).output().unwrap();
        assert!(String::from_utf8(piped.stdout).unwrap().contains("<picture>"));
    }

    #[test]
    fn stale_files_of_other_targets_stay_and_old_ones_go() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let other =
            folder.path().join(format!(".b.bin.0123456789abcdef.00000000-999999-0{TEMPORARY_SUFFIX}"));
        fs::write(&other, b"").unwrap();
        // A name of this target, written by a living process, then aged by two days.
        let held = write_atomic(&path, |_| {
            let name = leftovers(folder.path()).into_iter().find(|p| *p != other).unwrap();
            let text = name.to_string_lossy().into_owned();
            let copy = PathBuf::from(text.replace(TEMPORARY_SUFFIX, &format!("9{TEMPORARY_SUFFIX}")));
            let file = fs::File::create(&copy)?;
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(2 * 86_400))
        });
        held.unwrap();
        assert_eq!(leftovers(folder.path()).len(), 2);
        save(&path, b"x").unwrap();
        assert_eq!(leftovers(folder.path()), [other]);
    }
}
