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

/// Writes a trace with another column of this name: each of its cells is that of `of`.
pub fn rewrite_column(from: &Path, to: &Path, column: &str, of: impl Fn(&str) -> String) {
    let text = std::fs::read_to_string(from).expect("a trace");
    let (head, rows) = text.split_once('\n').expect("a heading");
    let place = head.split(',').position(|own| own == column).expect("the column");
    let row = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        cells[place] = of(&cells[place]);
        cells.join(",") + "\n"
    };
    std::fs::write(to, format!("{head}\n") + &rows.lines().map(row).collect::<String>()).expect("writable");
}
