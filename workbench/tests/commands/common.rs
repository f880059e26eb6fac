//! Helpers that run the command in a folder.

use std::path::Path;
use std::process::{Command, Output};

/// Runs the command; the arguments are separated by spaces.
pub fn run(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bearing-watch"));
    command.current_dir(folder).args(arguments.split_whitespace()).output().expect("the command starts")
}

/// Standard output of a command that must succeed.
pub fn succeed(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{arguments}\n{out}{err}");
    out.into_owned()
}

/// Runs a command that must fail: exit code 2, one line of error, no output, and no new file.
pub fn refuse(folder: &Path, arguments: &str, expected: &[&str]) {
    let files = || {
        let mut names: Vec<_> = std::fs::read_dir(folder).expect("folder").map(|e| e.expect("entry").path()).collect();
        names.sort();
        names
    };
    let before = files();
    let output = run(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments}\n{error}");
    assert_eq!(error.trim_end().lines().count(), 1, "{arguments}\n{error}");
    assert!(output.stdout.is_empty(), "{arguments}");
    for words in expected {
        assert!(error.contains(words), "{arguments}\nmissing {words:?} in {error}");
    }
    assert_eq!(files(), before, "{arguments}");
}
