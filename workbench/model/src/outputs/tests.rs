//! Outputs at links, devices and pipes.

use std::fs::Permissions;
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _, symlink};
use std::path::Path;

use super::{Staged, plan, write, write_all};

#[test]
fn a_link_stays_and_its_file_is_replaced() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("deep")).expect("a folder");
    std::fs::write(at("deep/real.csv"), "before").expect("written");
    std::fs::set_permissions(at("deep/real.csv"), Permissions::from_mode(0o600)).expect("set");
    symlink("deep/real.csv", at("first")).expect("a link");
    symlink("first", at("second")).expect("a link");
    symlink("deep/absent.csv", at("dangling")).expect("a link");
    symlink("circle", at("circle")).expect("a link");
    for (link, real) in [("second", "deep/real.csv"), ("dangling", "deep/absent.csv")] {
        write(&at(link), "after").expect("written");
        assert!(at(link).is_symlink() && !at(real).is_symlink(), "{link}");
        assert_eq!(std::fs::read_to_string(at(real)).expect("there"), "after");
    }
    assert_eq!(at("deep/real.csv").metadata().expect("there").permissions().mode() & 0o777, 0o600);
    let circle = write(&at("circle"), "x").expect_err("a circle").to_string();
    assert!(circle.ends_with("circle is a circle of links; choose another name"), "{circle}");
    let input = plan(&[&at("first")], &[at("deep/real.csv")]).expect_err("an input").to_string();
    assert!(input.contains("is an input"), "{input}");
    let two = plan(&[&at("first"), &at("second")], &[]).expect_err("one file").to_string();
    assert!(two.contains("two outputs"), "{two}");
    symlink("nowhere/x.csv", at("lost")).expect("a link");
    let lost = plan(&[&at("lost")], &[]).expect_err("no folder").to_string();
    assert!(lost.contains("there is no folder"), "{lost}");
}

/// A device is written to, so it fails as the device does, and the files that go with it are not left alone.
#[test]
fn devices_stay_devices() {
    let folder = tempfile::tempdir().expect("a folder");
    let (link, model) = (folder.path().join("link"), folder.path().join("model"));
    symlink("/dev/null", &link).expect("a link");
    for path in [Path::new("/dev/null"), &link] {
        plan(&[path, path], &[]).expect("anything may go there twice");
        write(path, "x").expect("taken");
    }
    assert!(link.is_symlink() && Path::new("/dev/null").metadata().expect("there").file_type().is_char_device());
    if Path::new("/dev/full").exists() {
        let full = write_all(&[(&model, b"model"), (Path::new("/dev/full"), b"page")]).expect_err("full");
        assert!(full.to_string().contains("/dev/full"), "{full}");
        assert!(Path::new("/dev/full").metadata().expect("there").file_type().is_char_device());
        assert!(!model.exists(), "half of the outputs");
    }
}

#[test]
fn what_goes_into_a_pipe_comes_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let pipe = folder.path().join("pipe.csv");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: mkfifo is not installed");
        return;
    }
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read_to_string(pipe)
    });
    write(&pipe, "a,b\n".repeat(50_000)).expect("written");
    assert_eq!(reader.join().expect("no panic").expect("read").len(), 200_000);
    assert!(pipe.metadata().expect("there").file_type().is_fifo());
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing temporary is left");
}

#[test]
fn the_temporary_file_ends_like_the_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let long = format!("{}.csv.gz", "ü".repeat(120));
    for name in ["a.csv.gz", long.as_str()] {
        let mut staged = Staged::new(&folder.path().join(name)).expect("a temporary file");
        assert!(staged.path().to_string_lossy().ends_with(".csv.gz"));
        staged.file().set_len(3).expect("written");
        staged.finish().expect("renamed");
        assert_eq!(folder.path().join(name).metadata().expect("there").len(), 3);
    }
}
