//! A signal to this program ends everything that it has started.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Above what a loaded machine takes to start or end a program.
const PATIENCE: Duration = Duration::from_secs(30);

/// An empty folder.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _none_before = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// A script in the place of cargo.
fn script(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, format!("#!/bin/sh\n{text}\n")).expect("a script");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("a script");
    path
}

/// A command that calls cargo and waits for it.
fn start(cargo: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command.arg("long").env("CARGO", cargo).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("this program")
}

fn wait_for(mut condition: impl FnMut() -> bool) -> bool {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if condition() {
            return true;
        }
        thread::sleep(Duration::from_millis(20));
    }
    false
}

/// Returns whether a process runs; a process that has ended and is only kept for its exit status does not.
fn runs(pid: &str) -> bool {
    let state = Command::new("ps").args(["-o", "stat=", "-p", pid]).output().expect("ps");
    let state = String::from_utf8_lossy(&state.stdout).trim().to_owned();
    !state.is_empty() && !state.starts_with('Z')
}

/// Starts, waits until the grandchild has written its number, sends the signal; everything must be gone.
fn ends(cargo: &Path, number: &Path, signal: &str) {
    let mut child = start(cargo);
    let read = || fs::read_to_string(number).unwrap_or_default().trim().to_owned();
    assert!(wait_for(|| runs(&read())), "the grandchild did not start");
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
    assert!(wait_for(|| child.try_wait().expect("a child").is_some()), "{signal} did not end the program");
    assert_eq!(child.wait().expect("a child").code(), Some(130));
    assert!(!runs(&read()), "{signal} left the grandchild");
}

#[test]
fn a_signal_ends_the_grandchildren() {
    for signal in ["-TERM", "-INT", "-HUP"] {
        let folder = folder(&format!("signal{signal}"));
        let number = folder.join("number");
        let cargo = script(&folder, "cargo", &format!("sleep 600 &\necho $! > '{}'\nwait", number.display()));
        ends(&cargo, &number, signal);
    }
}

#[test]
fn a_signal_ends_another_run_and_what_it_has_started() {
    let folder = folder("nested");
    let number = folder.join("number");
    let inner = script(&folder, "inner", &format!("sleep 600 &\necho $! > '{}'\nwait", number.display()));
    let text = format!("CARGO='{}' '{}' long", inner.display(), env!("CARGO_BIN_EXE_xtask"));
    ends(&script(&folder, "outer", &text), &number, "-TERM");
}

#[test]
fn what_does_not_listen_is_killed() {
    let folder = folder("deaf");
    let number = folder.join("number");
    let text = format!("trap '' TERM\necho $$ > '{}'\nwhile :; do sleep 1; done", number.display());
    ends(&script(&folder, "cargo", &text), &number, "-TERM");
}
