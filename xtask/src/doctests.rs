//! A crate whose manifest says that its documentation has no examples has none: they would never be compiled.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::workspace;

/// What a block of documentation that is no example is marked as.
const NO_EXAMPLE: [&str; 2] = ["text", "toml"];

/// The number of the line with the first example in the comments of a source.
fn example(source: &str) -> Option<usize> {
    let comment = |line: &str| {
        line.trim_start().strip_prefix("//").map(|rest| rest.trim_start_matches(['/', '!', ' ']).to_owned())
    };
    let fences = source.lines().enumerate().filter_map(|(place, line)| Some((place, comment(line)?)));
    let mut fences = fences.filter_map(|(place, text)| text.strip_prefix("```").map(|mark| (place, mark.to_owned())));
    // Every second one ends a block.
    let mut openings = std::iter::from_fn(|| fences.next().inspect(|_| drop(fences.next())));
    openings.find(|(_, mark)| !NO_EXAMPLE.contains(&mark.trim())).map(|(place, _)| place + 1)
}

/// The first example in each source of a folder.
fn examples(folder: &Path) -> Result<Vec<String>> {
    let mut found = Vec::new();
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(examples(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.extend(example(&fs::read_to_string(&path)?).map(|line| format!("{}:{line}", path.display())));
        }
    }
    Ok(found)
}

#[test]
fn crates_without_documentation_tests_have_no_examples() -> Result<()> {
    let root = workspace::root();
    let mut folders: Vec<PathBuf> =
        ["attack", "c-api", "host-tests", "python", "target-tests"].map(|name| root.join(name)).into();
    for entry in root.join("workbench").read_dir()? {
        folders.push(entry?.path());
    }
    let (mut without, mut found) = (0, Vec::new());
    for folder in folders {
        if fs::read_to_string(folder.join("Cargo.toml"))?.contains("\ndoctest = false\n") {
            without += 1;
            found.extend(examples(&folder.join("src"))?);
        }
    }
    assert!(without > 0 && found.is_empty(), "examples that no test compiles: {found:?}");
    Ok(())
}

#[test]
fn an_example_is_a_block_without_a_mark_of_another_language() {
    assert_eq!(example("//! ```text\n//! a\n//! ```\n\n/// ```\n/// f();\n/// ```\n"), Some(5));
    assert_eq!(example("//! ```text\n//! a\n//! ```\n/// ```toml\n/// a = 1\n/// ```\n"), None);
}
