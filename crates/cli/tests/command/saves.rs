//! Saves that never destroy: killed, on a full disk, in a folder that cannot be written.
#![cfg(target_os = "linux")]

use super::{Folder, names, text};
use penombre_image::{Image, WriteOptions, save};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A picture that no format makes much smaller.
fn noise(width: u32, height: u32, seed: u32) -> Image {
    let mut state = seed.wrapping_mul(2_654_435_761) | 1;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as f32 / u32::MAX as f32
    };
    let data = (0..width as usize * height as usize * 3).map(|_| next()).collect();
    Image::from_data(width, height, 3, data).unwrap()
}

fn temporaries(folder: &Path) -> usize {
    names(folder).iter().filter(|name| name.ends_with(".penombre-tmp")).count()
}

#[test]
fn a_save_that_is_killed_leaves_the_old_file_or_the_new_one() {
    let kills = if std::env::var_os("PENOMBRE_SLOW").is_some() { 100 } else { 10 };
    let folder = Folder::new();
    for (name, seed) in [("a.pfm", 1), ("b.pfm", 2)] {
        save(&folder.path(name), &noise(1600, 1200, seed), &WriteOptions::default()).unwrap();
    }
    let contents: Vec<Vec<u8>> = ["a.pfm", "b.pfm"].map(|n| std::fs::read(folder.path(n)).unwrap()).into();
    std::fs::create_dir(folder.path("out")).unwrap();
    let target = folder.path("out/x.pfm");
    folder.ok(&["convert", "a.pfm", "out/x.pfm"]);
    let (mut in_mid_save, mut present) = (0, 0);
    for kill in 0..kills {
        let input = ["b.pfm", "a.pfm"][kill % 2];
        let mut process =
            folder.command(&["convert", input, "out/x.pfm"]).stdout(Stdio::null()).spawn().unwrap();
        // From the moment at which the new file is begun, a little later each time.
        let start = Instant::now();
        let mine = format!("-{}-", process.id());
        let begun = || {
            let entries = std::fs::read_dir(folder.path("out")).unwrap().flatten();
            let mut files = entries.filter(|e| e.file_name().to_string_lossy().contains(&mine));
            files.any(|e| e.metadata().is_ok_and(|m| m.len() > 0))
        };
        while !begun() && process.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(20) {
            std::thread::yield_now();
        }
        std::thread::sleep(Duration::from_micros((kill as u64 * 7919) % 23 * 500));
        process.kill().unwrap();
        let status = process.wait().unwrap();
        let found = std::fs::read(&target).unwrap();
        let whole = contents.iter().position(|c| *c == found);
        assert!(
            whole.is_some(),
            "kill {kill}: {} bytes that are neither the old nor the new file",
            found.len()
        );
        in_mid_save += usize::from(status.code() != Some(0) && temporaries(&folder.path("out")) > 0);
        present = whole.unwrap();
    }
    assert!(in_mid_save * 2 >= kills, "only {in_mid_save} of {kills} kills met a save");
    folder.ok(&["convert", ["b.pfm", "a.pfm"][present], "out/x.pfm"]);
    assert_eq!(std::fs::read(&target).unwrap(), contents[1 - present]);
    assert_eq!(names(&folder.path("out")), ["x.pfm"], "the next save has cleaned up");
}

/// A small disk in memory, gone when dropped.
struct Disk(PathBuf);

impl Disk {
    /// `None`, and a word about it, without the right to mount.
    fn new(place: &Path, test: &str) -> Option<Self> {
        std::fs::create_dir(place).unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=2M", "tmpfs"])
            .arg(place)
            .stderr(Stdio::null())
            .status();
        if mounted.is_ok_and(|status| status.success()) {
            return Some(Self(place.to_path_buf()));
        }
        eprintln!("NOT RUN: {test} (it needs the right to mount a small tmpfs: run it as root)");
        None
    }

    fn make_read_only(&self) {
        let status = Command::new("mount").args(["-o", "remount,ro"]).arg(&self.0).status();
        assert!(status.unwrap().success());
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

const FORMATS: [&str; 10] = ["png", "jpg", "ppm", "pgm", "pfm", "exr", "hdr", "tga", "bmp", "webp"];

#[test]
fn a_full_disk_keeps_the_old_file_and_is_told() {
    let folder = Folder::new();
    let Some(disk) = Disk::new(&folder.path("disk"), "a_full_disk_keeps_the_old_file_and_is_told") else {
        return;
    };
    save(&folder.path("a.exr"), &noise(200, 150, 3), &WriteOptions::default()).unwrap();
    save(&folder.path("b.exr"), &noise(200, 150, 4), &WriteOptions::default()).unwrap();
    for format in FORMATS {
        let output = format!("disk/x.{format}");
        let heat = output.clone();
        folder.ok(&["convert", "a.exr", &output]);
        let old = std::fs::read(folder.path(&output)).unwrap();
        // Free pages from none up to nearly enough: each write of the save meets the end once.
        for free in (0..old.len() / 4096).step_by((old.len() / 4096 / 6).max(1)) {
            fill(&disk.0, free * 4096);
            for arguments in [vec!["convert", "b.exr", &output], vec!["diff", "a.exr", "b.exr", "-o", &heat]]
            {
                // The picture of the differences is smaller than the pictures in most formats.
                if arguments[0] == "diff" && free > 0 {
                    continue;
                }
                let said = folder.run(&arguments);
                assert!(said.status.code().is_some_and(|c| c != 0), "{format}, {free} pages: {arguments:?}");
                let words = text(&said.stderr);
                assert!(words.contains("not saved") && words.contains("No space"), "{words}");
            }
            assert!(std::fs::read(folder.path(&output)).unwrap() == old, "{format}, {free} pages free");
            assert_eq!(temporaries(&disk.0), 0, "{format}");
        }
        let said = folder.refused(&["render", "cornell", "--size", "64x64", "-o", &output]);
        assert!(said.contains("MiB free on that disk"), "{said}");
        std::fs::remove_file(disk.0.join("filler")).unwrap();
        folder.ok(&["convert", "b.exr", &output]);
        assert!(std::fs::read(folder.path(&output)).unwrap() != old, "{format}");
        std::fs::remove_file(folder.path(&output)).unwrap();
    }
}

/// Fills the disk but for so many bytes.
fn fill(disk: &Path, free: usize) {
    let filler = disk.join("filler");
    let _ = std::fs::remove_file(&filler);
    let room = usize::try_from(penombre_sys::available_space(disk).unwrap()).unwrap();
    std::fs::write(&filler, vec![1; room.saturating_sub(free)]).unwrap();
}

/// The system's signal for that would end the command in mid-save.
#[test]
fn a_file_beyond_the_allowed_size_is_told_and_leaves_nothing() {
    let folder = Folder::new();
    save(&folder.path("a.exr"), &noise(200, 150, 6), &WriteOptions::default()).unwrap();
    folder.ok(&["convert", "a.exr", "old.png"]);
    let old = std::fs::read(folder.path("old.png")).unwrap();
    assert!(old.len() > 1 << 16);
    for output in ["old.png", "new.png"] {
        // Blocks of 512 bytes: more than the messages take, less than the picture.
        let said = Command::new("sh")
            .args([
                "-c",
                "ulimit -f 64; exec \"$0\" convert a.exr \"$1\"",
                env!("CARGO_BIN_EXE_penombre"),
                output,
            ])
            .current_dir(folder.0.path())
            .output()
            .unwrap();
        let words = text(&said.stderr);
        assert_eq!(said.status.code(), Some(1), "{words}");
        assert!(words.contains("not saved") && words.contains("too large"), "{words}");
    }
    assert!(std::fs::read(folder.path("old.png")).unwrap() == old);
    assert_eq!(names(folder.0.path()), ["a.exr", "old.png"]);
}

#[test]
fn a_folder_that_cannot_be_written_is_told_at_once() {
    let folder = Folder::new();
    let test = "a_folder_that_cannot_be_written_is_told_at_once";
    let Some(disk) = Disk::new(&folder.path("disk"), test) else { return };
    save(&folder.path("a.exr"), &noise(64, 48, 5), &WriteOptions::default()).unwrap();
    folder.ok(&["convert", "a.exr", "disk/x.png"]);
    let old = std::fs::read(folder.path("disk/x.png")).unwrap();
    disk.make_read_only();
    for arguments in [
        vec!["convert", "a.exr", "disk/x.png"],
        vec!["convert", "a.exr", "disk/new.png"],
        vec!["render", "cornell", "--spp", "100000", "-o", "disk/x.png"],
        vec!["diff", "a.exr", "a.exr", "-o", "disk/x.png"],
    ] {
        let start = Instant::now();
        let said = folder.refused(&arguments);
        assert!(start.elapsed() < Duration::from_secs(2), "{arguments:?}");
        assert!(said.contains("Read-only") && said.contains("disk"), "{said}");
    }
    assert!(std::fs::read(folder.path("disk/x.png")).unwrap() == old);
    assert_eq!(names(&disk.0), ["x.png"]);
}
