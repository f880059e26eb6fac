//! The commands of the book's chapter for test engineers, and what the chapter quotes of their output.
//!
//! A block below `<!-- transcript -->` has commands after `$ ` and lines of their output; a block below the name of a
//! file is that file. Blocks are taken in their order, all in one folder.

use std::path::Path;
use std::process::Command;

const CHAPTER: &str = "../../book/src/test-engineer.md";

/// The marked blocks: marker and lines.
fn blocks(text: &str) -> Vec<(String, Vec<&str>)> {
    let mut blocks = Vec::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let marker = line.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->"));
        if let Some(marker) = marker
            && lines.next_if(|next| next.starts_with("```")).is_some()
        {
            let own = lines.by_ref().take_while(|line| *line != "```").collect();
            blocks.push((marker.to_owned(), own));
        }
    }
    blocks
}

/// Commands and the lines that are quoted below each. A command goes on in the next line after a backslash.
fn transcript<'t>(lines: &[&'t str]) -> Vec<(String, Vec<&'t str>)> {
    let mut commands: Vec<(String, Vec<&str>)> = Vec::new();
    for line in lines {
        match (line.strip_prefix("$ "), commands.last_mut()) {
            (Some(command), _) => commands.push((command.to_owned(), vec![])),
            (None, Some((command, quoted))) if command.ends_with('\\') && quoted.is_empty() => {
                *command = format!("{command}\n{line}");
            }
            (None, Some((_, quoted))) => quoted.push(line),
            (None, None) => panic!("a line before the first command: {line}"),
        }
    }
    commands
}

/// Output and error of a command, with `bearing-watch` on the search path. Exit code 2 is an error of the command; 1
/// says that an audit has found something.
fn printed(folder: &Path, command: &str) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_bearing-watch"));
    let own = program.parent().expect("a folder").to_path_buf();
    let rest = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([own].into_iter().chain(std::env::split_paths(&rest))).expect("a search path");
    let mut shell = Command::new("bash");
    let output = shell.args(["-c", command]).current_dir(folder).env("PATH", path).output().expect("bash starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code().is_some_and(|code| code < 2), "{command}\n{text}{error}");
    text + &error
}

/// The first quoted line that is not in the output, in its order; `…` at the end of a quoted line is any rest.
fn missing<'q>(quoted: &[&'q str], output: &str) -> Option<&'q str> {
    let mut lines = output.lines();
    quoted.iter().copied().find(|quoted| {
        let start = quoted.strip_suffix('…').map(str::trim_end);
        !lines.any(|line| start.map_or(line == *quoted, |start| line.starts_with(start)))
    })
}

#[test]
fn the_chapter_for_test_engineers_does_what_it_says() {
    let chapter = std::fs::read_to_string(CHAPTER).expect("the chapter");
    let folder = tempfile::tempdir().expect("folder");
    let mut run = 0;
    for (marker, lines) in blocks(&chapter) {
        if marker != "transcript" {
            std::fs::write(folder.path().join(&marker), lines.join("\n") + "\n").expect("writable");
            continue;
        }
        for (command, quoted) in transcript(&lines) {
            let output = printed(folder.path(), &command);
            assert_eq!(missing(&quoted, &output), None, "{command} does not print this line; it prints\n{output}");
            run += 1;
        }
    }
    assert!(run >= 10, "{run} commands");
    for file in ["audit.html", "train.html", "evaluate.html", "replay.html", "drive.bwm", "model.rs", "model.h"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn lines_that_are_not_printed_are_found() {
    let output = "one 1\ntwo 2\nthree 3\n";
    assert_eq!(missing(&["one 1", "thr…"], output), None);
    assert_eq!(missing(&["two 2", "one 1"], output), Some("one 1"), "in another order");
    assert_eq!(missing(&["two"], output), Some("two"), "not the whole line");
    assert_eq!(missing(&["one 1", "four…"], output), Some("four…"));
    let text = "<!-- transcript -->\n```text\n$ a \\\n  x\nb\n$ c\n```\n<!-- x.toml -->\n\n```toml\n```\n";
    let found = blocks(text);
    assert_eq!(found, [("transcript".to_owned(), vec!["$ a \\", "  x", "b", "$ c"])]);
    assert_eq!(transcript(&found[0].1), [("a \\\n  x".to_owned(), vec!["b"]), ("c".to_owned(), vec![])]);
}
